"""Ownership of systems with movable components: recorded when applied, moved with, given up.

The record is a file of the manager on which the system was applied, whose process
`rtkit.api.owner_process` acts on it. Epochs are told to all managers of the system before a
component is made elsewhere; see decision 79.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from time import time
from typing import TYPE_CHECKING

from rtkit.errors import RtkitError, Unreachable
from rtkit.rtc.names import split_manager

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.owned import OwnedSystem
    from rtkit.tree.client import Tree


def claim(session: Session, document: SystemProfile, goal: DeploymentGoal) -> None:
    """Raise the epochs of components that a plan leads elsewhere than their owner has them."""
    known = _own(session, document)
    if known is None:
        return
    homes = _homes(session, goal)
    for name, each in known.components.items():
        if homes.get(name, each.home) != each.home:
            known = _moved(session, known, name, homes[name])


def claim_one(session: Session, name: str, home: str) -> None:
    """Raise the epoch of one component, which is moved by request, if its owner is here."""
    from rtkit.link import owned_files

    for path in owned_files.of_manager(session.usual_manager) if _is_here(session) else ():
        known = decoded(owned_files.read(path))
        if known is not None and name in known.components:
            _moved(session, known, name, home)


def _is_here(session: Session) -> bool:
    """Return whether the manager that would own a system is of this host, where its files are."""
    from rtkit.link.places import host_name
    from rtkit.rtc.names import is_local_host

    return is_local_host(session.tree.host, host_name())


def _own(session: Session, document: SystemProfile) -> OwnedSystem | None:
    """Return the record of a system, if its owner is here."""
    return read(session.usual_manager, document.profile.id) if _is_here(session) else None


def _moved(session: Session, known: OwnedSystem, name: str, home: str) -> OwnedSystem:
    known = known.moved(name, home, time(), is_stale=False)
    write(session.usual_manager, known)
    send_epoch(session.tree.trees, session.usual_manager, name, known, session.verbose)
    return known


def note(session: Session, document: SystemProfile, goal: DeploymentGoal) -> None:
    """Own a system that was applied, if components of it are movable and on other hosts."""
    from rtkit.api.gathering import is_movable
    from rtkit.deployment.owned import OwnedComponent, OwnedSystem
    from rtkit.fast_dataclass import replace

    if not _is_here(session):
        return
    name = document.profile.id
    known = read(session.usual_manager, name)
    homes = _homes(session, goal)
    named = {each.instance_name for each in document.profile.components if is_movable(each)}
    movable = {name: home for name, home in homes.items() if name in named}
    rows = dict(known.components) if known is not None else {}
    if not any(split_manager(home)[1] for home in movable.values()) and not rows:
        return
    fresh = {each: OwnedComponent(home, home, int(time())) for each, home in movable.items()}
    components = {
        each: replace(rows[each], origin=row.origin) if each in rows else row
        for each, row in fresh.items()
    }
    made = OwnedSystem(name, document.source, document.text(), components)
    write(session.usual_manager, made)
    for each in components:
        send_epoch(session.tree.trees, session.usual_manager, each, made, session.verbose)
    _awake(session)


def give_up(session: Session, document: SystemProfile) -> None:
    """Own a system no more: its components may be anywhere again."""
    from rtkit.link import owned_files

    known = _own(session, document)
    if known is None:
        return
    for name in known.components:
        moved = known.moved(name, "", time(), is_stale=False)
        send_epoch(session.tree.trees, session.usual_manager, name, moved, session.verbose)
    owned_files.remove(owned_files.path_of(session.usual_manager, known.system))
    _awake(session)


def send_epoch(
    trees: Mapping[str, Tree],
    owner: str,
    name: str,
    owned: OwnedSystem,
    notify: Callable[[str], object],
) -> None:
    """Tell managers in which one a component is to be, and since which epoch its owner says so."""
    from rtkit.link.places import host_name

    each = owned.components[name]
    manager, host = split_manager(each.home)
    home = f"{host or host_name()}/{manager}" if manager else ""
    row = {"component": name, "epoch": each.epoch, "home": home}
    row["owner"] = f"{host_name()}/{owner}"
    text = json.dumps(row)
    for tree in trees.values():
        try:
            tree.set("fence", text)
        except Unreachable as error:
            notify(f"{error}: it is told of {name} when it is back")


def read(manager: str, system: str) -> OwnedSystem | None:
    """Return the record of a system that a manager owns, if it does."""
    from rtkit.link import owned_files

    return decoded(owned_files.read(owned_files.path_of(manager, system)))


def decoded(text: str) -> OwnedSystem | None:
    """Return a record from its text; None for an empty or damaged one."""
    from rtkit.deployment.owned import OwnedSystem
    from rtkit.rtc.serde import decode_text

    try:
        return decode_text(OwnedSystem, text) if text else None
    except (RtkitError, ValueError, LookupError, TypeError):
        return None


def troubles(manager: str) -> dict[str, str]:
    """Return what is wrong with movable components that a manager owns, by their names."""
    from rtkit.link import owned_files

    found = {}
    for path in owned_files.of_manager(manager):
        owned = decoded(owned_files.read(path))
        if owned is None:
            continue
        for name, each in owned.components.items():
            left = [f"an older one may live in {manager}" for manager in each.stale]
            failed = [owned.why or "not all is connected yet"] if owned.is_pending else []
            whys = [*filter(None, [each.why]), *failed, *left]
            if whys:
                found[name] = "; ".join(whys)
    return found


def write(manager: str, owned: OwnedSystem) -> None:
    """Keep the record of a system."""
    from rtkit.link import owned_files
    from rtkit.rtc.serde import encode_text

    owned_files.write(owned_files.path_of(manager, owned.system), encode_text(owned))


def _homes(session: Session, goal: DeploymentGoal) -> dict[str, str]:
    """Return the managers of the components of a goal, as plans call them."""
    first = session.tree.manager
    return {each.instance: each.manager or first for each in goal.system.components}


def _awake(session: Session) -> None:
    """Have the manager begin, wake up or end the process that acts on its records."""
    session.tree.at(session.usual_manager).set("own", "")
