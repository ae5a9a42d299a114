"""Calls operations of service ports: finds them, reads their arguments, names their results."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from rtkit.component.services.defined_interface import (
    DefinedInterface,
    DefinedOperation,
    interface_of,
)
from rtkit.component.services.invocation import Remote
from rtkit.component.services.service import TIMEOUT, ServicePort
from rtkit.component.types import Time
from rtkit.component.values.literal import Literal
from rtkit.component.values.type_layout import BasicLayout, EnumLayout, Layout
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import MISSING, make_dataclass
from rtkit.link.tap_messages import call_to_bytes
from rtkit.probe.port_spec import Stream
from rtkit.probe.probe import Probe
from rtkit.probe.templates import as_json
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.names import Path
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import PortProfile
from rtkit.tree.client import Tree
from rtkit.tree.connect import is_behind_tls
from rtkit.tree.resolve import no_port
from rtkit.tree.wiring import Facts, ResolvedPort, find_ends, ports_of

if TYPE_CHECKING:
    from rtkit.tree.secure_link import SecureLink


class ProvidedOperation(NamedTuple):
    """An operation of a port.

    Attributes:
        end: The port that provides it.
        instance: Name of its interface at the port; ``type_name`` is that of the interface.
    """

    end: ResolvedPort
    instance: str
    type_name: str
    interface: DefinedInterface
    operation: DefinedOperation

    @property
    def label(self) -> str:
        """``Hand0.gripper: close``, for messages."""
        return f"{self.end.ref}: {self.operation.name}"

    def arguments(self, typed: Sequence[str]) -> tuple[Any, ...]:
        """Return the arguments that texts stand for: JSON or YAML, or texts as they are.

        Raises:
            Malformed: There are too few, or too many, or one is of another type.
        """
        method = self.interface.interface.methods[self.operation.name]
        layouts, hints = method.layouts, method.hints
        if len(typed) != len(layouts):
            has = f"{self.operation.name} takes {len(layouts)} arguments, not {len(typed)}"
            shown = has.replace(" 1 arguments", " 1 argument")
            raise Malformed(f"{shown} ({self.operation.text})")
        if not layouts:
            return ()
        record = make_dataclass(self.operation.name, [(n, hints[n], MISSING) for n in layouts])
        pairs = zip(layouts.items(), typed, strict=True)
        try:
            texts = [f'"{name}":{_json(layout, text)}' for (name, layout), text in pairs]
            value = Literal(record, f"{{{','.join(texts)}}}").at(Time())
        except Malformed as error:
            raise Malformed(f"{error} ({self.operation.text})") from None
        return tuple(getattr(value, name) for name in layouts)

    def call(self, tree: Tree, arguments: Sequence[Any], timeout_s: float) -> dict[str, Any]:
        """Call it; return the values by name, that of the result itself has none.

        Raises:
            RaisedByProvider: It raised an exception that it declares.
            Refused: It raised another one, or the port takes no connection.
            Unreachable: There was no answer in time [s].
        """
        method = self.interface.interface.methods[self.operation.name]
        if is_behind_tls(tree):
            send = partial(_ask_tap, tree, self.end)
            far = Remote(self.type_name, str(self.end.ref), send, time.monotonic_ns)
            value = far.call(method, arguments, {}, timeout_s)
        else:
            with _required(tree, self.end, self.type_name, timeout_s) as port:
                value = port.call(method, self.type_name, tuple(arguments), {}, timeout_s)
        names = self.operation.returned
        return dict(zip(names, value if len(names) > 1 else (value,), strict=False))


_PORT = "required"


@contextmanager
def _required(
    tree: Tree, end: ResolvedPort, type_name: str, timeout_s: float
) -> Iterator[ServicePort]:
    """Give a port that is connected to one that provides an interface."""
    interface = _interface(end.port, type_name, str(end.ref)).interface
    port = ServicePort(_PORT).require(interface.cls, type_name=type_name)
    with Probe(tree, "rtcall", [Stream(_PORT, (end,))], [port]) as probe:
        probe.connect({TIMEOUT: f"{timeout_s:g}"})
        yield port


def _ask_tap(tree: Tree, end: ResolvedPort, call: bytes, timeout_s: float) -> bytes:
    """Have the tap at a manager that is reached over TLS send a call, and return the reply."""
    about = [end.ref.instance, end.ref.port, end.path.typed]
    # Its deadline is by the clock of this host: there it gets one of its own.
    body = call_to_bytes(about, timeout_s, call.partition(b"\t")[2])
    return cast("SecureLink", tree.link).ask_tap("call", body, timeout_s + tree.timeout_s)()


def pass_on(tree: Tree, end: ResolvedPort, call: bytes, timeout_s: float) -> bytes:
    """Send a call that another process has encoded, but for its deadline; return the reply.

    Raises:
        NotFound: Nothing is known of its interface.
        Refused: The port takes no connection.
        Unreachable: There was no answer in time [s].
    """
    type_name = call.partition(b"\t")[0].decode(errors="replace")
    with _required(tree, end, type_name, timeout_s) as port:
        return port.pass_on(type_name, call, timeout_s)


def operations_at(facts: Facts, path: Path) -> tuple[list[ProvidedOperation], str]:
    """Return all operations of the port that a path names, and what stands behind the port.

    Raises:
        NotFound: There is no such component or port, or nothing is known of its interfaces.
        Refused: It is no service port, or provides nothing.
    """
    typed = path.port or ""
    names = [port.name for port in ports_of(facts, path)]
    fitting = [each for each in names if f"{typed}.".startswith(f"{each}.")]
    if not fitting:
        raise no_port(path._replace(port=typed.partition(".")[0]), names)
    name = max(fitting, key=len)
    _, [end] = find_ends(facts, [path._replace(port=name)])
    return _operations(end), typed[len(name) + 1 :]


def _operations(end: ResolvedPort) -> list[ProvidedOperation]:
    port = end.port
    if port.port_type is not PortType.SERVICE:
        raise Refused(f"Port is not a service: {end.ref}")
    provided = [each for each in port.interfaces if each.polarity is Polarity.PROVIDED]
    if not provided:
        raise Refused(f"{end.ref} provides no interface, it requires some")
    found = []
    for each in provided:
        interface = _interface(port, each.type_name, str(end.ref))
        found += [
            ProvidedOperation(end, each.instance_name, each.type_name, interface, operation)
            for operation in interface.operations.values()
        ]
    return found


def _interface(port: PortProfile, type_name: str, label: str) -> DefinedInterface:
    if not port.definition:
        raise NotFound(f"{label} does not tell the operations of {type_name}")
    return interface_of(type_name, port.definition)


def chosen(operations: Sequence[ProvidedOperation], typed: str) -> ProvidedOperation:
    """Return the operation that is meant by ``OPERATION`` or ``INSTANCE.OPERATION``.

    Raises:
        NotFound: There is none.
        Malformed: There are several.
    """
    instance, _, name = typed.rpartition(".")
    known = {f"{each.instance}.{each.operation.name}": each for each in operations}
    meant = [
        each
        for full, each in known.items()
        if each.operation.name == name and instance in ("", each.instance)
    ]
    if len(meant) > 1:
        words = " or ".join(full for full in known if full.endswith(f".{name}"))
        raise Malformed(f"{name} is an operation of several interfaces: {words}")
    if not meant:
        names = list(dict.fromkeys(each.operation.name for each in operations))
        hint = did_you_mean(name, names)
        has = ", ".join(names)
        raise NotFound(f"no operation {typed} of {operations[0].end.ref}{hint}; it has {has}")
    return meant[0]


def _json(layout: Layout, text: str) -> str:
    """Return what was typed as JSON; for a text or a word that may be the bare text."""
    if _is_text(layout) and not (text[:1] == text[-1:] == '"' and len(text) > 1):
        from json import dumps

        return dumps(text)
    return as_json(text)


def _is_text(layout: Layout) -> bool:
    if isinstance(layout, EnumLayout):
        return True
    return isinstance(layout, BasicLayout) and layout.cls is str
