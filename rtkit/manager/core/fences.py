"""Fences off components that were made elsewhere: refuses connectors to an older one.

The owner of a system tells each manager of it in which manager a component lives, and since which
epoch: a number that grows each time the component is made elsewhere. A half of a connector that
leads to that name in another manager ends, so nothing that is sent there arrives; a new one is
refused, whoever asks for it.

See decision 79.
"""

from __future__ import annotations

import logging

from rtkit.deployment.actions import Result
from rtkit.errors import Malformed, Refused
from rtkit.manager.core.effects import Procedure
from rtkit.manager.core.halves import loosen
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.far_ends import host_of, on_host, split_far
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import parse_table

_log = logging.getLogger(__name__)
NONE = ("0", "", "")


def fence(state: ManagerState, argument: str) -> Procedure:
    """Take in where a component lives, as JSON; an empty home stands for anywhere.

    Raises:
        Refused: A later epoch is known.
    """
    asked = parse_table(argument)
    name, home, owner = (str(asked.get(key) or "") for key in ("component", "home", "owner"))
    epoch = asked.get("epoch")
    if type(epoch) is not int or not name or not owner:
        raise Malformed(f"not a component, an epoch, its home and its owner: {argument}")
    known, there, _ = state.kept.fences.get(name, NONE)
    if epoch < int(known):
        raise Refused(f"{name} is of epoch {known} now, in {there}: epoch {epoch} is past")
    if home:
        state.kept.put("fence", name, (str(epoch), home, owner))
    else:
        state.kept.drop("fence", name)
    for connector in list(state.kept.wires.values()):
        if why_fenced(state, connector):
            state.connectors.pop(connector.connector_id, None)
            yield from loosen(state, connector)
            state.kept.drop("wire", connector.connector_id)
    return Result()


def check_fence(state: ManagerState, connector: ConnectorProfile) -> None:
    """Refuse half a connector to a component that its owner has made elsewhere.

    Raises:
        Refused: It has; says where, and since which epoch.
    """
    why = why_fenced(state, connector)
    if why:
        raise Refused(why)


def why_fenced(state: ManagerState, connector: ConnectorProfile) -> str:
    """Return why half a connector leads to a component of a past epoch; empty if it does not."""
    for end in connector.ports if state.kept.fences else ():
        peer, name = split_far(end.instance)
        epoch, home, owner = state.kept.fences.get(name, NONE)
        there = peer if host_of(peer) else on_host(peer, state.host)
        if peer and home not in ("", there):
            return f"{name} in {there} is of a past epoch: {owner} has it in {home} since {epoch}"
    return ""


def check_home(state: ManagerState, name: str) -> None:
    """Refuse to make a component whose owner has it in another manager.

    Raises:
        Refused: It has; says where.
    """
    epoch, home, owner = state.kept.fences.get(name, NONE)
    if home not in ("", on_host(state.name, state.host)):
        ends = f"rtteardown or rtapply at {owner} ends that; is it gone for good, rtmgr stop here"
        raise Refused(
            f"{name} cannot be made here: {owner} has it in {home} since epoch {epoch} ({ends})"
        )


def lines(state: ManagerState) -> str:
    """Return a line for each component that has an owner: its name, epoch, home and owner."""
    return "\n".join(
        f"{name} {epoch} {home} {owner}" for name, (epoch, home, owner) in state.kept.fences.items()
    )


def note_lost(state: ManagerState, peer: str, why: str) -> None:
    """Say in the log that nothing is moved while the owner of components is away."""
    owned = [name for name, (_, _, owner) in state.kept.fences.items() if owner == peer]
    if owned:
        _log.warning("%s; it owns %s: nothing is moved until it is back", why, ", ".join(owned))
