"""Folds reports of processes into the manager's state: of a component, or of all that one holds.

A slave runs code of others: nothing that it sends is trusted to have the right shape. Slaves of an
earlier manager, and attached processes, are believed about facts: components with names and origin,
connector ends. A connector is known again when both its ends are; one that has lost an end is
removed.
"""

from __future__ import annotations

from collections.abc import Iterable
from types import MappingProxyType
from typing import NamedTuple

from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.message import Message
from rtkit.errors import Malformed
from rtkit.fast_dataclass import replace
from rtkit.manager.core.desired_changes import Asked, desired_by, note, requests_from
from rtkit.manager.core.effects import Procedure, Send, Sleep
from rtkit.manager.core.halves import NOT_MET
from rtkit.manager.core.limiting import note_limits
from rtkit.manager.core.registration import free_names
from rtkit.manager.core.state import ManagerState, Process
from rtkit.rtc.far_ends import own_end, peer_of
from rtkit.rtc.names import check_instance_name
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode

SETTLE_S = 2.0
"""How long slaves have to come back after a manager's start [s]."""


def process_of(state: ManagerState, pid: int) -> Process | None:
    """Return the live process of that pid if it is known already, as after a lost connection."""
    return next((p for p in state.processes.values() if p.pid == pid and p.is_alive), None)


def free_name(state: ManagerState, name: str, pid: int) -> str:
    """Return the name under which a found slave goes: its own, unless another has it by now."""
    return name if state.living_process(name) is None else f"{name}_{pid}"


class Holding(NamedTuple):
    """Report of a found slave: its components, and user requests to them since creation."""

    components: list[ComponentFacts]
    wires: list[ConnectorProfile]
    asked: Asked = MappingProxyType({})


def read(name: str, components: object, wires: object, asked: object = None) -> Holding:
    """Read the report of the slave `name` about its components.

    Raises:
        Malformed: It cannot be read.
    """
    if not isinstance(components, list) or not isinstance(wires, list):
        raise Malformed(f"{name} says it holds what is no list")
    held = [decode(ComponentFacts, each) for each in components]
    for facts in held:
        check_instance_name(facts.instance)
    ends = [decode(ConnectorProfile, each) for each in wires]
    return Holding(held, ends, requests_from(asked))


def take(state: ManagerState, process: Process, holding: Holding) -> list[Message]:
    """Fold what a found slave holds into the state; return what it is to undo."""
    undo: list[Message] = []
    for facts in holding.components:
        if not _take_component(state, process, facts):
            undo.append({"op": "delete", "instance": facts.instance})
    named = {facts.instance for facts in holding.components}
    for instance in state.held_by(process.key):
        if instance not in named:  # it ended while the connection was lost
            state.forget(instance)
    if process.is_guest:
        for instance in state.held_by(process.key):
            state.update(instance, names=free_names(state, instance))
    for connector in holding.wires:
        _take_end(state, process, connector)
    return undo


def believe(state: ManagerState, process: Process, holding: Holding) -> None:
    """Take for desired what users asked last, though no manager may have recorded it."""
    for instance, actions in holding.asked.items():
        if state.containers.get(instance) == process.key:
            for action in actions:
                note(state.kept, action)
            state.kept.change(instance, names=state.components[instance].names)
            state.since_made[instance] = desired_by(instance, actions)


def take_unsaid(state: ManagerState, process: Process, holding: Holding) -> None:
    """Fold the checkpoint of a slave that does not answer into the state."""
    take(state, process, holding)
    for instance in state.held_by(process.key):
        state.update(instance, trouble=state.trouble_of(instance, process))
    for (_, key), connector in list(state.loose.items()):
        _take_end(state, state.processes[key], connector)


def take_missed(state: ManagerState, process: Process, holding: Holding) -> None:
    """Show what a slave held that ended while no manager ran, if nobody else has it now."""
    for facts in holding.components:
        if facts.instance in state.components or facts.instance in state.claims:
            continue
        _enter(state, process, facts, (n for n in facts.names if not state.name_owner(n)))
    state.drop_if_empty(process.key)


def absent_wires(state: ManagerState, process: Process, holding: Holding) -> list[ConnectorProfile]:
    """Return the connectors that a slave was taken to hold ends of, and does not."""
    reported = {connector.connector_id for connector in holding.wires}
    return [
        connector
        for instance in state.held_by(process.key)
        for connector in state.connectors_of(instance)
        if connector.connector_id not in reported
    ]


def _take_component(state: ManagerState, process: Process, facts: ComponentFacts) -> bool:
    known = state.components.get(facts.instance)
    container = state.process_of(facts.instance)
    is_elsewhere = (known is not None and not known.zombie) or facts.instance in state.claims
    if is_elsewhere and container is not process:
        return False
    if known is not None and container is not process:
        state.forget(facts.instance)
    names = (n for n in facts.names if state.name_owner(n) in ("", facts.instance))
    _enter(state, process, facts, names)
    note_limits(state, facts.instance, facts.create)
    return True


def _take_end(state: ManagerState, process: Process, connector: ConnectorProfile) -> None:
    """Note that a process holds an end of a connector, which is whole once all report so."""
    connector_id = connector.connector_id
    known = state.connectors.get(connector_id)
    if known is not None and set(known.ports) == set(connector.ports):
        return
    if peer_of(connector):
        _take_half(state, connector)
        return
    state.loose[connector_id, process.key] = connector
    ends = [state.components.get(end.instance) for end in connector.ports]
    is_alive = all(
        facts is not None and not facts.zombie and facts.port(end.port) is not None
        for facts, end in zip(ends, connector.ports, strict=True)
    )
    containers = {state.containers.get(end.instance) for end in connector.ports}
    reported = {
        key for (id, key), other in state.loose.items() if (id, other) == (connector_id, connector)
    }
    silent = {process.key for process in state.processes.values() if process.silence}
    if known is None and is_alive and containers <= reported | silent:
        state.connectors[connector_id] = connector
        for key in reported & containers:
            del state.loose[connector_id, key]


def _take_half(state: ManagerState, connector: ConnectorProfile) -> None:
    """Note a connector that leads to another manager; whether it is whole, that one knows."""
    _, end = own_end(connector)
    facts = state.components.get(end.instance)
    if facts is not None and not facts.zombie and facts.port(end.port) is not None:
        why = NOT_MET.format(peer_of(connector))
        state.connectors[connector.connector_id] = replace(connector, trouble=why)
        state.kept.put("wire", connector.connector_id, connector)
        state.kept.untell(peer_of(connector), connector.connector_id)


def cut_loose(state: ManagerState, process: Process) -> Procedure:
    """Take connectors off a found slave whose other ends did not come back."""
    yield Sleep(SETTLE_S)
    for connector_id, key in list(state.loose):
        if key == process.key:
            del state.loose[connector_id, key]
            if process.is_ready:
                yield Send(process, {"op": "unlink", "connector_id": connector_id})
    return Result()


def take_report(state: ManagerState, process: Process, report: object) -> ComponentFacts:
    """Fold the facts of one component, as its process reports them, into the state.

    Raises:
        Malformed: They cannot be read, or are none of its business; nothing is changed.
    """
    facts = decode(ComponentFacts, report)
    instance = facts.instance
    known = state.components.get(instance)
    claim = state.claims.get(instance)
    if state.containers.get(instance) != process.key:
        if claim is None or claim.key != process.key:
            raise Malformed(f"{process.name} reports {instance}, which it does not hold")
        if known is not None:
            state.forget(instance)
            known = None
    names: tuple[str, ...] = ()
    if known is not None:
        names, facts = known.names, replace(facts, create=known.create, module=known.module)
    else:
        facts = replace(facts, create="", module="")
    return _enter(state, process, facts, names, state.trouble_of(instance, process))


def _enter(
    state: ManagerState,
    process: Process,
    facts: ComponentFacts,
    names: Iterable[str],
    trouble: str = "",
) -> ComponentFacts:
    """Enter facts into the state, with those that are the manager's own."""
    entered = state.components[facts.instance] = replace(
        facts,
        process=process.name,
        names=tuple(dict.fromkeys(names)),
        trouble=trouble,
        zombie=process.reason,
        restart_status=state.restart_status_of(facts.instance),
    )
    state.containers[facts.instance] = process.key
    return entered
