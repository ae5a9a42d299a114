"""A pure fake of a manager: it holds facts and performs actions on them with a manager's refusals.

Tests of plans and commands use it, and it foresees the result of a plan. It has no process and no
clock.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping

import fake_composites as composites

from rtkit.component.check import WRONG_TYPE, refusal
from rtkit.component.period import check_rate
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.extension import with_policy
from rtkit.deployment.facts import ComponentFacts, Followed, ProcessFacts, Snapshot
from rtkit.deployment.lease import Immortal, Lease
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.rtc.create import FRESH_SLAVE, CreateString, parse_create
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType, ReturnCode, Transition
from rtkit.rtc.interface_types import differing
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX, check_instance_name
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    ModuleProfile,
)

_TRANSITIONS = {
    (LifeCycleState.INACTIVE, Transition.ACTIVATE): LifeCycleState.ACTIVE,
    (LifeCycleState.ACTIVE, Transition.ACTIVATE): LifeCycleState.ACTIVE,
    (LifeCycleState.ACTIVE, Transition.DEACTIVATE): LifeCycleState.INACTIVE,
    (LifeCycleState.INACTIVE, Transition.DEACTIVATE): LifeCycleState.INACTIVE,
    (LifeCycleState.ERROR, Transition.RESET): LifeCycleState.INACTIVE,
    (LifeCycleState.INACTIVE, Transition.RESET): LifeCycleState.INACTIVE,
}
_MASTER_PID = 1000


class FakeManager:
    """A manager with its slaves, components and connectors, as facts.

    Attributes:
        types: What can be created, by implementation id.
        modules: What a module offers once it is loaded, by path.
        fault: Called before each action; a returned result is its outcome (to make it fail).
        lacking: Why nothing can be made of a type, by implementation id; others may be made.
        performed: Every action performed, in order.
        changed: Called after facts of a component changed.
        lease: Who carries a plan out.
        systems: What a manager would report of those that it follows; nobody follows them here.
    """

    def __init__(
        self,
        types: Iterable[ComponentPattern] = (),
        *,
        host: str = "box",
        manager: str = "manager",
        modules: Mapping[str, Iterable[ComponentPattern]] | None = None,
    ) -> None:
        self.host = host
        self.manager = manager
        self.types = {pattern.type.type_name: pattern for pattern in types}
        self.modules = {path: tuple(made) for path, made in (modules or {}).items()}
        self.loaded: dict[str, ModuleProfile] = {}
        self.processes: dict[str, ProcessFacts] = {
            manager: ProcessFacts(manager, False, _MASTER_PID, "up")
        }
        self.components: dict[str, ComponentFacts] = {}
        self.connectors: dict[str, ConnectorProfile] = {}
        self.properties: dict[str, str] = {}
        self.lacking: dict[str, str] = {}
        self.names: tuple[str, ...] = (f"{LOCAL}/{manager}{MANAGER_SUFFIX}",)
        self.systems: tuple[Followed, ...] = ()
        self.fault: Callable[[Action], Result | None] = _no_fault
        self.performed: list[Action] = []
        self.changed: Callable[[], object] = _nothing
        self.lease = Lease(lambda _pid: Immortal())
        self._pids = itertools.count(_MASTER_PID + 1)

    def snapshot(self) -> Snapshot:
        """Return everything that is known, as a manager would."""
        return Snapshot(
            self.host,
            self.manager,
            _MASTER_PID,
            "fake",
            tuple(self.processes.values()),
            tuple(self.components.values()),
            tuple(self.connectors.values()),
            tuple(self.loaded.values()),
            dict(self.properties),
            self.names,
            self.systems,
        )

    def perform(self, action: Action) -> Result:
        """Perform one action and return its outcome."""
        self.performed.append(action)
        planned = self.fault(action)
        if planned is not None:
            return planned
        try:
            done = Result(value=self._do(action))
            self.changed()
            return done
        except RtkitError as error:
            is_bad = isinstance(error, (ValueError, LookupError))
            code = ReturnCode.BAD_PARAMETER if is_bad else ReturnCode.PRECONDITION_NOT_MET
            return Result(code, error.kind, str(error))

    def batch(self, actions: Iterable[Action], is_ordered: bool = True) -> list[Result]:
        """Perform actions; in order, the first failure ends the batch."""
        results = []
        for action in actions:
            results.append(self.perform(action))
            if is_ordered and not results[-1].ok:
                break
        return results

    def kill(self, process: str, reason: str = "signal 9") -> None:
        """End a slave as the kernel would: its components become zombies without connectors."""
        self.processes[process] = replace(self.processes[process], state="lost", reason=reason)
        for component in [c for c in self.components.values() if c.process == process]:
            self.update(component.instance, zombie=reason)
            self._unwire(component.instance)

    def update(self, instance: str, **changes: object) -> None:
        """Replace facts of a component."""
        changed = replace(self.components[instance], **changes)  # type: ignore[arg-type]
        self.components[instance] = changed
        self.changed()

    def state_of(self, instance: str) -> str:
        """Return the merged state of a component."""
        return self.components[instance].state

    def set_state(self, instance: str, state: LifeCycleState, cause: str = "") -> None:
        """Put a component into a state, as if something had happened to it."""
        contexts = self.components[instance].contexts
        self.update(
            instance, contexts=tuple(replace(c, state=state) for c in contexts), cause=cause
        )

    def _do(self, action: Action) -> str:
        match action:
            case act.Load():
                return self._load(action)
            case act.Unload(path):
                if self.loaded.pop(path, None) is None:
                    raise NotFound(f"module is not loaded: {path}")
            case act.Create():
                return self._create(action)
            case act.Delete(instance, _, slave):
                self._delete(instance, slave)
            case act.EndSlave(name):
                self._end_slave(name)
            case act.Unregister():
                self._unregister(action)
            case act.Register(instance, name):
                self._register(instance, name)
            case act.Connect(connector):
                return self._connect(connector)
            case act.Disconnect(connector_id):
                if self.connectors.pop(connector_id, None) is None:
                    raise NotFound(f"no connection with id {connector_id}")
            case act.SetParameters():
                self._set(action)
            case act.ActivateSet(instance, set_id):
                self._activate_set(instance, set_id)
            case act.ChangeState():
                self._change_state(action)
            case act.SetPolicy(instance, policy):
                create = with_policy(self._living(instance).create, policy)
                self.update(instance, create=create)
            case act.SetRate() | act.Tick():
                self._drive(action)
            case act.Attach() | act.Detach():
                self._share(action)
            case act.SetStructure(instance, states):
                self._machine(instance, fsm_states=states, fsm_state=next(iter(states), ""))
            case act.SetEventProfiles(instance, events):
                self._machine(instance, fsm_events=events)
        return ""

    def _load(self, action: act.Load) -> str:
        made = self.modules.get(action.path)
        if made is None:
            raise NotFound(f"no module at {action.path}")
        self.types.update((pattern.type.type_name, pattern) for pattern in made)
        types = tuple(pattern.type for pattern in made)
        self.loaded[action.path] = ModuleProfile(action.path, action.init, types)
        return action.path

    def _create(self, action: act.Create) -> str:
        create = parse_create(action.create)
        known = self.components.get(create.instance_name)
        if known is not None and not known.zombie:
            return known.instance
        pattern = action.pattern or self._type(create)
        names = action.names or (known.names if known is not None else ())
        instance = create.instance_name or self._fresh_name(pattern.type.type_name)
        check_instance_name(instance)
        for other in self.components.values():
            taken = [name for name in names if name in other.names and other.instance != instance]
            if taken:
                raise Refused(f"name /{taken[0]} is taken by {other.instance}")
        if known is not None:
            del self.components[instance]
            self._retire(known.process)
        process = self._place(create.place or composites.home(self.components, create))
        made = create.with_options(
            instance_name=instance, manager_name=process if create.place else ""
        )
        facts = component_from(
            pattern,
            instance,
            process,
            names=names or (f"{LOCAL}/{instance}{COMPONENT_SUFFIX}",),
            create=str(made),
            is_stand_in=action.pattern is not None,
        )
        self._arrange(composites.made(facts, create))
        return instance

    def _type(self, create: CreateString) -> ComponentPattern:
        name = create.implementation_id
        pattern = self.types.get(name) or composites.pattern_of(name)
        if pattern is None:
            raise NotFound(f"no component type {create.implementation_id}")
        for field in ("vendor", "category", "version"):
            wanted = getattr(create, field)
            if wanted and wanted != getattr(pattern.type, field):
                raise NotFound(f"no component type {create.implementation_id} of {field} {wanted}")
        return pattern

    def _fresh_name(self, base: str) -> str:
        return next(
            name for n in itertools.count() if (name := f"{base}{n}") not in self.components
        )

    def _place(self, place: str) -> str:
        if place in ("", self.manager):
            return self.manager
        pid = next(self._pids)
        name = place.replace("%p", str(pid)) if place == FRESH_SLAVE else check_instance_name(place)
        process = self.processes.get(name)
        if process is None or process.state == "lost":
            self.processes[name] = ProcessFacts(name, True, pid, "up")
        return name

    def _retire(self, process: str) -> None:
        facts = self.processes[process]
        if facts.is_slave and not any(c.process == process for c in self.components.values()):
            del self.processes[process]

    def _delete(self, instance: str, slave: str = "") -> None:
        known = self.components.get(instance)
        if known is None or slave not in ("", known.process):
            raise NotFound(f"no component named {instance}" + f" in {slave}" * bool(slave))
        del self.components[instance]
        self.components |= composites.parted(self.components, instance)
        self._unwire(instance)
        self._retire(known.process)

    def _end_slave(self, name: str) -> None:
        known = self.processes.get(name)
        if known is None:
            raise NotFound(f"no slave named {name}")
        if known.state == "lost":
            raise Refused(f"slave {name} has ended already: {known.reason}")
        for instance in [c.instance for c in self.components.values() if c.process == name]:
            self._delete(instance)
        self.processes.pop(name, None)

    def _unwire(self, instance: str) -> None:
        self.connectors = {
            key: wire
            for key, wire in self.connectors.items()
            if all(end.instance != instance for end in wire.ports)
        }

    def _living(self, instance: str) -> ComponentFacts:
        known = self.components.get(instance)
        if known is None:
            raise NotFound(f"no component named {instance}")
        if known.zombie:
            raise Refused(f"zombie ({known.zombie}): {instance}")
        return known

    def _connect(self, wire: ConnectorProfile) -> str:
        known = self.connectors.get(wire.connector_id)
        own = OwnEnds(self.components)
        if known is not None:
            _check_same(known, own.wire(wire))
            return wire.connector_id
        if len(wire.ports) != 2:
            raise Malformed(f"a connection joins two ports, not {len(wire.ports)}")
        ports = []
        for end in wire.ports:
            port = self._living(end.instance).port(end.port)
            if port is None:
                raise NotFound(f"Port not found: {end}")
            ports.append(port)
        why = refusal(ports, wire.properties)
        if not why and ports[0].port_type is PortType.IN:
            why = WRONG_TYPE
        if why:
            raise Refused(why)
        self.connectors[wire.connector_id] = own.wire(wire)
        return wire.connector_id

    def _unregister(self, action: act.Unregister) -> None:
        name = action.name
        bearer = next((c for c in self.components.values() if name in c.names), None)
        if bearer is None and name not in self.names:
            raise NotFound(f"nothing is registered as /{name}")
        if action.is_zombie and (bearer is None or not bearer.zombie):
            raise Refused(f"no zombie is registered as /{name}")
        if bearer is None:
            self.names = tuple(each for each in self.names if each != name)
            return
        left = tuple(each for each in bearer.names if each != name)
        self.update(bearer.instance, names=left)
        if bearer.zombie and not left:
            del self.components[bearer.instance]
            self._retire(bearer.process)

    def _register(self, instance: str, name: str) -> None:
        bearer = next((c for c in self.components.values() if name in c.names), None)
        names = self._living(instance).names
        if bearer is not None and bearer.instance != instance:
            raise Refused(f"name /{name} is taken by {bearer.instance}")
        self.update(instance, names=tuple(dict.fromkeys((*names, name))))

    def _set(self, action: act.SetParameters) -> None:
        known = self._living(action.instance)
        present = known.sets.get(action.set_id)
        if present is None:
            raise NotFound(f"No such configuration set: {action.set_id}")
        for name in action.values:
            if name not in present:
                raise NotFound(f"No such configuration parameter: {name}")
        changed = {**present, **action.values}
        self._arrange(replace(known, sets={**known.sets, action.set_id: changed}))

    def _activate_set(self, instance: str, set_id: str) -> None:
        known = self._living(instance)
        if not set_id or set_id.startswith("_"):
            raise Refused(f"configuration set {set_id or repr('')} cannot be activated")
        if set_id not in known.sets:
            raise NotFound(f"No such configuration set: {set_id}")
        self._arrange(replace(known, active_set=set_id))

    def _arrange(self, facts: ComponentFacts) -> None:
        """Take the facts of a component in, and what they change if it is a composite."""
        self.components |= {facts.instance: facts, **composites.arranged(self.components, facts)}
        self.changed()

    def _change_state(self, action: act.ChangeState) -> None:
        known = self._living(action.instance)
        context = next((c for c in known.contexts if c.id == action.context), None)
        if context is None:
            raise NotFound(f"{action.instance} has no execution context {action.context}")
        after = _TRANSITIONS.get((context.state, action.transition))
        if after is None:
            raise Refused(f"precondition not met (state is {context.state})")
        contexts = tuple(replace(c, state=after) if c is context else c for c in known.contexts)
        self.update(action.instance, contexts=contexts, cause="")

    def _drive(self, action: act.SetRate | act.Tick) -> None:
        known = self._living(action.instance)
        context = next((c for c in known.contexts if c.id == action.context), None)
        if context is None:
            raise NotFound(f"no execution context {action.context} on {action.instance}")
        is_periodic = context.kind is ExecutionKind.PERIODIC
        if isinstance(action, act.SetRate) and is_periodic:
            changed = replace(context, rate=check_rate(action.rate))
            contexts = tuple(changed if c is context else c for c in known.contexts)
            self.update(action.instance, contexts=contexts)
        elif is_periodic is isinstance(action, act.Tick):
            raise Refused(f"execution context {context.id} of {known.instance} is {context.kind}")

    def _machine(self, instance: str, **changes: object) -> None:
        if not self._living(instance).fsm_states:
            raise Refused(f"{instance} has no state machine")
        self.update(instance, **changes)

    def _share(self, action: act.Attach | act.Detach) -> None:
        owner, driven = self._living(action.owner), self._living(action.participant)
        context = next((c for c in owner.contexts if c.id == action.context), None)
        if context is None:
            raise NotFound(f"no execution context {action.context} on {owner.instance}")
        if owner.process != driven.process:
            raise Refused(f"{driven.instance} is in {driven.process}, not in {owner.process}")
        if (driven.instance in context.participants) is isinstance(action, act.Attach):
            raise Refused(f"{driven.instance}: no such change of execution context {context.id}")
        members = [name for name in context.participants if name != driven.instance]
        if isinstance(action, act.Attach):
            members.append(driven.instance)
        handle = f"{owner.instance}/{context.id}"
        others = tuple(c for c in driven.contexts if c.id != handle)
        seen = replace(context, participants=tuple(members))
        if isinstance(action, act.Attach):
            others += (replace(seen, id=handle, state=LifeCycleState.INACTIVE),)
        self.update(driven.instance, contexts=others)
        contexts = tuple(seen if c is context else c for c in owner.contexts)
        self.update(owner.instance, contexts=contexts)


def component_from(
    pattern: ComponentPattern,
    instance: str,
    process: str,
    *,
    names: tuple[str, ...] = (),
    create: str = "",
    is_stand_in: bool = False,
) -> ComponentFacts:
    """Return the facts of a component just made from a pattern."""
    contexts = pattern.contexts if is_stand_in else pattern.contexts or (ContextPattern(),)
    sets = {name: dict(values) for name, values in pattern.sets.items()}
    if not is_stand_in:
        sets = {"default": {}, **sets}
    return ComponentFacts(
        instance,
        pattern.type,
        process,
        pattern.ports,
        sets,
        pattern.active_set or "default",
        tuple(ExecutionContextProfile(c.id, c.kind, c.rate, instance) for c in contexts),
        names,
        create,
        is_stand_in=is_stand_in,
    )


def _check_same(known: ConnectorProfile, wire: ConnectorProfile) -> None:
    if set(known.ports) != set(wire.ports):
        ends = " and ".join(map(str, known.ports))
        raise Refused(f"connector id {wire.connector_id} is in use between {ends}")
    changed = differing(wire.properties, known.properties)
    if changed:
        raise Refused(f"connection {wire.connector_id} exists with another {', '.join(changed)}")


def _nothing() -> None:
    """Do nothing."""


def _no_fault(_action: Action) -> Result | None:
    return None
