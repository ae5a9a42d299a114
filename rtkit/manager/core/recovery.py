"""Recovers the desired state: creates what is missing and repairs what differs.

Components do not move here, so the cheapest plan is the differences, sorted by kind: there is
nothing to search for. Failures are reported, and the rest is done all the same.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Collection, Generator, Iterable, Mapping
from typing import Any, NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.batch import results_to_text
from rtkit.deployment.health import read_rules
from rtkit.errors import Malformed, RtkitError
from rtkit.manager.core.desired import DesiredComponent, DesiredState, module_path
from rtkit.manager.core.effects import Effect as Yielded
from rtkit.manager.core.effects import Gather, Procedure, ReadClock, Sleep
from rtkit.manager.core.halves import revive_half
from rtkit.manager.core.modules import known
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.state import ManagerState
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.far_ends import peer_of
from rtkit.rtc.profiles import ConnectorProfile
from rtkit.rtc.serde import decode

_log = logging.getLogger(__name__)
RESTORE_S = 10.0
"""How long each step may take [s]."""

_TOGETHER_S = 1.0
"""Processes that die within this time of each other were ended together [s]."""

Steps = Generator[Yielded, Any, None]
Failed = Callable[[str, RtkitError], object]


def restore(state: ManagerState, resume: Callable[[float], object]) -> Procedure:
    """Adopt what lives and is not known, and bring to its end what is known.

    Its value are the failures, as results of which each names in its value what failed. `resume`
    is called with the time [s] when modules are there: who comes back by a policy waits for nobody.
    """
    failures: list[Result] = []

    def failed(what: str, error: RtkitError) -> None:
        failures.append(Result(kind=error.kind, why=str(error), value=what))

    _adopt(state)
    kept = state.kept
    for row, init in list(kept.modules.items()):
        path = module_path(row, init)
        if known(state, path, init) is None:
            yield from _try(state, act.Load(path, init), f"load {path}", failed)
    resume((yield ReadClock()))
    awaited = {*kept.zombies, *state.returning}
    yield from revive(state, [each for each in kept.components if each not in awaited], failed)
    return Result(value=results_to_text(failures))


def repair(state: ManagerState, instances: Collection[str]) -> Procedure:
    """Adopt what a slave holds that has come back late, and do what is missing of it."""

    def failed(what: str, error: RtkitError) -> None:
        _log.warning("cannot %s: %s", what, error)

    _adopt(state)
    busy = {*state.returning, *state.ending}
    known = [each for each in instances if each in state.kept.components and each not in busy]
    yield from revive(state, known, failed)
    return Result()


def note_loss(state: ManagerState, instance: str) -> Procedure:
    """Keep that a component has died by itself: who dies together with his manager has not."""
    yield Sleep(_TOGETHER_S)
    facts = state.components.get(instance)
    if facts is not None and facts.zombie:
        state.kept.lost(facts)
    return Result()


class _Bonds(NamedTuple):
    """Missing links between components, looked up once for all.

    Attributes:
        wires: Connectors that are missing, by the instances at their ends.
        shares: Owner, context and participant of each context that drives another component.
    """

    wires: Mapping[str, list[ConnectorProfile]]
    shares: list[tuple[str, str, str]]


def _bonds(state: ManagerState) -> _Bonds:
    connectors: dict[str, list[ConnectorProfile]] = {}
    for connector in state.kept.wires.values():
        if connector.connector_id not in state.connectors:
            for end in connector.ports:
                connectors.setdefault(end.instance, []).append(connector)
    shares = [
        (owner, context, participant)
        for owner, desired in state.kept.components.items()
        for context, participants in desired.attached.items()
        for participant in participants
    ]
    return _Bonds(connectors, shares)


def revive(state: ManagerState, instances: Collection[str], failed: Failed) -> Steps:
    """Bring components to what is desired of them: made, configured, connected and active.

    One that is made waits only for those to which it is bound, one that lives for nobody. `failed`
    is called with what failed, and why.
    """
    bonds = _bonds(state)
    groups = _groups(state, instances, bonds)
    yield Gather(tuple(_complete(state, group, bonds, failed) for group in groups))


def _groups(state: ManagerState, instances: Collection[str], bonds: _Bonds) -> list[list[str]]:
    """Return what is to be done together: of what is missing, whoever is bound to each other."""
    missing = {each for each in instances if not lives(state, each)}
    group_of = {each: [each] for each in instances}
    for bond in _bound(state, missing, bonds):
        first, *others = [each for each in bond if each in missing] or [""]
        for other in others:
            ours, theirs = group_of[first], group_of[other]
            if ours is not theirs:
                ours.extend(theirs)
                group_of.update(dict.fromkeys(theirs, ours))
    return list({id(group): group for group in group_of.values()}.values())


def _bound(state: ManagerState, missing: Iterable[str], bonds: _Bonds) -> Iterable[tuple[str, ...]]:
    """Yield instances that are connected, share a context, or make a composite."""
    for instance in missing:
        for connector in bonds.wires.get(instance, ()):
            yield tuple(end.instance for end in connector.ports)
        desired = state.kept.components[instance]
        if _is_composite(desired):
            members = parse_create(desired.create).options["members"].split(",")
            yield (instance, *(each.strip() for each in members))
    for owner, _, participant in bonds.shares:
        yield owner, participant


def _complete(
    state: ManagerState, group: Collection[str], bonds: _Bonds, failed: Failed
) -> Procedure:
    """Bring those to their end that are bound to each other."""
    wanted = state.kept.components
    fresh = [each for each in group if not lives(state, each)]
    yield from _make_all(state, fresh, failed)
    ready = {
        each: DesiredComponent("") if each in fresh else state.since_made.get(each, wanted[each])
        for each in group
        if each in wanted and _answers(state, each)
    }
    for each in (*fresh, *ready):
        state.since_made.pop(each, None)
    # Ports of a composite come with its configuration; those of others are there.
    composites = [each for each in ready if _is_composite(wanted[each])]
    yield Gather(tuple(_configure(state, i, ready[i], failed) for i in composites))
    single = (each for each in ready if each not in composites)
    configures = (_configure(state, i, ready[i], failed) for i in single)
    yield Gather((*configures, *_connects(state, ready, bonds, failed)))
    yield from _attach(state, ready, fresh, bonds, failed)
    yield Gather(
        tuple(
            _activate(state, instance, context, failed)
            for instance, asked in ready.items()
            if instance in wanted
            for context in wanted[instance].active
            if context not in asked.active
        )
    )
    return Result()


def _make_all(state: ManagerState, instances: Collection[str], failed: Failed) -> Steps:
    """Make components side by side, composites last."""
    kept = state.kept
    wanted = {each: kept.components[each] for each in instances if each in kept.components}
    kept.revived.update(wanted)
    try:
        single = [(each, desired) for each, desired in wanted.items() if not _is_composite(desired)]
        yield Gather(tuple(_make(state, each, desired, failed) for each, desired in single))
        for instance, desired in wanted.items():
            if _is_composite(desired):
                yield Gather((_make(state, instance, desired, failed),))
    finally:
        kept.revived.difference_update(wanted)


def _connects(
    state: ManagerState, instances: Iterable[str], bonds: _Bonds, failed: Failed
) -> Iterable[Procedure]:
    """Yield what makes the connectors of components that are missing, if both ends answer."""
    connectors = {
        connector.connector_id: connector
        for each in instances
        for connector in bonds.wires.get(each, ())
    }
    missing = [
        connector
        for connector in connectors.values()
        if connector.connector_id not in state.connectors
        and connector.connector_id in state.kept.wires
    ]
    for connector in missing:
        if peer_of(connector):
            revive_half(state, connector)
    return [
        _try(state, act.Connect(connector), f"connect {connector.connector_id}", failed)
        for connector in missing
        if all(_answers(state, end.instance) for end in connector.ports)
    ]


def _answers(state: ManagerState, instance: str) -> bool:
    process = state.process_of(instance)
    return lives(state, instance) and process is not None and not process.unfit


def lives(state: ManagerState, instance: str) -> bool:
    """Return whether a component exists and is no zombie."""
    facts = state.components.get(instance)
    return facts is not None and not facts.zombie


def _adopt(state: ManagerState) -> None:
    """Record as desired what is found alive: it was made, or its record is lost."""
    kept: DesiredState = state.kept
    for instance, facts in state.components.items():
        process = state.process_of(instance)
        if facts.zombie or process is None or process.is_guest:
            continue
        kept.drop("zombie", instance)
        if instance not in kept.components and facts.create and not facts.is_stand_in:
            kept.adopt(facts, state.since_made.get(instance))
    for instance, desired in kept.components.items():
        if read_rules(parse_create(desired.create).options):
            state.ruled.add(instance)
    for connector in state.connectors.values():
        if all(end.instance in kept.components for end in connector.ports):
            kept.put("wire", connector.connector_id, connector)


def _is_composite(desired: DesiredComponent) -> bool:
    return "members" in parse_create(desired.create).options


def _activate(state: ManagerState, instance: str, context: str, failed: Failed) -> Procedure:
    """Activate a component unless it is, or comes to be meanwhile by what was asked before."""
    if not _is_active(state, instance, context):
        try:
            yield from procedure_for(act.ChangeState(instance, context, Transition.ACTIVATE), state)
        except RtkitError as error:
            if not _is_active(state, instance, context):
                failed(f"activate {instance}", error)
    return Result()


def _is_active(state: ManagerState, instance: str, context: str) -> bool:
    facts = state.components.get(instance)
    contexts = facts.contexts if facts is not None else ()
    return any(c.id == context and c.state is LifeCycleState.ACTIVE for c in contexts)


def _make(state: ManagerState, instance: str, row: DesiredComponent, failed: Failed) -> Procedure:
    from rtkit.rtc.pattern import ComponentPattern

    try:
        pattern = decode(ComponentPattern, json.loads(row.pattern)) if row.pattern else None
    except (ValueError, Malformed) as error:
        failed(f"create {instance}", Malformed(str(error)))
        return Result()
    create = act.Create(row.create, row.names, pattern)
    return (yield from _try(state, create, f"create {instance}", failed))


def _configure(
    state: ManagerState, instance: str, asked: DesiredComponent, failed: Failed
) -> Procedure:
    """Give a component what is desired and was not asked of it since it was made."""
    if lives(state, instance) and instance in state.kept.components:
        for action in list(_settings(state, instance, asked)):
            yield from _try(state, action, f"configure {instance}", failed)
    return Result()


def _settings(state: ManagerState, instance: str, asked: DesiredComponent) -> Iterable[Action]:
    facts, desired = state.components[instance], state.kept.components[instance]
    for set_id, values in desired.sets.items():
        now, last = facts.sets.get(set_id, {}), asked.sets.get(set_id, {})
        changed = {k: v for k, v in values.items() if v not in (now.get(k), last.get(k))}
        if changed:
            adds = "" if set_id in facts.sets else act.MISSING
            yield act.SetParameters(instance, set_id, changed, adds)
    if desired.active_set not in ("", facts.active_set, asked.active_set):
        yield act.ActivateSet(instance, desired.active_set)
    if desired.states != asked.states:
        yield act.SetStructure(instance, desired.states)
    if desired.events != asked.events:
        yield act.SetEventProfiles(instance, desired.events)
    for context, rate in desired.rates.items():
        if rate != asked.rates.get(context):
            yield act.SetRate(instance, context, rate)


def _attach(
    state: ManagerState,
    ready: Collection[str],
    fresh: Collection[str],
    bonds: _Bonds,
    failed: Failed,
) -> Steps:
    """Attach those that take no part yet in contexts in which they shall."""
    for owner, context, each in bonds.shares:
        is_ours = each in ready or owner in fresh
        if is_ours and lives(state, owner) and not _takes_part(state, each, owner, context):
            action = act.Attach(owner, context, each)
            yield from _try(state, action, f"attach {each} to {owner}", failed)


def _takes_part(state: ManagerState, instance: str, owner: str, context: str) -> bool:
    facts = state.components.get(instance)
    return facts is not None and any(c.id == f"{owner}/{context}" for c in facts.contexts)


def _try(state: ManagerState, action: Action, what: str, failed: Failed) -> Procedure:
    try:
        yield from procedure_for(action, state)
    except RtkitError as error:
        failed(what, error)
    return Result()
