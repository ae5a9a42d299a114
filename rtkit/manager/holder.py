"""Holds the components of one process and does what the core asks of them.

The same holder works inside the manager and inside a slave: messages in, messages out. All of
it runs on one thread; pacers and connection workers only put events into its inbox. Component
code runs here at initialise and finalise, and on the pacers' threads otherwise.
"""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from rtkit.component.base import Component
from rtkit.component.context import ExecutionContext
from rtkit.component.port import InPort, OutPort
from rtkit.component.standin import stand_in
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.link.streams import Fetcher, Outlet
from rtkit.manager.connect import Wires
from rtkit.manager.events import Message
from rtkit.manager.facts_out import facts_of
from rtkit.manager.loader import Loader
from rtkit.manager.pacer import Pacer
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import ReturnCode, Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.plain import decode, encode
from rtkit.rtc.profiles import ConnectorProfile

_log = logging.getLogger(__name__)
_CLOSE = object()
_LATER = object()
_DEACTIVATE_S = 2.0
E = TypeVar("E", Outlet, Fetcher)


class Holder:
    """The components of one process, on a thread of its own or the process's main thread."""

    def __init__(self, send: Callable[[Message], object], wires: Wires, loader: Loader) -> None:
        self._send = send
        self._wires = wires
        self._loader = loader
        self._inbox: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._components: dict[str, Component] = {}
        self._pacers: dict[tuple[str, str], Pacer] = {}
        self._profiles: dict[str, ConnectorProfile] = {}
        self._takeovers: dict[str, list[Message]] = {}
        self._deletions: dict[str, list[Message]] = {}
        self._operations: Mapping[str, Callable[[Message], Any]] = {
            "load": self._load,
            "unload": self._unload,
            "create": self._create,
            "delete": self._delete,
            "link": self._link,
            "sink": self._sink,
            "source": self._source,
            "serve": self._serve_values,
            "fetch": self._fetch,
            "unlink": self._unlink,
            "set": self._set,
            "activate_set": self._activate_set,
            "change_state": self._change_state,
        }

    def put(self, message: Message) -> None:
        """Hand a message of the core in, from any thread."""
        self._inbox.put(message)

    def close(self) -> None:
        """End `run` after finalising every component, from any thread."""
        self._inbox.put(_CLOSE)

    def run(self) -> None:
        """Do what comes in until `close`."""
        while True:
            item = self._inbox.get()
            if item is _CLOSE:
                break
            try:
                if callable(item):
                    item()
                else:
                    self._serve(item)
            except Exception:
                _log.exception("holder failed at %r", item)
        for instance in reversed(list(self._components)):
            self._end(instance)
        self._wires.close()

    def _serve(self, message: Message) -> None:
        operation = self._operations.get(message.get("op", ""))
        if operation is None:
            self._refuse(message, Malformed(f"unknown operation: {message.get('op')!r}"))
            return
        try:
            value = operation(message)
        except RtkitError as error:
            self._refuse(message, error)
        except Exception as error:
            self._refuse(message, RtkitError(f"{type(error).__name__}: {error}"))
            raise
        else:
            if value is not _LATER:
                self._answer(message, value)

    def _answer(self, message: Message, value: Any) -> None:
        if "call" in message:
            self._send({"reply": message["call"], "value": "" if value is None else value})

    def _refuse(self, message: Message, error: RtkitError, code: ReturnCode | None = None) -> None:
        if "call" in message:
            code = code or ReturnCode.ERROR
            reply = {"reply": message["call"], "code": code.value}
            self._send({**reply, "kind": error.kind, "why": str(error)})

    # modules

    def _load(self, message: Message) -> dict[str, Any]:
        module = self._loader.load(message["path"], message.get("init", ""))
        types = [encode(each) for each in module.types]
        return {"path": module.path, "init": module.init, "types": types}

    def _unload(self, message: Message) -> None:
        self._loader.unload(message["path"])

    # components

    def _create(self, message: Message) -> str:
        create = parse_create(message["create"])
        instance = create.instance_name
        if instance in self._components:
            raise Refused(f"{instance} exists already")
        if message.get("pattern") is not None:
            pattern = decode(ComponentPattern, message["pattern"])
            component: Component = stand_in(pattern, instance, create.options)
        else:
            for path, init in message.get("modules", ()):
                self._loader.load(path, init)
            component = self._loader.make(create)
        component.initialize()
        self._components[instance] = component
        for context in component.contexts.values():
            self._drive(component, context)
        self._tell(component)
        return instance

    def _drive(self, component: Component, context: ExecutionContext) -> None:
        key = (component.instance, context.id)
        self._pacers[key] = Pacer(context, f"{component.instance}/{context.id}")
        context.changed = self._changed

    def _changed(self, component: Component) -> None:
        self._inbox.put(lambda: self._tell(component))

    def _tell(self, component: Component) -> None:
        if self._components.get(component.instance) is component:
            self._send({"facts": encode(facts_of(component))})
        if not component.configuration.is_pending:
            for message in self._takeovers.pop(component.instance, ()):
                self._answer(message, "")

    def _component(self, message: Message) -> Component:
        component = self._components.get(message["instance"])
        if component is None:
            raise NotFound(f"no component named {message['instance']}")
        return component

    def _delete(self, message: Message) -> object:
        component = self._component(message)
        asked = self._deletions.setdefault(component.instance, [])
        asked.append(message)
        if len(asked) > 1:
            return _LATER
        contexts = [c for c in component.contexts.values() if c.is_running]
        waiting = len(contexts)

        def rested() -> None:
            nonlocal waiting
            waiting -= 1
            if not waiting:
                self._deleted(component.instance)

        for context in contexts:
            context.request(
                component, Transition.DEACTIVATE, lambda _code, _why: self._inbox.put(rested)
            )
        if not contexts:
            self._deleted(component.instance)
        return _LATER

    def _deleted(self, instance: str) -> None:
        try:
            self._end(instance)
        finally:
            self._send({"gone": instance})
            for message in self._deletions.pop(instance):
                self._answer(message, "")

    def _end(self, instance: str) -> None:
        component = self._components.pop(instance)
        for port in component.ports.values():
            for connector_id in list(port.connectors):
                self._cut(connector_id)
        for key in [key for key in self._pacers if key[0] == instance]:
            self._pacers.pop(key).close(_DEACTIVATE_S)
        component.finalize()
        for message in self._takeovers.pop(instance, ()):
            self._refuse(message, Refused(f"{instance} was deleted"))

    # connectors

    def _link(self, message: Message) -> None:
        wire = decode(ConnectorProfile, message["connector"])
        self._wires.join(wire, self._out_port(wire), self._in_port(wire))
        self._profiles[wire.connector_id] = wire

    def _sink(self, message: Message) -> str:
        wire = decode(ConnectorProfile, message["connector"])
        endpoint = self._wires.receive(wire, self._in_port(wire))
        self._profiles[wire.connector_id] = wire
        return endpoint

    def _serve_values(self, message: Message) -> str:
        wire = decode(ConnectorProfile, message["connector"])
        endpoint = self._wires.serve(wire, self._out_port(wire))
        self._profiles[wire.connector_id] = wire
        return endpoint

    def _source(self, message: Message) -> object:
        wire = decode(ConnectorProfile, message["connector"])
        self._out_port(wire)

        def use(outlet: Outlet) -> None:
            self._wires.send(wire, self._out_port(wire), outlet)

        self._reach(message, wire, self._wires.find_receiver, use)
        return _LATER

    def _fetch(self, message: Message) -> object:
        wire = decode(ConnectorProfile, message["connector"])
        self._in_port(wire)

        def use(fetcher: Fetcher) -> None:
            self._wires.fetch(wire, self._in_port(wire), fetcher)

        self._reach(message, wire, self._wires.find_source, use)
        return _LATER

    def _reach(
        self,
        message: Message,
        wire: ConnectorProfile,
        find: Callable[[ConnectorProfile, str], E],
        use: Callable[[E], None],
    ) -> None:
        """Find the other end on a thread of its own, then use it here if it is still wanted."""
        endpoint = message["endpoint"]
        if wire.connector_id in self._profiles:
            raise Refused(f"connection {wire.connector_id} is open, or being opened, here")
        self._profiles[wire.connector_id] = wire

        def run() -> None:
            try:
                end = find(wire, endpoint)
            except Exception as failure:
                error = failure  # the name of an except clause is gone when this is called
                self._inbox.put(lambda: self._not_found(message, wire, endpoint, error))
            else:
                self._inbox.put(lambda: self._found(message, wire, end, use))

        threading.Thread(target=run, name=f"open {endpoint}", daemon=True).start()

    def _found(
        self, message: Message, wire: ConnectorProfile, end: E, use: Callable[[E], None]
    ) -> None:
        try:
            if self._profiles.get(wire.connector_id) is not wire:
                raise Refused(f"connection {wire.connector_id} was removed while it was made")
            use(end)
        except RtkitError as error:
            end.close()
            self._forget(wire)
            self._refuse(message, error)
        else:
            self._answer(message, "")

    def _not_found(
        self, message: Message, wire: ConnectorProfile, endpoint: str, error: Exception
    ) -> None:
        self._forget(wire)
        if not isinstance(error, RtkitError):
            _log.error("cannot reach %s", endpoint, exc_info=error)
            error = Unreachable(f"cannot reach {endpoint}: {error}")
        self._refuse(message, error)

    def _forget(self, wire: ConnectorProfile) -> None:
        if self._profiles.get(wire.connector_id) is wire:
            del self._profiles[wire.connector_id]

    def _unlink(self, message: Message) -> None:
        self._cut(message["connector_id"])

    def _cut(self, connector_id: str) -> None:
        wire = self._profiles.pop(connector_id, None)
        for end in wire.ports if wire is not None else ():
            component = self._components.get(end.instance)
            port = component.ports.get(end.port) if component is not None else None
            if isinstance(port, OutPort):
                port.detach(connector_id)
            elif isinstance(port, InPort):
                port.close(connector_id)
        self._wires.cut(connector_id)

    def _out_port(self, wire: ConnectorProfile) -> OutPort[Any]:
        port = self._port(wire, 0)
        if not isinstance(port, OutPort):
            raise Refused("Wrong port type.")
        return port

    def _in_port(self, wire: ConnectorProfile) -> InPort[Any]:
        port = self._port(wire, 1)
        if not isinstance(port, InPort):
            raise Refused("Wrong port type.")
        return port

    def _port(self, wire: ConnectorProfile, index: int) -> object:
        end = wire.ports[index]
        port = self._component({"instance": end.instance}).ports.get(end.port)
        if port is None:
            raise NotFound(f"Port not found: {end}")
        return port

    # configuration and state

    def _set(self, message: Message) -> object:
        component = self._component(message)
        configuration = component.configuration
        configuration.set(message["set_id"], message["values"])
        if message["set_id"] != configuration.active_set:
            self._tell(component)
            return ""
        configuration.activate(message["set_id"])
        return self._take_over(component, message)

    def _activate_set(self, message: Message) -> object:
        component = self._component(message)
        component.configuration.activate(message["set_id"])
        return self._take_over(component, message)

    def _take_over(self, component: Component, message: Message) -> object:
        """Answer when the component sees its new configuration."""
        context = next((c for c in component.participations if c.is_running), None)
        if context is None:
            component.configuration.update()
            self._tell(component)
            return ""
        self._takeovers.setdefault(component.instance, []).append(message)
        context.wake()
        return _LATER

    def _change_state(self, message: Message) -> object:
        component = self._component(message)
        context = component.contexts.get(message["context"])
        if context is None:
            raise NotFound(f"no execution context {message['context']} on {component.instance}")

        def done(code: ReturnCode, why: str) -> None:
            self._inbox.put(lambda: self._changed_state(message, component, code, why))

        context.request(component, Transition(message["transition"]), done)
        if message.get("wait", True):
            return _LATER
        return ""

    def _changed_state(
        self, message: Message, component: Component, code: ReturnCode, why: str
    ) -> None:
        if not message.get("wait", True):
            return
        if code is ReturnCode.OK:
            self._answer(message, "")
        else:
            self._refuse(message, Refused(f"{why}: {component.instance}"), code)
