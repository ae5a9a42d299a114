"""Converts the steps of a plan into actions of a manager."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import zip_longest

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.drift import policy_text
from rtkit.deployment.extension import policy_in
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.layered_plan import Layer, PlannedAction
from rtkit.deployment.live_index import LiveIndex, context_of
from rtkit.deployment.planning.component_settings import ACTIVE_SET, NAME, NAMELESS, POLICY, RATE
from rtkit.deployment.planning.model import Model, is_inproc, manager_of, owner_of
from rtkit.deployment.planning.operators import Operator
from rtkit.deployment.system import WantedSystem
from rtkit.errors import Refused
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState, Transition
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import ConnectorProfile, split_module

_TRANSITIONS = {
    "activate": (Transition.ACTIVATE, LifeCycleState.INACTIVE),
    "deactivate": (Transition.DEACTIVATE, LifeCycleState.ACTIVE),
    "reset": (Transition.RESET, LifeCycleState.ERROR),
}


class ActionBuilder:
    """Turns steps into actions, by the wanted system and the snapshots before and now."""

    def __init__(self, system: WantedSystem, before: LiveIndex) -> None:
        self._system = system
        self._before = before
        self._wanted = {component.instance: component for component in system.components}
        self._connectors = {
            connector.connector_id: connector for connector in before.snapshot.connectors
        }
        self._connectors.update((w.profile.connector_id, w.profile) for w in system.connectors)

    def layers(
        self, name: str, moves: list[Operator], model: Model, live: LiveIndex
    ) -> Iterator[Layer]:
        """Yield the actions of steps that may be done at once; a step may take a second one."""
        rounds = [
            [
                PlannedAction(move.text, action, is_required=True, where=move.text)
                for action in actions
            ]
            for move in moves
            if (actions := list(self._actions(move, model, live)))
        ]
        for steps in zip_longest(*rounds):
            chosen: list[PlannedAction] = []
            for step in steps:
                # Several parameters of one set need it to be taken over once.
                if step is not None and all(step.action != each.action for each in chosen):
                    chosen.append(step)
            yield Layer(name, tuple(chosen))

    def _actions(self, move: Operator, model: Model, live: LiveIndex) -> Iterator[Action]:
        match move.kind:
            case "load":
                manager, module = _module(move, live)
                yield act.Load(*split_module(module), manager)
            case "unload":
                manager, module = _module(move, live)
                yield act.Unload(split_module(module)[0], manager)
            case "create" | "create_slave":
                yield self._create(move.subject, move.value)
            case "delete":
                yield act.Delete(move.subject)
            case "connect" | "disconnect":
                yield self._connection(move)
            case "configure":
                yield from self._configure(move, live)
            case "install" | "uninstall":
                return  # the one who carries the plan out does that, by no manager
            case "start_manager":
                start = f"rtmgr start {move.subject}"
                raise Refused(f"manager {move.subject} does not run; start it with: {start}")
            case _:
                yield from self._transitions(move, live)

    def _create(self, name: str, place: str) -> Action:
        wanted = self._wanted.get(name)
        was = self._before.namesake(name)
        if wanted is not None and self._before.create_of(wanted):
            text, pattern = self._before.create_of(wanted), wanted.pattern
            names: tuple[str, ...] = (wanted.name, *wanted.more_names)
        else:
            assert was is not None
            text, names = was.create, was.names
            pattern = _pattern(was) if was.is_stand_in else None
        slave = place.partition("/")[2]
        create = parse_create(text)
        if slave and create.place != slave:
            create = create.with_options(manager_name=slave)
        elif is_inproc(place):
            create = create.with_options(manager_name="")
        manager = manager_of(place) if self._before.snapshot.others else ""
        return act.Create(str(create), names, pattern, manager=manager)

    def _connection(self, move: Operator) -> Action:
        parts = move.subject.split("\n")
        if len(parts) == 3:
            return act.Attach(*parts) if move.kind == "connect" else act.Detach(*parts)
        if move.kind == "disconnect":
            return act.Disconnect(move.subject)
        connector: ConnectorProfile = self._connectors[move.subject]
        return act.Connect(connector)

    def _configure(self, move: Operator, live: LiveIndex) -> Iterator[Action]:
        name = owner_of(move.subject)
        key = move.subject.partition(".")[2]
        if key == ACTIVE_SET:
            yield act.ActivateSet(name, move.value)
        elif key.startswith(NAME):
            alias = key.removeprefix(NAME)
            is_back = move.value == NAMELESS
            yield act.Unregister(alias) if is_back else act.Register(name, alias)
        elif key == POLICY:
            yield act.SetPolicy(name, self._policy(name, move.value))
        elif key.startswith(RATE):
            yield act.SetRate(name, key.removeprefix(RATE), float(move.value))
        else:
            yield from self._set(name, key, move.value, live)

    def _policy(self, name: str, text: str) -> Mapping[str, str]:
        """Return the policy that is sent: the wanted one, else the one of before."""
        wanted = self._wanted.get(name)
        if wanted is not None and wanted.policy is not None and policy_text(wanted.policy) == text:
            return wanted.policy
        was = self._before.namesake(name)
        return policy_in(was.create) if was is not None else {}

    def _set(self, name: str, key: str, value: str, live: LiveIndex) -> Iterator[Action]:
        set_id, _, parameter = key.partition(".")
        facts = live.namesake(name)
        is_there = facts is not None and set_id in facts.sets
        yield act.SetParameters(name, set_id, {parameter: value}, "" if is_there else act.MISSING)
        if facts is not None and facts.active_set == set_id:
            # A component sees what is written only when the set is taken over again.
            yield act.ActivateSet(name, set_id)

    def _transitions(self, move: Operator, live: LiveIndex) -> Iterator[Action]:
        transition, state = _TRANSITIONS[move.kind]
        facts, wanted = live.namesake(move.subject), self._wanted.get(move.subject)
        if facts is None:
            return
        contexts = [c for c in facts.contexts if c.owner == facts.instance]
        if wanted is not None:
            meant = (context_of(facts, wanted, n) for n in range(len(wanted.contexts)))
            contexts = [context for context in meant if context is not None]
        if move.kind != "activate":
            contexts = list(facts.contexts)
        for context in contexts:
            if context.state is state:
                yield act.ChangeState(move.subject, context.id, transition)


def _module(move: Operator, live: LiveIndex) -> tuple[str, str]:
    """Return a module with its manager, which is empty for the first one."""
    manager, _, module = move.subject.partition("/")
    return "" if manager == live.snapshot.manager else manager, module


def _pattern(facts: ComponentFacts) -> ComponentPattern:
    contexts = tuple(
        ContextPattern(c.id, c.kind, c.rate) for c in facts.contexts if c.owner == facts.instance
    )
    return ComponentPattern(facts.type, facts.ports, facts.sets, facts.active_set, contexts)
