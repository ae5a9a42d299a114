"""Fake containers: hold facts in place of components, and do what the core of a manager asks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import fake_composites as composites

from rtkit.component.configuration.constraint_check import parameter_names
from rtkit.component.contexts import lifecycle
from rtkit.component.contexts.period import check_rate
from rtkit.container.user_requests import UserRequests
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.fast_dataclass import replace
from rtkit.rtc.create import CreateString, parse_create
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode, Transition
from rtkit.rtc.pattern import ComponentPattern, ContextPattern
from rtkit.rtc.profiles import ExecutionContextProfile, ModuleProfile
from rtkit.rtc.serde import decode, encode

Message = Mapping[str, Any]
_ENDPOINTS = ("sink", "serve", "offer")
_ENDS = (*_ENDPOINTS, "link", "source", "fetch", "consult", "keep")


class PreconditionNotMet(Refused):
    """A state does not allow what was asked."""

    code = ReturnCode.PRECONDITION_NOT_MET.value


class FakeContainers:
    """The containers of all processes of one manager.

    Attributes:
        types: What can be created, by implementation id.
        modules: What a module offers once it is loaded, by path.
        components: What they hold; the process of each is known by its pid here.
        ends: Connector ends, by pid and connector.
        memory: What the manager had each component's container remember.
        asked: What users asked of components.
    """

    def __init__(
        self,
        types: Iterable[ComponentPattern],
        modules: Mapping[str, Iterable[ComponentPattern]] | None,
    ) -> None:
        self.types = {pattern.type.type_name: pattern for pattern in types}
        self.modules = {path: tuple(made) for path, made in (modules or {}).items()}
        self.components: dict[str, ComponentFacts] = {}
        self.ends: dict[tuple[int, str], Any] = {}
        self.memory: dict[str, Any] = {}
        self.asked = UserRequests()

    def drop(self, instance: str) -> None:
        """Forget a component: it was finalised, or its process has ended."""
        self.components.pop(instance, None)
        self.components |= composites.parted(self.components, instance)
        self.asked.forget(instance)

    def end_process(self, pid: int) -> None:
        """Forget all that a process held."""
        for instance in self.held_by(pid):
            self.drop(instance)
        self.ends = {end: wire for end, wire in self.ends.items() if end[0] != pid}

    def held_by(self, pid: int) -> list[str]:
        """Return the components of a process."""
        return [each.instance for each in self.components.values() if each.process == str(pid)]

    def told(self, instance: str) -> Any:
        """Return the report of a container about a component."""
        return encode(replace(self.components[instance], names=(), create="", process=""))

    def do(self, pid: int, message: Message) -> Any:
        """Do what a container is asked; return its answer.

        Raises:
            RtkitError: It refuses.
        """
        op = message["op"]
        if op in _ENDS:
            self.ends[pid, message["connector"]["connector_id"]] = message["connector"]
            return "unix/x" if op in _ENDPOINTS else ""
        operation: Callable[[int, Message], Any] | None = getattr(self, f"_{op}", None)
        if operation is None:
            return ""
        answer = operation(pid, message)
        if message.get("instance") in self.components:
            self.asked.note(message)
        return "" if answer is None else answer

    def _unlink(self, pid: int, message: Message) -> None:
        self.ends.pop((pid, message["connector_id"]), None)

    def _remember(self, _pid: int, message: Message) -> None:
        self.memory[message["instance"]] = message["kept"]

    def _neighbours(self, _pid: int, _message: Message) -> list[str]:
        return []

    def _load(self, _pid: int, message: Message) -> Any:
        path = message["path"]
        if path not in self.modules:
            raise NotFound(f"no module at {path}")
        self.types |= {pattern.type.type_name: pattern for pattern in self.modules[path]}
        types = tuple(pattern.type for pattern in self.modules[path])
        module = ModuleProfile(path, message["init"] or "init", types)
        return {"module": encode(module), "fingerprint": 1}

    def _create(self, pid: int, message: Message) -> str:
        create = parse_create(message["create"])
        instance = create.instance_name
        plain = message["pattern"]
        pattern = decode(ComponentPattern, plain) if plain else self._type(create)
        made = component_from(pattern, instance, pid, is_stand_in=plain is not None)
        self._arrange(composites.made(made, create))
        self.memory[instance] = message["kept"]
        return instance

    def _type(self, create: CreateString) -> ComponentPattern:
        name = create.implementation_id
        pattern = self.types.get(name) or composites.pattern_of(name)
        if pattern is None:
            raise NotFound(f"component type {name} is not known")
        for field in ("vendor", "category", "version"):
            wanted = getattr(create, field)
            if wanted and wanted != getattr(pattern.type, field):
                raise NotFound(f"component type {name} of {field} {wanted} is not known")
        return pattern

    def _delete(self, pid: int, message: Message) -> None:
        for end, wire in list(self.ends.items()):
            held = [port["instance"] for port in wire["ports"]]
            if end[0] == pid and message["instance"] in held:
                del self.ends[end]
        self.drop(message["instance"])

    def _of(self, instance: str) -> ComponentFacts:
        known = self.components.get(instance)
        if known is None:
            raise NotFound(f"no component named {instance}")
        return known

    def _set(self, _pid: int, message: Message) -> None:
        known, set_id = self._of(message["instance"]), message["set_id"]
        present = known.sets.get(set_id)
        adds = message.get("adds")
        if adds == "new" and present is not None:
            raise Refused(f"configuration set {set_id} exists already")
        if present is None and adds:
            present = dict.fromkeys(parameter_names(known.sets) & message["values"].keys(), "")
        if present is None:
            raise NotFound(f"No such configuration set: {set_id}")
        for name in message["values"]:
            if name not in present:
                raise NotFound(f"No such configuration parameter: {name}")
        changed = {**present, **message["values"]}
        self._arrange(replace(known, sets={**known.sets, set_id: changed}))

    def _remove_set(self, _pid: int, message: Message) -> None:
        known, set_id = self._of(message["instance"]), message["set_id"]
        if set_id == known.active_set:
            raise Refused(f"configuration set {set_id} is the active one")
        left = {name: values for name, values in known.sets.items() if name != set_id}
        self._arrange(replace(known, sets=left))

    def _activate_set(self, _pid: int, message: Message) -> None:
        known, set_id = self._of(message["instance"]), message["set_id"]
        if not set_id or set_id.startswith("_"):
            raise Refused(f"configuration set {set_id or repr('')} cannot be activated")
        if set_id not in known.sets:
            raise NotFound(f"No such configuration set: {set_id}")
        self._arrange(replace(known, active_set=set_id))

    def _arrange(self, facts: ComponentFacts) -> None:
        """Take the facts of a component in, and what they change if it is a composite."""
        changed = composites.arranged(self.components, facts)
        self.components |= {facts.instance: facts, **changed}

    def put(self, instance: str, **changes: object) -> None:
        """Change facts of a component."""
        self.components[instance] = replace(self.components[instance], **changes)  # type: ignore[arg-type]

    def set_state(self, instance: str, state: LifeCycleState, cause: str = "") -> None:
        """Put a component into a state, as if something had happened to it."""
        contexts = self.components[instance].contexts
        contexts = tuple(replace(context, state=state) for context in contexts)
        self.put(instance, contexts=contexts, cause=cause)

    def _context(self, message: Message) -> tuple[ComponentFacts, ExecutionContextProfile]:
        known = self._of(message["instance"])
        for context in known.contexts:
            if context.id == message["context"]:
                return known, context
        raise NotFound(f"no execution context {message['context']} on {known.instance}")

    def _change(self, facts: ComponentFacts, old: object, new: ExecutionContextProfile) -> None:
        contexts = tuple(new if each is old else each for each in facts.contexts)
        self.put(facts.instance, contexts=contexts, cause="")

    def _change_state(self, _pid: int, message: Message) -> None:
        known, context = self._context(message)
        transition = Transition(message["transition"])
        event = lifecycle.LifeCycleEvent(transition.value)
        target = lifecycle.TARGET[transition]
        if target is not context.state:
            target = lifecycle.next_state(context.state, event)
        if target is None:
            why = f"{lifecycle.refusal(context.state)}: {known.instance}"
            raise PreconditionNotMet(why)
        self._change(known, context, replace(context, state=target))

    def _set_rate(self, _pid: int, message: Message) -> None:
        known, context = self._context(message)
        if context.kind is not ExecutionKind.PERIODIC:
            raise Refused(f"execution context {context.id} of {known.instance} has no rate")
        self._change(known, context, replace(context, rate=check_rate(message["rate"])))

    def _tick(self, _pid: int, message: Message) -> None:
        _, context = self._context(message)
        if context.kind is ExecutionKind.PERIODIC:
            raise PreconditionNotMet(f"execution context {context.id} ticks by itself")

    def _set_structure(self, _pid: int, message: Message) -> None:
        states = message["states"]
        self.put(self._machine(message), fsm_states=states, fsm_state=next(iter(states), ""))

    def _set_events(self, _pid: int, message: Message) -> None:
        self.put(self._machine(message), fsm_events=message["events"])

    def _machine(self, message: Message) -> str:
        known = self._of(message["instance"])
        if not known.fsm_states:
            raise Refused(f"{known.instance} has no state machine")
        return known.instance

    def _attach(self, pid: int, message: Message) -> None:
        self._share(message, is_attached=True)

    def _detach(self, pid: int, message: Message) -> None:
        self._share(message, is_attached=False)

    def _share(self, message: Message, *, is_attached: bool) -> None:
        owner, context = self._context(message)
        driven = self._of(message["participant"])
        if (driven.instance in context.participants) is is_attached:
            raise Refused(f"{driven.instance}: no such change of execution context {context.id}")
        members = [name for name in context.participants if name != driven.instance]
        members += [driven.instance] * is_attached
        seen = replace(context, participants=tuple(members))
        handle = f"{owner.instance}/{context.id}"
        others = tuple(each for each in driven.contexts if each.id != handle)
        if is_attached:
            others += (replace(seen, id=handle, state=LifeCycleState.INACTIVE),)
        self.put(driven.instance, contexts=others)
        contexts = tuple(seen if each is context else each for each in owner.contexts)
        self.put(owner.instance, contexts=contexts)


def component_from(
    pattern: ComponentPattern,
    instance: str,
    pid: int,
    *,
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
        str(pid),
        pattern.ports,
        sets,
        pattern.active_set or "default",
        tuple(ExecutionContextProfile(c.id, c.kind, c.rate, instance) for c in contexts),
        is_stand_in=is_stand_in,
    )


def code_of(error: RtkitError) -> str:
    """Return the code with which a container answers an error."""
    return getattr(error, "code", ReturnCode.ERROR.value)
