"""Connects and disconnects ports: the procedures of connectors."""

from __future__ import annotations

from rtkit.component.ports.options import parse_options
from rtkit.component.ports.port_matching import refusal
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.manager.core.effects import Call, Procedure, Send, WaitUntil
from rtkit.manager.core.fences import check_fence
from rtkit.manager.core.halves import connect_half, notify_gone
from rtkit.manager.core.state import ManagerState, Opening, Process, no_component
from rtkit.rtc.connector_properties import DIRECT, differing
from rtkit.rtc.enums import PortType
from rtkit.rtc.far_ends import named_for, own_end, peer_of
from rtkit.rtc.port_types import WRONG_TYPE, are_reversed, provides
from rtkit.rtc.profiles import ConnectorProfile, PortProfile
from rtkit.rtc.serde import encode


def living(state: ManagerState, instance: str) -> Process:
    """Return the process that holds a component.

    Raises:
        NotFound: There is no such component.
        Refused: It is a zombie, or on its way out.
    """
    facts = state.components.get(instance)
    process = state.process_of(instance)
    if facts is None or process is None:
        raise no_component(state, instance)
    if facts.zombie:
        raise Refused(f"zombie ({facts.zombie}): {instance}")
    if instance in state.ending:
        raise Refused(f"{instance} is just being deleted")
    return process


def connect(state: ManagerState, action: act.Connect) -> Procedure:
    """Make a connector; one that exists between the same ports is what was asked for."""
    connector = action.connector
    connector_id = connector.connector_id
    while connector_id in state.openings:
        why = f"connection {connector_id} is just being made"
        yield WaitUntil(lambda: connector_id not in state.openings, why)
    if peer_of(connector):
        connector = named_for(connector, state.name_for(peer_of(connector)))
    known = state.connectors.get(connector_id)
    own = OwnEnds(state.components)
    if known is not None:
        same = _same(known, own.connector(connector))
        if not known.trouble:
            return same
    if not connector_id or any(ord(c) < 32 for c in connector_id):
        raise Malformed(f"connector id is empty or has control characters: {connector_id!r}")
    if peer_of(connector):
        check_fence(state, connector)
        connector = own.connector(connector)
        yield from _cut_loose(state, connector_id)
        return (yield from connect_half(state, connector, *own_port(state, connector)))
    ports = _ports(state, connector)
    text = refusal(ports, connector.properties)
    if text or are_reversed([port.port_type for port in ports]):
        raise Refused(text or WRONG_TYPE)
    connector = own.connector(connector)
    ends = [living(state, end.instance) for end in connector.ports]
    opening = state.openings[connector_id] = Opening(connector)
    try:
        yield from _cut_loose(state, connector_id)
        if ports[0].port_type is PortType.SERVICE:
            yield from _open_services(ends, ports, connector)
        else:
            yield from _open(ends, connector)
        if opening.is_broken:
            raise Refused(f"an end of connection {connector_id} ended while it was made")
    except RtkitError:
        yield from _abandon(ends, connector_id)
        raise
    finally:
        del state.openings[connector_id]
    state.connectors[connector_id] = connector
    return Result(value=connector_id)


def check_same(state: ManagerState, connector: ConnectorProfile) -> None:
    """Refuse a connector whose id another one has.

    Raises:
        Refused: Names that.
    """
    connector_id = connector.connector_id
    known = state.connectors.get(connector_id, state.kept.wires.get(connector_id))
    if known is not None:
        _same(known, OwnEnds(state.components).connector(connector))


def own_port(state: ManagerState, connector: ConnectorProfile) -> tuple[PortProfile, Process]:
    """Return the port at the own end of half a connector, and its process.

    Raises:
        NotFound: There is no such component or port.
        Refused: It is a zombie, or on its way out.
    """
    _, end = own_end(connector)
    process = living(state, end.instance)
    port = state.components[end.instance].port(end.port)
    if port is None:
        raise NotFound(f"Port not found: {end}")
    return port, process


def _same(known: ConnectorProfile, connector: ConnectorProfile) -> Result:
    if set(known.ports) != set(connector.ports):
        ends = " and ".join(map(str, known.ports))
        raise Refused(f"connector id {connector.connector_id} is in use between {ends}")
    changed = differing(connector.properties, known.properties)
    if changed:
        raise Refused(
            f"connection {connector.connector_id} exists with another {', '.join(changed)}"
        )
    return Result(value=connector.connector_id)


def _ports(state: ManagerState, connector: ConnectorProfile) -> list[PortProfile]:
    if len(connector.ports) != 2:
        raise Malformed(f"a connection joins two ports, not {len(connector.ports)}")
    ports = []
    for end in connector.ports:
        living(state, end.instance)
        port = state.components[end.instance].port(end.port)
        if port is None:
            raise NotFound(f"Port not found: {end}")
        ports.append(port)
    return ports


def _open(ends: list[Process], connector: ConnectorProfile) -> Procedure:
    """Open both ends: first the one that listens, which is the one that takes no initiative."""
    out, into = ends
    plain = encode(connector)
    if out is into:
        yield Call(out, {"op": "link", "connector": plain})
        return Result()
    options = parse_options(connector.properties)
    if options.interface == DIRECT:
        places = f"{connector.ports[0]} is in {out.name}, {connector.ports[1]} in {into.name}"
        raise Refused(f"interface type direct joins ports of one process: {places}")
    if options.dataflow == "pull":
        first, opens, second, joins = out, "serve", into, "fetch"
    else:
        first, opens, second, joins = into, "sink", out, "source"
    endpoint = yield Call(first, {"op": opens, "connector": plain})
    yield Call(second, {"op": joins, "connector": plain, "endpoint": endpoint})
    return Result()


def _open_services(
    ends: list[Process], ports: list[PortProfile], connector: ConnectorProfile
) -> Procedure:
    """Open each direction in which one port provides what the other needs, the provider first."""
    plain = encode(connector)
    if ends[0] is ends[1]:
        yield Call(ends[0], {"op": "link", "connector": plain})
        return Result()
    offers = [port.interfaces for port in ports]
    ways = [way for way in ((0, 1), (1, 0)) if provides(offers[way[0]], offers[way[1]])]
    for provider, consumer in ways:
        endpoint = yield Call(ends[provider], {"op": "offer", "connector": plain, "end": provider})
        request = {"op": "consult", "connector": plain, "end": consumer, "endpoint": endpoint}
        yield Call(ends[consumer], request)
    for end in (0, 1) if not ways else ():
        yield Call(ends[end], {"op": "keep", "connector": plain, "end": end})
    return Result()


def _cut_loose(state: ManagerState, connector_id: str) -> Procedure:
    """Take what is left of a connector of that name off the slaves that outlived their manager."""
    for id, key in list(state.loose):
        if id == connector_id:
            del state.loose[id, key]
            yield Send(state.processes[key], {"op": "unlink", "connector_id": id})
    return Result()


def _abandon(ends: list[Process], connector_id: str) -> Procedure:
    """Take off what was opened of a connector, also by an answer that came too late."""
    for process in _distinct(ends):
        if process.is_ready:
            yield Send(process, {"op": "unlink", "connector_id": connector_id})
    return Result()


def disconnect(state: ManagerState, action: act.Disconnect) -> Procedure:
    """Remove a connector."""
    connector = state.connectors.get(action.connector_id)
    if connector is None:
        raise NotFound(f"no connection with id {action.connector_id}")
    peer = peer_of(connector)
    try:
        yield from unwire(state, connector, holds=action.holds)
    except Unreachable:
        if peer:  # its half is desired as before
            state.kept.untell(peer, action.connector_id)
        raise
    state.kept.drop("wire", action.connector_id)  # a peer that is told may make it again
    if not peer:
        return Result()
    return (yield from notify_gone(state, peer, action.connector_id))


def unwire(
    state: ManagerState, connector: ConnectorProfile, timeout_s: float = 0.0, *, holds: bool = False
) -> Procedure:
    """Take a connector off both ends, the sending one first; a dead end is no obstacle.

    A time-out of 0 means that of the batch [s]. A port that `holds` keeps what is written.

    Raises:
        Unreachable: An end that lives did not answer; it obeys when it can.
    """
    state.connectors.pop(connector.connector_id, None)
    message = {"op": "unlink", "connector_id": connector.connector_id}
    late: Unreachable | None = None
    first = {**message, "op": "hold"} if holds else message
    ends = [state.process_of(end.instance) for end in connector.ports]
    for process in _distinct([each for each in ends if each is not None and each.is_ready]):
        if not process.is_ready:
            continue  # it ended while the other end was waited for
        if process.state == "stopped" or late is not None:
            yield Send(process, message)
            continue
        try:
            yield Call(process, first, timeout_s, is_lasting=True)
            first = message
        except Unreachable as error:
            late = error if process.is_alive else late
    if late is not None:
        raise late
    return Result()


def cut(state: ManagerState, connector: ConnectorProfile) -> Procedure:
    """Take a connector off its ends without waiting for them."""
    state.cut(connector.connector_id)
    ends = [state.process_of(end.instance) for end in connector.ports]
    yield from _abandon([each for each in ends if each is not None], connector.connector_id)
    return Result()


def _distinct(processes: list[Process]) -> list[Process]:
    return list({process.key: process for process in processes}.values())
