"""What is wished and does not live is made again: created, configured, connected, activated.

With places fixed the cheapest plan is the difference itself, in the order of its kinds; so nothing
is searched for. What fails is told, and the rest is done all the same.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Collection, Generator, Iterable
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.batch import results_to_text
from rtkit.deployment.health import read_rules
from rtkit.errors import Malformed, RtkitError
from rtkit.manager.core.kept import Kept, Wish
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.state import State
from rtkit.manager.core.wishes import Pause, Procedure, Together
from rtkit.manager.core.wishes import Wish as Yielded
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.plain import decode

_log = logging.getLogger(__name__)
RESTORE_S = 10.0
"""How long each step may take [s]."""

_TOGETHER_S = 1.0
"""Who dies within this time of each other was ended together [s]."""

Steps = Generator[Yielded, Any, None]
Failed = Callable[[str, RtkitError], object]


def restore(state: State) -> Procedure:
    """Adopt what lives and is not known, and make what is known and does not live.

    Its value are the failures, as results of which each names in its value what failed.
    """
    failures: list[Result] = []

    def failed(what: str, error: RtkitError) -> None:
        failures.append(Result(kind=error.kind, why=str(error), value=what))

    _adopt(state)
    kept = state.kept
    for path, init in list(kept.modules.items()):
        if path not in state.modules:
            yield from _try(state, act.Load(path, init), f"load {path}", failed)
    awaited = {*kept.zombies, *state.returning}
    missing = [i for i in kept.components if i not in awaited and not lives(state, i)]
    yield from revive(state, missing, failed)
    return Result(value=results_to_text(failures))


def note_loss(state: State, instance: str) -> Procedure:
    """Keep that a component has died by itself: who dies together with his manager has not."""
    yield Pause(_TOGETHER_S)
    facts = state.components.get(instance)
    if facts is not None and facts.zombie:
        state.kept.lost(facts)
    return Result()


def revive(state: State, instances: Collection[str], failed: Failed) -> Steps:
    """Make components again as they are wished, with the connectors that are missing.

    `failed` is called with what failed, and why.
    """
    kept = state.kept
    wishes = {each: kept.components[each] for each in instances}
    composites = {each: wish for each, wish in wishes.items() if _is_composite(wish)}
    kept.revived.update(wishes)
    single = dict.fromkeys(i for i in wishes if i not in composites)
    try:
        yield Together(tuple(_make(state, i, wishes[i], failed) for i in single))
        for instance, wish in composites.items():
            yield Together((_make(state, instance, wish, failed),))
    finally:
        kept.revived.difference_update(wishes)
    living = [each for each in wishes if lives(state, each)]
    # Ports of a composite come with its configuration; those of others are there.
    arranged = [each for each in living if each in composites]
    yield Together(tuple(_configure(state, i, wishes[i], failed) for i in arranged))
    configures = (_configure(state, i, wishes[i], failed) for i in living if i in single)
    yield Together((*configures, *_connects(state, failed)))
    yield from _attach(state, living, failed)
    yield Together(
        tuple(
            _done(state, act.ChangeState(i, context, Transition.ACTIVATE), f"activate {i}", failed)
            for i in living
            if i in kept.components
            for context in kept.components[i].active  # it may have been wished otherwise meanwhile
            if not _is_active(state, i, context)
        )
    )


def reconnect(state: State) -> Procedure:
    """Make connectors again with a slave that has come back late."""

    def failed(what: str, error: RtkitError) -> None:
        _log.warning("cannot %s: %s", what, error)

    yield Together(tuple(_connects(state, failed)))
    return Result()


def _connects(state: State, failed: Failed) -> Iterable[Procedure]:
    """Yield what makes the connectors that are missing between components that answer."""
    missing = [
        wire
        for wire in state.kept.wires.values()
        if wire.connector_id not in state.connectors
        and wire.connector_id not in state.openings
        and all(_answers(state, end.instance) for end in wire.ports)
    ]
    for wire in missing:
        yield _done(state, act.Connect(wire), f"connect {wire.connector_id}", failed)


def _answers(state: State, instance: str) -> bool:
    process = state.process_of(instance)
    return lives(state, instance) and process is not None and not process.unfit


def lives(state: State, instance: str) -> bool:
    """Whether a component is there, and no zombie."""
    facts = state.components.get(instance)
    return facts is not None and not facts.zombie


def _adopt(state: State) -> None:
    """Take for wished what is found alive: it was made, or its record is lost."""
    kept: Kept = state.kept
    for instance, facts in state.components.items():
        process = state.process_of(instance)
        if facts.zombie or process is None or process.is_guest:
            continue
        kept.found(instance)
        if instance not in kept.components and facts.create and not facts.is_stand_in:
            kept.adopt(facts)
    for instance, wish in kept.components.items():
        if read_rules(parse_create(wish.create).options):
            state.ruled.add(instance)
    for wire in state.connectors.values():
        if all(end.instance in kept.components for end in wire.ports):
            kept.wire(wire)


def _is_composite(wish: Wish) -> bool:
    return "members" in parse_create(wish.create).options


def _is_active(state: State, instance: str, context: str) -> bool:
    contexts = state.components[instance].contexts
    return any(c.id == context and c.state is LifeCycleState.ACTIVE for c in contexts)


def _make(state: State, instance: str, wish: Wish, failed: Failed) -> Procedure:
    from rtkit.rtc.pattern import ComponentPattern

    try:
        pattern = decode(ComponentPattern, json.loads(wish.pattern)) if wish.pattern else None
    except (ValueError, Malformed) as error:
        failed(f"create {instance}", Malformed(str(error)))
        return Result()
    create = act.Create(wish.create, wish.names, pattern)
    return (yield from _done(state, create, f"create {instance}", failed))


def _configure(state: State, instance: str, wish: Wish, failed: Failed) -> Procedure:
    """Give a component that was made again what users had set."""
    for action in _settings(state, instance, wish):
        yield from _try(state, action, f"configure {instance}", failed)
    return Result()


def _settings(state: State, instance: str, wish: Wish) -> Iterable[Action]:
    facts = state.components[instance]
    for set_id, values in wish.sets.items():
        now = facts.sets.get(set_id, {})
        changed = {key: value for key, value in values.items() if now.get(key) != value}
        if changed:
            yield act.SetParameters(instance, set_id, changed)
    if wish.active_set not in ("", facts.active_set):
        yield act.ActivateSet(instance, wish.active_set)
    if wish.states:
        yield act.SetStructure(instance, wish.states)
    if wish.events:
        yield act.SetEventProfiles(instance, wish.events)
    for context, rate in wish.rates.items():
        yield act.SetRate(instance, context, rate)


def _attach(state: State, revived: Collection[str], failed: Failed) -> Steps:
    for owner, wish in list(state.kept.components.items()):
        for context, participants in wish.attached.items():
            for each in participants:
                if owner in revived or each in revived:
                    action = act.Attach(owner, context, each)
                    yield from _try(state, action, f"attach {each} to {owner}", failed)


def _done(state: State, action: Action, what: str, failed: Failed) -> Procedure:
    yield from _try(state, action, what, failed)
    return Result()


def _try(state: State, action: Action, what: str, failed: Failed) -> Steps:
    try:
        yield from procedure_for(action, state)
    except RtkitError as error:
        failed(what, error)
