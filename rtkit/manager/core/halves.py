"""Makes, meets and ends halves of connectors: those whose other end is in another manager.

Each manager keeps its own half, as a wish and as a fact, and asks its peer about the other one. A
request may come again, and either side may send it: the answer is always the peer's own record of
the half, or nothing if it has none. Nothing, from the store that made it, means that the connector
was removed, or never came to be; from a store that has begun anew, that it was forgotten.

See decision 71.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from typing import Any

from rtkit.component.ports.options import parse_options
from rtkit.component.ports.port_matching import refusal
from rtkit.deployment.actions import Result
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.manager.core.effects import (
    Call,
    CallPeer,
    Effect,
    Gather,
    Procedure,
    ReadClock,
    Send,
    WaitUntil,
)
from rtkit.manager.core.state import Expected, ManagerState, Opening, Process
from rtkit.rtc.connector_properties import DIRECT
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.far_ends import (
    host_of,
    named_by,
    named_for,
    on_host,
    own_end,
    peer_of,
    split_far,
)
from rtkit.rtc.port_types import WRONG_TYPE, are_reversed, provides
from rtkit.rtc.profiles import ConnectorProfile, PortProfile
from rtkit.rtc.serde import decode, encode

_log = logging.getLogger(__name__)
Record = Mapping[str, Any]
NOT_MET = "manager {} has not been met yet"
ANY = "*"
"""All makings of a connector: who answers has none of it at present."""
_NOTICE_S = 2.0
"""How long a peer is waited for that is only to hear that a connector is no more [s]."""


# the coordinator, and whom it asks


def connect_half(
    state: ManagerState, connector: ConnectorProfile, port: PortProfile, process: Process
) -> Procedure:
    """Make a connector of which one end is in another manager; that one makes its half, too.

    Raises:
        Refused: The peer refuses.
        Unreachable: It does not run, or does not answer.
    """
    connector_id, peer = connector.connector_id, peer_of(connector)
    is_known = connector_id in state.connectors
    making = state.kept.making_of(connector_id) or state.new_making()
    with _opening(state, connector) as opening:
        try:
            endpoint = yield from _open_end(process, connector, port)
            theirs = yield CallPeer(
                peer,
                {
                    "op": "make",
                    "manager": state.name_for(peer),
                    "life": state.kept.store_name,
                    "making": making,
                    "connector": encode(named_by(connector, state.name_for(peer))),
                    "port": encode(port),
                    "endpoint": endpoint,
                },
            )
            yield from _join_end(process, connector, port, theirs)
            _check_whole(opening)
        except RtkitError:
            if not is_known:
                yield from loosen(state, connector)
            if peer in state.peers:  # it may have made its half
                state.kept.untell(peer, connector_id, making)
            raise
    _enter(state, connector, making, _text(theirs, "life"))
    return Result(value=connector_id)


def make_half(
    state: ManagerState, asked: Record, connector: ConnectorProfile, living: Living
) -> Procedure:
    """Make the own half of a connector that a peer makes; its value is the own record.

    Raises:
        Refused: The ports do not fit.
    """
    connector_id = connector.connector_id
    connector = OwnEnds(state.components).connector(connector)
    opening = state.openings.get(connector_id)
    if opening is not None and opening.wire.ports != connector.ports:
        # Perhaps its peer waits for this one, too.
        raise Refused(f"another connection {connector_id} is just being made")
    yield from at_rest(state, connector_id)
    index, _ = own_end(connector)
    port, process = living(state, connector)
    ports = [port, decode(PortProfile, asked.get("port"))]
    ports = ports[:: -1 if index else 1]
    text = refusal(ports, connector.properties)
    if text or are_reversed([each.port_type for each in ports]):
        raise Refused(text or WRONG_TYPE)
    is_known = connector_id in state.connectors
    with _opening(state, connector) as opening:
        try:
            endpoint = yield from _open_end(process, connector, port)
            yield from _join_end(process, connector, port, asked)
            _check_whole(opening)
        except RtkitError:
            if not is_known:
                yield from loosen(state, connector)
            raise
    _enter(state, connector, _text(asked, "making"), _text(asked, "life"))
    state.expected.pop(connector_id, None)
    own = {"life": state.kept.store_name, "port": encode(port), "endpoint": endpoint}
    return Result(value=json.dumps(own))


Living = Callable[[ManagerState, ConnectorProfile], tuple[PortProfile, Process]]
"""Returns the own port of half a connector, and its process; raises if either is not there."""


def connector_in(state: ManagerState, asked: Record) -> ConnectorProfile:
    """Return the connector that a peer asks about, with the ends as they are named here.

    Raises:
        Malformed: It is none between that peer and this manager.
    """
    peer = _text(asked, "manager")
    own = state.name_for(peer)
    connector = named_for(decode(ConnectorProfile, asked.get("connector")), own)
    if len(connector.ports) != 2 or peer_of(connector) != peer:
        raise Malformed(f"not a connection between {own} and its peer: {connector}")
    own_end(connector)
    return connector


EXPECTED_S = 10.0
"""How long a manager of another host may make a connector that it is expected to make [s]."""


def expect(state: ManagerState, connector: ConnectorProfile) -> Procedure:
    """Let a manager of another host make a connector to here, once or again, for some seconds.

    Raises:
        Malformed: It is none between this manager and one of another host.
    """
    peer = _far_peer(state, connector)
    connector = named_for(connector, state.name_for(peer))
    own_end(connector)
    now = yield ReadClock()
    ports = OwnEnds(state.components).connector(connector).ports
    state.expected[connector.connector_id] = Expected(peer, ports, now + EXPECTED_S)
    return Result()


def _far_peer(state: ManagerState, connector: ConnectorProfile) -> str:
    own = on_host(state.name, state.host)
    managers = {split_far(end.instance)[0] for end in connector.ports} - {own, ""}
    if len(connector.ports) != 2 or len(managers) != 1 or not host_of(*managers):
        raise Malformed(f"not a connection between {own} and another host: {connector}")
    return managers.pop()


def check_expected(state: ManagerState, connector: ConnectorProfile) -> None:
    """Refuse a connector that nobody but the manager of another host wants.

    Raises:
        Refused: Nobody asked this manager to expect it.
    """
    found = state.expected.get(connector.connector_id)
    ports = OwnEnds(state.components).connector(connector).ports
    if found is None or (found.peer, found.ports) != (peer_of(connector), ports):
        raise Refused(f"nobody here expects connection {connector.connector_id}")


def at_rest(state: ManagerState, connector_id: str) -> Generator[Effect, Any, None]:
    """Wait until nobody makes a connector of that id any more."""
    while connector_id in state.openings:
        why = f"connection {connector_id} is just being made"
        yield WaitUntil(lambda: connector_id not in state.openings, why)


@contextmanager
def _opening(state: ManagerState, connector: ConnectorProfile) -> Any:
    opening = state.openings[connector.connector_id] = Opening(connector)
    try:
        yield opening
    finally:
        del state.openings[connector.connector_id]


def _check_whole(opening: Opening) -> None:
    if opening.is_broken:
        connector_id = opening.wire.connector_id
        raise Refused(f"an end of connection {connector_id} ended while it was made")


def _enter(state: ManagerState, connector: ConnectorProfile, making: str, life: str) -> None:
    """Note a half that is whole, from which making it comes and with which store of the peer."""
    connector = replace(connector, trouble="")
    state.connectors[connector.connector_id] = connector
    state.kept.put("wire", connector.connector_id, connector)
    state.kept.put("half", connector.connector_id, (making, life))
    state.kept.note_gone_there(peer_of(connector), connector.connector_id, ANY)  # of an earlier one


# the ends


def _open_end(
    process: Process, connector: ConnectorProfile, port: PortProfile
) -> Generator[Effect, Any, str]:
    """Open the own end where it is the one that listens; return its endpoint, else nothing."""
    index, _ = own_end(connector)
    if port.port_type is PortType.SERVICE:
        is_provider = any(each.polarity is Polarity.PROVIDED for each in port.interfaces)
        op = "offer" if is_provider else "keep"
    else:
        options = parse_options(connector.properties)
        if options.interface == DIRECT:
            raise Refused(
                "interface type direct joins ports of one process:"
                f" {connector.ports[0]} and {connector.ports[1]} are in two managers"
            )
        listens = (0, "serve") if options.dataflow == "pull" else (1, "sink")
        op = listens[1] if index == listens[0] else ""
    if not op:
        return ""
    plain = encode(replace(connector, trouble=""))
    return str((yield Call(process, {"op": op, "connector": plain, "end": index})))


def _join_end(
    process: Process, connector: ConnectorProfile, port: PortProfile, theirs: Record
) -> Generator[Effect, Any, None]:
    """Have the own end reach for the other one, where that is the one that listens."""
    index, _ = own_end(connector)
    far = decode(PortProfile, theirs.get("port"))
    if port.port_type is PortType.SERVICE:
        op = "consult" if provides(far.interfaces, port.interfaces) else ""
    else:
        is_pull = parse_options(connector.properties).dataflow == "pull"
        op = ("", "fetch")[index] if is_pull else ("source", "")[index]
    if op:
        plain = encode(replace(connector, trouble=""))
        endpoint = _text(theirs, "endpoint")
        yield Call(process, {"op": op, "connector": plain, "end": index, "endpoint": endpoint})


def loosen(state: ManagerState, connector: ConnectorProfile) -> Generator[Effect, Any, None]:
    """Take the own end off, without waiting for it."""
    process = state.process_of(own_end(connector)[1].instance)
    if process is not None and process.is_ready:
        yield Send(process, {"op": "unlink", "connector_id": connector.connector_id})


# meetings


def show(state: ManagerState, connector_id: str, why: str) -> None:
    """Note why only the own half of a connector is there, or that it is whole."""
    connector = state.kept.wires.get(connector_id)
    if connector is not None and not _absent(state, connector):
        known, shown = state.connectors.get(connector_id), replace(connector, trouble=why)
        if known != shown:
            state.connectors[connector_id] = shown


def revive_half(state: ManagerState, connector: ConnectorProfile) -> None:
    """Have a half met whose own end is there again."""
    peer = peer_of(connector)
    if connector.connector_id not in state.connectors:
        show(state, connector.connector_id, NOT_MET.format(peer))
    state.kept.untell(peer, connector.connector_id)


def _absent(state: ManagerState, connector: ConnectorProfile) -> str:
    """Return why the own end of half a connector is not there; empty when it is."""
    _, end = own_end(connector)
    facts = state.components.get(end.instance)
    if facts is None:
        return f"{end.instance} is not there"
    if facts.zombie:
        return f"{end.instance} ended: {facts.zombie}"
    return "" if facts.port(end.port) is not None else f"{end.instance} has no port {end.port}"


def _place(state: ManagerState, connector: ConnectorProfile) -> tuple[PortProfile, Process]:
    """Return the port at the own end, which is there, and its process."""
    _, end = own_end(connector)
    port, process = state.components[end.instance].port(end.port), state.process_of(end.instance)
    assert port is not None
    assert process is not None
    return port, process


def meet(
    state: ManagerState, peer: str, ids: Mapping[str, str], timeout_s: float = 0.0
) -> Generator[Effect, Any, None]:
    """Tell a peer how these halves are here, and take in how they are there.

    `ids` tell from which making each comes, or came.

    Raises:
        Unreachable: It does not answer.
    """
    meant = {each: _meant(state, each) for each in ids}
    halves = yield from _records(state, peer, ids)
    own, life = state.name_for(peer), state.kept.store_name
    asked = {"op": "meet", "manager": own, "life": life, "halves": halves}
    message = yield CallPeer(peer, asked, timeout_s)
    for connector_id, half in halves.items():
        if "gone" in half:
            state.kept.note_gone_there(peer, connector_id, _text(half, "gone"))
    yield from _learn_all(state, peer, message, meant)


_Meant = tuple[bool, str]
NOTHING: Mapping[str, _Meant] = {}


def _meant(state: ManagerState, connector_id: str) -> _Meant:
    """Return which connector an id means now: whether there is one, and from which making."""
    return connector_id in state.kept.wires, state.kept.making_of(connector_id)


def be_met(state: ManagerState, asked: Record) -> Procedure:
    """Take in how halves are at a peer; its value is how they are here."""
    peer = _text(asked, "manager")
    yield from _learn_all(state, peer, asked)
    halves = yield from _records(state, peer, dict.fromkeys(_halves(asked), ANY))
    return Result(value=json.dumps({"life": state.kept.store_name, "halves": halves}))


def notify_gone(state: ManagerState, peer: str, connector_id: str) -> Procedure:
    """Have a peer remove its half; one that is away does so when it is back."""
    making = state.kept.untold.get(peer, {}).get(connector_id, "")
    state.kept.notified(peer, connector_id)
    try:
        yield from meet(state, peer, {connector_id: making}, _NOTICE_S)
    except Unreachable as error:
        if peer in state.peers:
            state.kept.untell(peer, connector_id, making)
        why = f"the other half of connection {connector_id} is removed when it is back"
        return Result(note=f"{error}; {why}")
    return Result()


def _records(
    state: ManagerState, peer: str, ids: Mapping[str, str]
) -> Generator[Effect, Any, dict[str, Record]]:
    found: dict[str, Record] = {}

    def add(connector_id: str, making: str) -> Procedure:
        found[connector_id] = yield from _record(state, peer, connector_id, making)
        return Result()

    yield Gather(tuple(add(*each) for each in ids.items()))
    return found


def _record(
    state: ManagerState, peer: str, connector_id: str, making: str
) -> Generator[Effect, Any, Record]:
    """Return how a half is here: its endpoint, or why there is none, or that it is no more."""
    yield from at_rest(state, connector_id)
    connector = state.kept.wires.get(connector_id)
    if connector is None or peer_of(connector) != peer:
        return {"gone": making}
    absent, making = _absent(state, connector), state.kept.making_of(connector_id)
    if absent:
        return {"making": making, "why": absent, "is_lost": True}
    port, process = _place(state, connector)
    why = state.failing.get(connector_id, "")
    if not why:
        try:
            endpoint = yield from _open_end(process, connector, port)
            own = {"making": making, "why": "", "endpoint": endpoint}
            return {**own, "port": encode(port)}
        except RtkitError as error:
            why = state.failing[connector_id] = str(error)
    return {"making": making, "why": why}


def _learn_all(
    state: ManagerState, peer: str, message: Record, meant: Mapping[str, _Meant] = NOTHING
) -> Generator[Effect, Any, None]:
    halves, life = _halves(message), _text(message, "life")

    def learn(connector_id: str, theirs: Record) -> Procedure:
        yield from at_rest(state, connector_id)
        if meant.get(connector_id) in (None, _meant(state, connector_id)):
            yield from _learn(state, peer, life, connector_id, theirs)
        return Result()  # else it is told of one that was made anew meanwhile

    yield Gather(tuple(learn(*each) for each in halves.items()))


def _learn(
    state: ManagerState, peer: str, life: str, connector_id: str, theirs: Record
) -> Procedure:
    """Take in how the other half of a connector is."""
    connector = state.kept.wires.get(connector_id)
    if connector is None or peer_of(connector) != peer:
        return Result()
    making, known_life = state.kept.halves.get(connector_id, ("", ""))
    if "gone" in theirs:
        if making and _text(theirs, "gone") not in (ANY, making):
            return Result()  # an earlier one of the same id
        return (yield from _forgotten(state, connector, known_life in ("", life)))
    making = making or _text(theirs, "making")
    state.kept.put("half", connector_id, (making, life))
    why = _text(theirs, "why") if theirs.get("why") else ""
    if theirs.get("is_lost"):
        yield from loosen(state, connector)
    elif not why and not _absent(state, connector):
        why = yield from _joined(state, connector, theirs)
    show(state, connector_id, why)
    return Result()


def _joined(
    state: ManagerState, connector: ConnectorProfile, theirs: Record
) -> Generator[Effect, Any, str]:
    """Join the own end to the other one; return why it cannot be."""
    port, process = _place(state, connector)
    try:
        with _opening(state, connector):
            yield from _join_end(process, connector, port, theirs)
    except RtkitError as error:
        if connector.connector_id in state.kept.wires:  # else its peer hears that it is no more
            state.failing[connector.connector_id] = str(error)
            state.kept.untell(peer_of(connector), connector.connector_id)
        return str(error)
    return ""


def _forgotten(state: ManagerState, connector: ConnectorProfile, is_same_store: bool) -> Procedure:
    """Remove a half whose other one was removed; keep one whose peer has begun anew."""
    connector_id, peer = connector.connector_id, peer_of(connector)
    if not is_same_store:
        show(state, connector_id, f"manager {peer} has begun anew, and does not know it")
        return Result()
    _log.info("connection %s was removed by manager %s", connector_id, peer)
    state.connectors.pop(connector_id, None)
    yield from loosen(state, connector)
    state.kept.drop("wire", connector_id)
    state.kept.notified(peer, connector_id)
    state.kept.note_gone_there(peer, connector_id, ANY)
    return Result()


# what a peer says, which is not trusted to have the right shape


def _text(message: Record, key: str) -> str:
    value = message.get(key)
    if not isinstance(value, str):
        raise Malformed(f"{key} is no text: {value!r}")
    return value


def _halves(message: Record) -> Mapping[str, Record]:
    halves = message.get("halves")
    if not isinstance(halves, dict) or not all(isinstance(e, dict) for e in halves.values()):
        raise Malformed(f"halves are no table: {halves!r}")
    return halves
