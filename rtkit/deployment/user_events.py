"""User events: found by comparing the facts before and after a delta.

Kinds and words are those of the observers of the RTC standard. Two are of rtkit: ``TREE_EVENT``
for entries that come, go or lose their process, and ``SUPERVISION`` for the actions of restart
policies and health rules.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rtkit.deployment.delta import Delta, LiveFacts
from rtkit.deployment.facts import (
    ComponentFacts,
    Followed,
    ProcessFacts,
    RestartStatus,
    Snapshot,
)
from rtkit.deployment.listing import is_device_absence
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile, ExecutionContextProfile

TREE_EVENT = "TREE_EVENT"
RTC_STATUS = "RTC_STATUS"
COMPONENT_PROFILE = "COMPONENT_PROFILE"
EC_EVENT = "EC_EVENT"
PORT_EVENT = "PORT_EVENT"
CONFIG_EVENT = "CONFIG_EVENT"
FSM_EVENT = "FSM_EVENT"
SUPERVISION = "SUPERVISION"
HEARTBEAT = "HEARTBEAT"
KINDS = (
    TREE_EVENT, RTC_STATUS, COMPONENT_PROFILE, EC_EVENT, PORT_EVENT, CONFIG_EVENT, FSM_EVENT,
    SUPERVISION, HEARTBEAT,
)  # fmt: skip
SYSTEM_STATE = "SYSTEM_STATE"
"""A system came to another of its states: its manager tells it that follows it, else it is seen."""

_PROFILE = {
    "names": "names",
    "is_stand_in": "stand-in",
    "composite": "composite",
    "members": "members",
    "properties": "properties",
    "create": "options",
}


class UserEvent(NamedTuple):
    """Something that happened to a component, or to a process when `instance` is empty.

    Attributes:
        process: Name of the process that holds the component, or that it happened to.
        subject: Execution context, port, configuration set …; empty for the component.
        event: Event of that subject.
        detail: More about it.
        names: Names under which the component is registered, or was.
        restart: Of one that its policy restarted: how often, for what, how long it took.
        system: Transition of a system that is followed.
        is_tool: The component is that of a data tool, there for as long as the tool runs.
    """

    kind: str
    instance: str
    process: str
    subject: str
    event: str
    detail: str = ""
    names: tuple[str, ...] = ()
    restart: RestartStatus | None = None
    system: Followed | None = None
    is_tool: bool = False


def _of(kind: str, facts: ComponentFacts, subject: str, event: str, detail: str = "") -> UserEvent:
    about = kind, facts.instance, facts.process, subject, event, detail, facts.names
    return UserEvent(*about, is_tool=facts.is_tool)


def user_events(before: Snapshot | LiveFacts, delta: Delta) -> Iterator[UserEvent]:
    """Yield the events between the facts `before` and a delta; what goes comes first."""
    before = LiveFacts(before) if isinstance(before, Snapshot) else before
    known, connectors = before.components, before.connectors
    places = ChainMap({facts.instance: facts for facts in delta.components}, known)
    for connector_id in delta.cut:
        yield from _wired(connectors.get(connector_id), places, "PORT_DISCONNECT")
    for instance in delta.gone:
        old = known.get(instance)
        if old is not None:
            yield _of(TREE_EVENT, old, "", "VANISHED")
    yield from _processes(before, delta)
    for facts in delta.components:
        old = known.get(facts.instance)
        yield from _appeared(facts) if old is None else _component(old, facts)
    for connector in delta.connectors:
        if connector.connector_id not in connectors:
            yield from _wired(connector, places, "PORT_CONNECT")
    yield from _systems(before, delta)


def _systems(before: LiveFacts, delta: Delta) -> Iterator[UserEvent]:
    """Yield where systems came that are followed, and which transitions failed."""
    if delta.systems is None:
        return
    known = {each.system: each for each in before.systems}
    for each in delta.systems:
        old = known.pop(each.system, None)

        def user_event(event: str, detail: str = "", each: Followed = each) -> UserEvent:
            return UserEvent(SYSTEM_STATE, "", "", each.system, event, detail, system=each)

        if old is None or (old.is_over and not each.is_over):
            yield user_event("FOLLOWED")
            old = Followed(each.system)
        if each.why and each.why != old.why:
            yield user_event("TRANSITION_FAILED", each.why)
        if each.waits and each.waits != old.waits:
            yield user_event("WAITS", each.waits)
        if each.count != old.count:
            yield user_event(each.state, str(each))
        if each.is_over and not old.is_over:
            yield user_event("NOT_FOLLOWED", "that transition failed")
    for each in known.values():
        yield UserEvent(SYSTEM_STATE, "", "", each.system, "NOT_FOLLOWED", system=each)


def heartbeats(facts: ComponentFacts, contexts: Iterable[str]) -> Iterator[UserEvent]:
    """Yield the heartbeats of a component that answered, with the contexts that run."""
    yield _of(HEARTBEAT, facts, "", "RTC_HEARTBEAT")
    for context in contexts:
        yield _of(HEARTBEAT, facts, context, "EC_HEARTBEAT")


def _processes(before: LiveFacts, delta: Delta) -> Iterator[UserEvent]:
    known = before.processes
    for pid in delta.ended:
        old = known.get(pid)
        if old is not None and old.state != "lost":
            yield UserEvent(TREE_EVENT, "", old.name, "", "PROCESS_ENDED", _pid(old))
    for each in delta.processes:
        old = known.get(each.pid)
        if old is None:
            yield UserEvent(TREE_EVENT, "", each.name, "", "PROCESS_STARTED", _pid(each))
        elif each.state != old.state or each.reason != old.reason:
            yield _process(each, old)


def _process(each: ProcessFacts, old: ProcessFacts) -> UserEvent:
    event = {"lost": "PROCESS_LOST", "stopped": "PROCESS_STOPPED"}.get(each.state)
    if event is None:
        event = "PROCESS_STUCK" if each.reason else "PROCESS_ANSWERS"
    if old.state == "starting" and event == "PROCESS_ANSWERS":
        event = "PROCESS_READY"
    return UserEvent(TREE_EVENT, "", each.name, "", event, each.reason)


def _pid(process: ProcessFacts) -> str:
    return f"pid {process.pid}" if process.pid else ""


def _appeared(facts: ComponentFacts) -> Iterator[UserEvent]:
    yield _of(TREE_EVENT, facts, "", "APPEARED", facts.type.type_name)
    if facts.zombie:
        yield _of(TREE_EVENT, facts, "", "ZOMBIE", facts.zombie)
        return
    for context in facts.contexts:
        if context.state in (LifeCycleState.ACTIVE, LifeCycleState.ERROR):
            yield _status(facts, context)


def _component(old: ComponentFacts, new: ComponentFacts) -> Iterator[UserEvent]:
    if new.zombie != old.zombie:
        event = "ZOMBIE" if new.zombie else "ALIVE"
        yield _of(TREE_EVENT, new, "", event, new.zombie)
    if new.trouble != old.trouble:
        event = "NOT_ANSWERING" if new.trouble else "ANSWERS"
        yield _of(TREE_EVENT, new, "", event, new.trouble)
    changed = [word for name, word in _PROFILE.items() if getattr(new, name) != getattr(old, name)]
    if changed:
        yield _of(COMPONENT_PROFILE, new, "", ", ".join(changed))
    yield from _contexts(old, new)
    yield from _ports(old, new)
    yield from _sets(old, new)
    yield from _machine(old, new)
    yield from _restart_status(new, old.restart_status, new.restart_status)


def _restart_status(
    facts: ComponentFacts, old: RestartStatus, new: RestartStatus
) -> Iterator[UserEvent]:
    """Yield what was done about the ends and the health of a component."""
    if new == old:
        return
    if old.returning and not new.returning and not facts.zombie and new.took_s:
        detail = f"restart {new.restarts}, for {new.why}, after {new.took_s:.3f} s"
        event = "DEVICE_APPEARED" if is_device_absence(new.why) else "MADE_AGAIN"
        yield _of(SUPERVISION, facts, "", event, detail)._replace(restart=new)
    if new.returning and new.returning != old.returning:
        event = "DEVICE_GONE" if is_device_absence(new.returning) else "RETURNING"
        yield _of(SUPERVISION, facts, "", event, new.returning)
    if new.given_up and not old.given_up:
        yield _of(SUPERVISION, facts, "", "GIVEN_UP", new.given_up)
    if new.degraded != old.degraded:
        event = "DEGRADED" if new.degraded else "WELL"
        yield _of(SUPERVISION, facts, "", event, new.degraded)
    if new.rested and new.rested != old.rested:
        yield _of(SUPERVISION, facts, "", "STOPPED", new.rested)
    if new.halted and new.halted != old.halted:
        yield _of(SUPERVISION, facts, "", "CRITICAL_STOP", new.halted)


def _contexts(old: ComponentFacts, new: ComponentFacts) -> Iterator[UserEvent]:
    before = {context.id: context for context in old.contexts}
    for context in new.contexts:
        known = before.pop(context.id, None)
        if known is None:
            yield _of(EC_EVENT, new, context.id, "EC_ATTACHED")
            continue
        if context.is_running != known.is_running:
            word = "EC_STARTUP" if context.is_running else "EC_SHUTDOWN"
            yield _of(EC_EVENT, new, context.id, word)
        if context.rate != known.rate:
            yield _of(EC_EVENT, new, context.id, "EC_RATE_CHANGED", f"{context.rate:g} Hz")
        if context.trouble != known.trouble:
            word = "EC_SETTINGS_REFUSED" if context.trouble else "EC_SETTINGS_APPLIED"
            yield _of(EC_EVENT, new, context.id, word, context.trouble)
        if context.state != known.state:
            yield _status(new, context)
    for id in before:
        yield _of(EC_EVENT, new, id, "EC_DETACHED")


def _status(facts: ComponentFacts, context: ExecutionContextProfile) -> UserEvent:
    cause = facts.cause if context.state is LifeCycleState.ERROR else ""
    return _of(RTC_STATUS, facts, context.id, context.state.value.upper(), cause)


def _ports(old: ComponentFacts, new: ComponentFacts) -> Iterator[UserEvent]:
    before, after = ({port.name for port in facts.ports} for facts in (old, new))
    for name in sorted(before - after):
        yield _of(PORT_EVENT, new, name, "PORT_REMOVE")
    for name in sorted(after - before):
        yield _of(PORT_EVENT, new, name, "PORT_ADD")


def _wired(
    connector: ConnectorProfile | None, places: Mapping[str, ComponentFacts], event: str
) -> Iterator[UserEvent]:
    if connector is None:
        return
    for end in connector.ports:
        others = " ".join(f"{each.instance}:{each.port}" for each in connector.ports if each != end)
        facts = places.get(end.instance)
        if facts is not None:
            yield _of(PORT_EVENT, facts, end.port, event, others)


def _sets(old: ComponentFacts, new: ComponentFacts) -> Iterator[UserEvent]:
    def event(subject: str, word: str, detail: str = "") -> UserEvent:
        return _of(CONFIG_EVENT, new, subject, word, detail)

    for set_id in old.sets:
        if set_id not in new.sets:
            yield event(set_id, "CFG_REMOVE_SET")
    for set_id, values in new.sets.items():
        before = old.sets.get(set_id)
        if before is None:
            yield event(set_id, "CFG_ADD_SET")
            continue
        changed = [name for name, text in values.items() if before.get(name) != text]
        for name in changed:
            yield event(f"{set_id}.{name}", "CFG_UPDATE_PARAM", values[name])
        if changed or before.keys() != values.keys():
            yield event(set_id, "CFG_UPDATE_SET")
    if new.active_set != old.active_set:
        yield event(new.active_set, "CFG_ACTIVATE_SET")


def _machine(old: ComponentFacts, new: ComponentFacts) -> Iterator[UserEvent]:
    if new.fsm_states != old.fsm_states:
        yield _of(FSM_EVENT, new, "", "FSM_STRUCTURE")
    if new.fsm_events != old.fsm_events:
        yield _of(FSM_EVENT, new, "", "FSM_PROFILE")
    if new.fsm_state != old.fsm_state:
        yield _of(FSM_EVENT, new, "", "FSM_STATUS", new.fsm_state)
