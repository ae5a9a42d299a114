"""How each action is done: generators that yield what they wait for.

A procedure yields

* `Need(name)`: the living slave of that name, started if there is none; receives a `Process`;
* `Ask(process, message)`: the answer of a process's holder; receives its value;
* `Tell(process, message)`: a message sent; goes on at once;
* `Signal(process, number)`: a signal sent; goes on at once;
* `Later(procedure)`: another procedure begun, whose outcome nobody waits for; goes on at once;
* `UntilEnded(timeout_s)`: the end of any slave.

An error that ends the wait is raised inside the procedure. What a procedure has changed when it
fails, it takes back itself.
"""

from __future__ import annotations

import itertools
import signal
from collections.abc import Generator
from dataclasses import dataclass
from typing import Any

from rtkit.component.check import refusal
from rtkit.component.options import parse_options
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action, Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable
from rtkit.manager.events import OWN_PROCESS, Message
from rtkit.manager.state import Process, State
from rtkit.rtc.create import FRESH_SLAVE, CreateString, parse_create
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, check_instance_name, is_local_host
from rtkit.rtc.plain import encode
from rtkit.rtc.profiles import ConnectorProfile, ModuleProfile, PortProfile, TypeProfile


@dataclass(frozen=True, slots=True)
class Need:
    """Wait for the slave of that name, which is started if it does not live."""

    name: str


@dataclass(frozen=True, slots=True)
class Ask:
    """Send a message to a holder and wait for its answer; time-out 0 means the batch's [s]."""

    process: Process
    message: Message
    timeout_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Tell:
    """Send a message to a holder that needs no answer."""

    process: Process
    message: Message


@dataclass(frozen=True, slots=True)
class Signal:
    """Send a signal to a slave."""

    process: Process
    number: int


@dataclass(frozen=True, slots=True)
class UntilEnded:
    """Wait until some slave has ended, at most `timeout_s` [s]."""

    timeout_s: float


@dataclass(frozen=True, slots=True)
class Later:
    """Begin a procedure that goes on by itself: cleaning up must not delay an answer."""

    procedure: Procedure


MASTER_PORT = 2810
"""Where a master listens by convention; addresses of other local ports stand for its slaves."""

TERM_S = 2.0
"""Grace between TERM and KILL [s]."""

Procedure = Generator[Need | Ask | Tell | Signal | UntilEnded | Later, Any, Result]


def procedure_for(action: Action, state: State) -> Procedure:
    """Return the procedure of an action."""
    match action:
        case act.Load():
            return _load(state, action)
        case act.Unload():
            return _unload(state, action)
        case act.Create():
            return _create(state, action)
        case act.Delete():
            return _delete(state, action)
        case act.Connect():
            return _connect(state, action.connector)
        case act.Disconnect():
            return _disconnect(state, action)
        case act.SetParameters():
            wish = {"op": "set", "set_id": action.set_id, "values": dict(action.values)}
            return _tell(state, action.instance, wish)
        case act.ActivateSet():
            return _tell(state, action.instance, {"op": "activate_set", "set_id": action.set_id})
        case act.ChangeState():
            message: dict[str, Any] = {
                "op": "change_state",
                "context": action.context,
                "transition": action.transition.value,
                "wait": action.wait,
            }
            return _tell(state, action.instance, message)


def living(state: State, instance: str) -> Process:
    """Return the process that holds a component.

    Raises:
        NotFound: There is no such component.
        Refused: It is a zombie.
    """
    facts = state.components.get(instance)
    process = state.process_of(instance)
    if facts is None or process is None:
        raise NotFound(f"no component named {instance}")
    if facts.zombie:
        raise Refused(f"zombie ({facts.zombie}): {instance}")
    return process


def _tell(state: State, instance: str, message: Message) -> Procedure:
    process = living(state, instance)
    value = yield Ask(process, {**message, "instance": instance})
    return Result(value=value)


# modules


def _load(state: State, action: act.Load) -> Procedure:
    own = state.processes[OWN_PROCESS]
    value = yield Ask(own, {"op": "load", "path": action.path, "init": action.init})
    types = tuple(TypeProfile(**item) for item in value["types"])
    state.modules[action.path] = ModuleProfile(action.path, value["init"], types)
    return Result(value=value["path"])


def _unload(state: State, action: act.Unload) -> Procedure:
    if action.path not in state.modules:
        raise NotFound(f"module is not loaded: {action.path}")
    for process in [p for p in state.processes.values() if p.state == "up"]:
        yield Ask(process, {"op": "unload", "path": action.path})
    del state.modules[action.path]
    return Result()


# components


def _create(state: State, action: act.Create) -> Procedure:
    create = parse_create(action.create)
    wished = create.instance_name
    known = state.components.get(wished)
    if known is not None and not known.zombie:
        return Result(value=wished)
    names = action.names or (known.names if known is not None else ())
    _check_names(state, names, wished)
    instance = _reserve(state, wished, action, create)
    try:
        process = yield from _place(state, create)
        yield from _make(state, process, action, create.with_options(instance_name=instance))
    finally:
        state.reserved.discard(instance)
    state.update(instance, names=names or (f"{LOCAL}/{instance}{COMPONENT_SUFFIX}",))
    return Result(value=instance)


def _check_names(state: State, names: tuple[str, ...], instance: str) -> None:
    for name in names:
        owner = state.name_owner(name)
        if owner and owner != instance:
            raise Refused(f"name /{name} is taken by {owner}")


def _reserve(state: State, wished: str, action: act.Create, create: CreateString) -> str:
    """Choose the instance name, ``<type><n>`` unless wished otherwise, and hold it."""
    if wished:
        check_instance_name(wished)
        if wished in state.reserved:
            raise Refused(f"{wished} is just being made")
        state.reserved.add(wished)
        return wished
    pattern = action.pattern
    base = pattern.type.type_name if pattern is not None else create.implementation_id
    names = (f"{base}{n}" for n in itertools.count())
    chosen = next(n for n in names if n not in state.components and n not in state.reserved)
    state.reserved.add(check_instance_name(chosen))
    return chosen


def _place(state: State, create: CreateString) -> Generator[Need, Any, Process]:
    name = create.place or _slave_at(state, create.address)
    if name in ("", state.name):
        return state.processes[OWN_PROCESS]
    if name != FRESH_SLAVE:
        check_instance_name(name)
    process: Process = yield Need(name)
    return process


def _slave_at(state: State, address: str) -> str:
    """Return the slave that stands for ``host:port``; port 2810 is the manager itself."""
    if not address:
        return ""
    host, _, port = address.rpartition(":")
    if not port.isascii() or not port.isdigit():
        raise Malformed(f"manager address is not host:port: {address}")
    if not is_local_host(host, state.host):
        raise Unreachable(f"no manager is known on host {host}: {address}")
    return "" if int(port) == MASTER_PORT else f"{state.name}_{int(port)}"


def _make(state: State, process: Process, action: act.Create, create: CreateString) -> Procedure:
    instance = create.instance_name
    message = {
        "op": "create",
        "create": str(create),
        "pattern": encode(action.pattern) if action.pattern is not None else None,
        "modules": [[module.path, module.init] for module in state.modules.values()],
    }
    before = state.components.get(instance)
    try:
        yield Ask(process, message)
        facts = state.components.get(instance)
        if facts is None or facts.zombie:
            raise Refused(f"{instance} ended while it was made")
    except RtkitError:
        yield Later(_unmake(state, process, instance, before))
        raise
    if create.place == FRESH_SLAVE:
        create = create.with_options(manager_name=process.name)
    state.update(instance, create=str(create), process=process.name)
    return Result(value=instance)


def _unmake(
    state: State, process: Process, instance: str, before: ComponentFacts | None
) -> Procedure:
    """Leave nothing of a component that could not be made; a zombie stays the zombie it was."""
    if state.components.get(instance) is not before:
        state.forget(instance)
    if process.state == "up":
        yield Tell(process, {"op": "delete", "instance": instance})
        yield from retire(state, process)
    return Result()


def _delete(state: State, action: act.Delete) -> Procedure:
    instance = action.instance
    facts = state.components.get(instance)
    process = state.process_of(instance)
    if facts is None or process is None:
        raise NotFound(f"no component named {instance}")
    for wire in state.connectors_of(instance):
        yield from _unwire(state, wire)
    if not facts.zombie:
        yield Ask(process, {"op": "delete", "instance": instance})
    state.forget(instance)
    yield from retire(state, process)
    return Result()


def retire(state: State, process: Process) -> Procedure:
    """End a slave that holds nothing any more (``manager.shutdown_on_nortcs``)."""
    if process.is_slave and process.state == "up" and not state.held_by(process.key):
        yield from end_slaves([process])
    return Result()


def end_slaves(slaves: list[Process]) -> Procedure:
    """End these processes: TERM, a grace, KILL; return when the kernel reported their end."""
    for process in slaves:
        process.is_wanted = False
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in slaves:
            if process.is_alive:
                yield Signal(process, number)
                if process.state == "stopped":
                    yield Signal(process, signal.SIGCONT)
        try:
            while any(process.is_alive for process in slaves):
                yield UntilEnded(TERM_S)
        except Unreachable:
            continue
    return Result()


# connectors


def _connect(state: State, wire: ConnectorProfile) -> Procedure:
    known = state.connectors.get(wire.connector_id)
    if known is not None:
        return _same(known, wire)
    ports = _ports(state, wire)
    text = refusal(ports, wire.properties)
    if text:
        raise Refused(text)
    if not wire.connector_id or any(ord(c) < 32 for c in wire.connector_id):
        raise Malformed(f"connector id is empty or has control characters: {wire.connector_id!r}")
    state.connectors[wire.connector_id] = wire
    try:
        if ports[0].port_type is not PortType.SERVICE:
            yield from _wire(state, wire)
    except RtkitError:
        state.connectors.pop(wire.connector_id, None)
        raise
    if wire.connector_id not in state.connectors:
        raise Refused(f"an end of connection {wire.connector_id} ended while it was made")
    return Result(value=wire.connector_id)


def _same(known: ConnectorProfile, wire: ConnectorProfile) -> Result:
    if set(known.ports) != set(wire.ports):
        ends = " and ".join(map(str, known.ports))
        raise Refused(f"connector id {wire.connector_id} is in use between {ends}")
    changed = [key for key, value in wire.properties.items() if known.properties.get(key) != value]
    if changed:
        raise Refused(
            f"connection {wire.connector_id} exists with another {', '.join(sorted(changed))}"
        )
    return Result(value=wire.connector_id)


def _ports(state: State, wire: ConnectorProfile) -> list[PortProfile]:
    if len(wire.ports) != 2:
        raise Malformed(f"a connection joins two ports, not {len(wire.ports)}")
    ports = []
    for end in wire.ports:
        living(state, end.instance)
        port = state.components[end.instance].port(end.port)
        if port is None:
            raise NotFound(f"Port not found: {end}")
        ports.append(port)
    return ports


def _wire(state: State, wire: ConnectorProfile) -> Procedure:
    """Open both ends: first the one that listens, which is the one that takes no initiative."""
    out, into = (living(state, end.instance) for end in wire.ports)
    plain = encode(wire)
    if out is into:
        yield Ask(out, {"op": "link", "connector": plain})
        return Result()
    if parse_options(wire.properties).dataflow == "pull":
        first, opens, second, joins = out, "serve", into, "fetch"
    else:
        first, opens, second, joins = into, "sink", out, "source"
    endpoint = yield Ask(first, {"op": opens, "connector": plain})
    try:
        yield Ask(second, {"op": joins, "connector": plain, "endpoint": endpoint})
    except RtkitError:
        if first.state == "up":
            yield Tell(first, {"op": "unlink", "connector_id": wire.connector_id})
        raise
    return Result()


def _disconnect(state: State, action: act.Disconnect) -> Procedure:
    wire = state.connectors.get(action.connector_id)
    if wire is None:
        raise NotFound(f"no connection with id {action.connector_id}")
    yield from _unwire(state, wire)
    return Result()


def _unwire(state: State, wire: ConnectorProfile) -> Procedure:
    """Take a connector off both ends, the sending one first; a dead end is no obstacle."""
    state.connectors.pop(wire.connector_id, None)
    seen: list[Process] = []
    for end in wire.ports:
        process = state.process_of(end.instance)
        if process is not None and process.state == "up" and process not in seen:
            seen.append(process)
            yield Ask(process, {"op": "unlink", "connector_id": wire.connector_id})
    return Result()
