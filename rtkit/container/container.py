"""Holds the components of one process and does what the core asks of them.

The same container works inside the manager and inside a slave: messages in, messages out. All of
it runs on one thread; pacers and connection workers only put events into its inbox. Component
code runs here at initialise and finalise, and on the pacers' threads otherwise.
"""

from __future__ import annotations

import os
import queue
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from rtkit import fault
from rtkit.component.base import Component
from rtkit.component.configuration.config import nobody
from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.contexts.participant import DrivenComponent
from rtkit.component.current import current
from rtkit.container.composites import Composites, check_settings, is_composite
from rtkit.container.connectors import Connectors
from rtkit.container.execution_contexts import ExecutionContexts, StateMachines, release
from rtkit.container.facts import DatedFacts
from rtkit.container.neighbours import Neighbours
from rtkit.container.operations import LATER, Operations, in_time
from rtkit.container.pacer import Pacer, StartDriver, Work
from rtkit.container.port_samples import sampling
from rtkit.container.port_wiring import PortWiring
from rtkit.container.stdin import LazyTerminals
from rtkit.container.user_requests import UserRequests
from rtkit.deployment.message import NEW, Message
from rtkit.deployment.terminal import TERMINAL
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.guard import guarded, kind_and_text
from rtkit.link.threads import start_thread
from rtkit.logs.late import late
from rtkit.property.exchange import NOT_BEGUN
from rtkit.rtc.context_settings import SETTINGS
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ReturnCode
from rtkit.rtc.serde import encode

if TYPE_CHECKING:
    from rtkit.component.composite import Composite
    from rtkit.container.component_factory import ComponentFactory
    from rtkit.container.heartbeats import Heartbeats, HeartbeatSlot
    from rtkit.container.slave_checkpoint import CheckpointWriter

_log = late(__name__)
_CLOSE = object()
_DEACTIVATE_S = 2.0
_WIND_UP_S = 1.0
"""How long all callbacks have to come back when the process ends: half of what it has [s]."""


class ComponentContainer:
    """Holds the components of one process, on a thread of its own or the process's main thread.

    Args:
        send: Takes what is reported and answered.
        wiring: The connector ends of the process.
        maker: Makes components; None where they are only handed in.

    Attributes:
        start_driver: Starts the work of each context, by default on a thread of its own.
        terminals: What components read from, if they do.
        composites: Those that it holds take members in, and let them go.
    """

    def __init__(
        self,
        send: Callable[[Message], object],
        wiring: PortWiring,
        component_factory: ComponentFactory | None,
    ) -> None:
        self.start_driver: StartDriver = start_thread
        self._send = send
        self._component_factory = component_factory
        self._heartbeats: Heartbeats | None = None
        self.announce: Callable[[str, str], object] = nobody
        self._checkpoint_writer: CheckpointWriter | None = None
        self._slots: dict[tuple[str, str], HeartbeatSlot] = {}
        self.terminals = LazyTerminals(self, send)
        self._wiring = wiring
        self._inbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._components: dict[str, Component] = {}
        self._pacers: dict[tuple[str, str], Pacer] = {}
        self._memory: dict[str, Mapping[str, Any]] = {}
        self._facts = DatedFacts()
        self._asked = UserRequests()
        self._takeovers: dict[str, list[Message]] = {}
        self._deletions: dict[str, list[Message]] = {}
        self._stale: set[DrivenComponent] = set()
        self._connectors = Connectors(self, wiring)
        self.composites = Composites(self)
        self._operations: Mapping[str, Callable[[Message], Any]] = {
            "delete": self._delete,
            "set": self._set,
            "activate_set": self._activate_set,
            "remove_set": self._remove_set,
            "set_back": self._set_back,
            "remember": self._remember,
            "metrics": self._send_metrics,
            **(self._making(component_factory) if component_factory is not None else {}),
            **ExecutionContexts(self).operations,
            **self._connectors.operations,
            **StateMachines(self).operations,
            **Neighbours(self).operations,
            **sampling(self._components, send),
            TERMINAL: self.terminals.serve,
        }

    def show_heartbeats(self, heartbeats: Heartbeats) -> None:
        """Show in which callback each context of this process is, before there are any."""
        self._heartbeats, own_slot = heartbeats, heartbeats.slot()
        self.announce = own_slot.watch if own_slot is not None else nobody

    def write_down(self, checkpoint_writer: CheckpointWriter) -> None:
        """Write a checkpoint of what is held, for when nobody here can report it."""
        self._checkpoint_writer = checkpoint_writer

    def put(self, message: Message) -> None:
        """Hand a message of the core in, from any thread."""
        self._inbox.put(message)

    def post(self, work: Callable[[], object]) -> None:
        """Have something done on the thread of `run`, from any thread."""
        self._inbox.put(work)

    def close(self) -> None:
        """End `run` after finalising every component, from any thread."""
        self._inbox.put(_CLOSE)

    def report_all(self, send: Callable[[Message], object]) -> None:
        """Have `send` called with everything that is held, before any later report."""

        def introduce() -> None:
            send(self._holding())
            if self._component_factory is not None and self._component_factory.modules:
                self._send({"loaded": self._component_factory.modules})

        self._inbox.put(introduce)

    def run(self) -> None:
        """Do what comes in until `close`."""
        while True:
            item = self._inbox.get()
            if item is _CLOSE:
                break
            # User code may raise SystemExit, too, which must not end the process.
            error = guarded(item if callable(item) else partial(self._serve, item)).error
            if error is not None:
                _log().error("holder failed at %r", item, exc_info=error)
        self._wind_up()
        self._wiring.close()

    def _wind_up(self) -> None:
        """Finalise every component but those of which a callback does not come back."""
        for pacer in self._pacers.values():
            pacer.stop()
        self.terminals.leave(self._components)
        until = time.monotonic() + _WIND_UP_S
        hung = {
            instance
            for (instance, _), pacer in self._pacers.items()
            if not pacer.close(max(0.0, until - time.monotonic()))
        }
        for instance in reversed(list(self._components)):
            if instance in hung:
                _log().error("%s is not finalised: a callback of it does not come back", instance)
            else:
                self._end(instance)

    def _serve(self, message: Message) -> None:
        operation = self._operations.get(message.get("op", ""))
        if operation is None:
            self.refuse(message, Malformed(f"unknown operation: {message.get('op')!r}"))
            return
        if not in_time(message):
            self.refuse(message, Unreachable(NOT_BEGUN))
            return
        fault.point("holder.asked")
        try:
            value = operation(message)
            fault.point("holder.did")
        except RtkitError as error:
            if message["op"] in ("load", "create") and error.__cause__ is not None:
                _log().error("%s failed: %s", message["op"], error, exc_info=error.__cause__)
            self.refuse(message, error)
        except BaseException as error:
            self.refuse(message, RtkitError(kind_and_text(error)))
            raise
        else:
            if value is not LATER:
                self.answer(message, value)

    def answer(self, message: Message, value: Any) -> None:
        """Answer a message after its operation was done."""
        if message.get("instance") in self._components:
            self._asked.note(message)
        if "call" in message:
            self._send({"reply": message["call"], "value": "" if value is None else value})
            fault.point("holder.answered")

    def refuse(self, message: Message, error: RtkitError, code: ReturnCode | None = None) -> None:
        """Answer a message with an error."""
        if "call" in message:
            code = code or ReturnCode.ERROR
            reply = {"reply": message["call"], "code": code.value}
            self._send({**reply, "kind": error.kind, "why": str(error)})

    # modules

    def _making(self, component_factory: ComponentFactory) -> Operations:
        return {
            "configure": component_factory.configure,
            "load": partial(self._load, component_factory),
            "unload": component_factory.unload,
            "fingerprint": component_factory.fingerprint,
            "create": partial(self._create, component_factory),
        }

    def _load(self, component_factory: ComponentFactory, message: Message) -> dict[str, Any]:
        path = message["path"]
        with self._watched(os.path.basename(path), "import"):
            return component_factory.load(path, message.get("init", ""))

    # components

    def _create(self, component_factory: ComponentFactory, message: Message) -> object:
        create = parse_create(message["create"])
        instance = create.instance_name
        if instance in self._components:
            raise Refused(f"{instance} exists already")
        with self._watched(instance, "creation"):
            component = component_factory.make(create, message)
        if found := component_factory.found():
            self._send({"loaded": found})
        if not isinstance(component, Component):
            return component
        self.hold(component, message.get("kept", {}))
        odd = [text for each in found for text in each["remarks"]]
        odd += component_factory.odd_options(component, create)
        for text in odd:
            component.report(text)
        changed = component_factory.changed(component)
        answer = {"changed": changed, "remarks": odd} if changed or odd else instance
        if is_composite(component):
            self._compose(message, component, answer)
            return LATER
        self.report(component)
        return answer

    def hold(self, component: Component, kept: Mapping[str, Any] | None = None) -> None:
        """Initialise a component and drive its contexts; only on the thread of `run`.

        Raises:
            Refused: on_initialize failed.
        """
        with self._watched(component.instance, "on_initialize"):
            component.initialize()
        self.drive(component, kept)

    def drive(self, component: Component, kept: Mapping[str, Any] | None = None) -> None:
        """Drive the contexts of an initialised component; only on the thread of `run`.

        `kept` are facts about it that only the manager, or whoever made it, can tell.
        """
        self._components[component.instance] = component
        self._memory[component.instance] = kept or {}
        for context in component.contexts.values():
            self._drive(component, context)

    def _compose(self, message: Message, composite: Composite, answer: object) -> None:
        def done(error: RtkitError | None) -> None:
            if error is None:
                self.answer(message, answer)
            else:
                self._end(composite.instance)
                self.refuse(message, error)

        self.composites.arrange(composite, done)

    def _drive(self, component: Component, context: ExecutionContext) -> None:
        key = (component.instance, context.id)
        slot = self._heartbeats.slot() if self._heartbeats is not None else None
        grant = slot.grant if slot is not None else None
        name = f"{component.instance}/{context.id}"
        self._pacers[key] = Pacer(context, name, grant, self.start_driver)
        context.changed = self._changed
        if slot is not None:
            self._slots[key] = slot
            context.watch = slot.watch
        if not context.properties.keys().isdisjoint(SETTINGS):
            context.set_properties(context.properties)  # what the system refuses is told at once

    @contextmanager
    def _watched(self, name: str, callback: str) -> Iterator[None]:
        """Name the component whose code runs on this thread, in a heartbeat and in logs."""
        before = current.set("" if callback == "import" else name)
        self.announce(name, callback)
        try:
            yield
        finally:
            self.announce("", "")
            current.reset(before)

    def _changed(self, component: DrivenComponent) -> None:
        """Have a component's facts reported soon, once for however many changes until then."""
        if component not in self._stale:
            self._stale.add(component)
            self.post(lambda: self.report(component))

    def report(self, component: DrivenComponent) -> None:
        """Report the facts of a component, and answer those who waited for its settings."""
        self._stale.discard(component)
        held = self._components.get(component.instance)
        held = held if held is component else None
        if held is not None:
            facts = encode(self._facts.of(held))
            self._keep(held.instance, facts)
            self._send({"facts": facts})
        if not component.configuration.is_pending:
            self._taken_over(held, self._takeovers.pop(component.instance, []))

    def _keep(self, instance: str, facts: Mapping[str, Any]) -> None:
        if self._checkpoint_writer is not None:
            self._checkpoint_writer.keep(instance, {**facts, **self._memory.get(instance, {})})

    def _taken_over(self, component: Component | None, messages: list[Message]) -> None:
        """Answer requests that waited for settings; a composite has to become what they say."""

        def done(error: RtkitError | None) -> None:
            for message in messages:
                if error is None:
                    self.answer(message, "")
                else:
                    self.refuse(message, error)

        if messages and is_composite(component) and not component.is_arranged:
            self.composites.arrange(component, done)
        else:
            done(None)

    def component(self, instance: str) -> Component:
        """Return a component of this process.

        Raises:
            NotFound: There is none of that name.
        """
        component = self._components.get(instance)
        if component is None:
            raise NotFound(f"no component named {instance}")
        return component

    def _delete(self, message: Message) -> object:
        component = self.component(message["instance"])
        asked = self._deletions.setdefault(component.instance, [])
        asked.append(message)
        if len(asked) > 1:
            return LATER
        self.composites.part(component, lambda: self._release(component))
        return LATER

    def _release(self, component: Component) -> None:
        waiting = 0

        def rested() -> None:
            nonlocal waiting
            waiting -= 1
            if not waiting:
                self._deleted(component.instance)

        waiting = release(component, self._is_resting, lambda: self.post(rested))
        if not waiting:
            self._deleted(component.instance)

    def _is_resting(self, context: ExecutionContext) -> bool:
        return self._pacers[context.owner, context.id].is_resting

    def _deleted(self, instance: str) -> None:
        try:
            self._end(instance)
        finally:
            fault.point("holder.finalised")
            self._send({"gone": instance})
            for message in self._deletions.pop(instance):
                self.answer(message, "")

    def _end(self, instance: str) -> None:
        component = self._components.pop(instance)
        self._memory.pop(instance, None)
        self._facts.forget(instance)
        self._asked.forget(instance)
        self._connectors.part(component)
        for key in [key for key in self._pacers if key[0] == instance]:
            self._pacers.pop(key).close(_DEACTIVATE_S)
            slot = self._slots.pop(key, None)
            if slot is not None and self._heartbeats is not None:
                self._heartbeats.release(slot)
        with self._watched(instance, "on_finalize"):
            component.finalize()
        self.terminals.forget(instance)
        if self._checkpoint_writer is not None:
            self._checkpoint_writer.strike(instance)
        for message in self._takeovers.pop(instance, ()):
            self.refuse(message, Refused(f"{instance} was deleted"))

    def _remember(self, message: Message) -> None:
        instance = message["instance"]
        if instance in self._components:
            self._memory[instance] = message["kept"]
            self._keep(instance, encode(self._facts.of(self._components[instance])))

    def _send_metrics(self, _message: Message) -> object:
        from rtkit.container.metrics import metrics_of

        def worked(context: ExecutionContext) -> Work:
            return work.get((context.owner, context.id), Work())

        work = {key: pacer.work() for key, pacer in self._pacers.items()}
        self._send({"metrics": metrics_of(self._components.values(), worked)})
        return LATER

    def _holding(self) -> Message:
        components = [
            {**encode(self._facts.of(component)), **self._memory.get(instance, {})}
            for instance, component in self._components.items()
        ]
        factory = self._component_factory
        return {
            "components": components,
            "wires": [encode(connector) for connector in self._connectors.held],
            "asked": self._asked.by_component(self._components),
            "configured": factory.configured if factory is not None else None,
        }

    # configuration and state

    def _set(self, message: Message) -> object:
        component = self.component(message["instance"])
        configuration = component.configuration
        adds = message.get("adds")
        if adds == NEW or (adds and message["set_id"] not in configuration.sets):
            configuration.add_set(message["set_id"], message["values"])
            self.report(component)
            return ""
        if message["set_id"] == configuration.active_set:
            check_settings(component, message["set_id"], message["values"])
        configuration.set(message["set_id"], message["values"])
        if message["set_id"] != configuration.active_set:
            self.report(component)
            return ""
        configuration.activate(message["set_id"])
        return self._take_over(component, message)

    def _remove_set(self, message: Message) -> object:
        component = self.component(message["instance"])
        component.configuration.remove_set(message["set_id"])
        self.report(component)
        return ""

    def _activate_set(self, message: Message) -> object:
        component = self.component(message["instance"])
        check_settings(component, message["set_id"], {})
        component.configuration.activate(message["set_id"])
        return self._take_over(component, message)

    def _set_back(self, message: Message) -> None:
        """Undo a change whose requester has given up; later changes stay."""
        component, set_id = self.component(message["instance"]), message["set_id"]
        configuration = component.configuration
        if message.get("is_added") and set_id in configuration.sets:
            self._remove_set(message)
            return
        present, meant = configuration.sets.get(set_id, {}), message["values"]
        before = message["before"].items()
        configuration.set(set_id, {k: v for k, v in before if present.get(k) == meant.get(k)})
        configuration.activate(message["active_set"])
        self._take_over(component, message)

    def _take_over(self, component: Component, message: Message) -> object:
        """Answer when the component sees its new configuration."""
        context = next((c for c in component.participations if c.is_running), None)
        self._takeovers.setdefault(component.instance, []).append(message)
        if context is None:
            component.configuration.update()
            self.report(component)
        else:
            try:
                context.wake()
            except Refused:
                self._takeovers[component.instance].remove(message)
                raise
        return LATER
