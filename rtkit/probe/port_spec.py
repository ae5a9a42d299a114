"""Port specifications of data tools: ``PATH:PORT[.STREAM][#FORMATTER]``.

Ports that are given the same stream name share one port of the tool.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import Path, is_glob, parse_path
from rtkit.rtc.profiles import PortProfile, PortRef
from rtkit.tree.clock import StampClock
from rtkit.tree.resolve import component_of_port, no_port
from rtkit.tree.view import build
from rtkit.tree.wiring import Facts, ResolvedPort

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

_FORMATTER = r"[A-Za-z_][\w.]*"
_STREAM = r"\w+"
WORDS = {PortType.OUT: "output", PortType.IN: "input"}
STREAMS = {PortType.OUT: "input", PortType.IN: "output"}
"""Role of the tool's own port towards a component's: unnamed streams are numbered so."""


class PortSpec(NamedTuple):
    """Specification of one port by a user.

    Attributes:
        path: With everything behind the colon but the formatter as the port, since a port's name
            may have dots too.
        formatter: Name of the function that makes text of values, "" for the usual form.
    """

    typed: str
    path: Path
    formatter: str = ""

    @property
    def is_pattern(self) -> bool:
        """Return whether it may stand for several ports."""
        return is_glob(str(self.path))


class Stream(NamedTuple):
    """One port of the tool, and the ports of components that it is connected to.

    Attributes:
        elsewhere: IDL of its type that another port has; for where these have none.
        clock: Whose time stamps of its values are.
        tree: The manager of these components; None for the one that is asked.
    """

    name: str
    ends: tuple[ResolvedPort, ...]
    formatter: str = ""
    elsewhere: str = ""
    clock: StampClock = StampClock()
    tree: Tree | None = None

    @property
    def data_type(self) -> str:
        """Data type of its values; empty where the port takes any."""
        return next((end.port.data_type for end in self.ends if end.port.data_type), "")

    @property
    def definition(self) -> str:
        """IDL of that type from a port's properties; empty where no port has it."""
        return next(
            (end.port.definition for end in self.ends if end.port.definition), self.elsewhere
        )


def parse_spec(typed: str, cwd: str = "/") -> PortSpec:
    """Read a port specification, relative to the working directory `cwd`.

    Raises:
        Malformed: It has no port, or a part that cannot be one.
    """
    text, hash_mark, formatter = typed.partition("#")
    if hash_mark and not re.fullmatch(_FORMATTER, formatter):
        raise Malformed(f"Bad port specification: {typed}")
    try:
        path = parse_path(text, cwd)
    except Malformed:
        raise Malformed(f"Bad port specification: {typed}") from None
    if path.port is None:
        raise Malformed(f"Bad port specification: {typed}")
    return PortSpec(typed, path, formatter)


def find_streams(
    facts: Facts,
    specs: Sequence[PortSpec],
    wanted: PortType,
    unnamed: Callable[[int, PortRef], str] | None = None,
) -> tuple[Stream, ...]:
    """Return the streams of the ports that were specified, all of the kind that is `wanted`.

    `unnamed` gives those a name that have none, by their number and port; else they are numbered.

    Raises:
        NotFound: A component or a port does not exist.
        Refused: A port of another kind, or streams of one name that do not go together.
    """
    listing = facts.listing()
    root = build(listing)
    paths = [spec.path for spec in specs]
    instances = [component_of_port(root, path, listing.host).instance for path in paths]
    snapshot = facts.part(instances)
    found: dict[str, list[tuple[ResolvedPort, PortSpec]]] = {}
    for spec, instance in zip(specs, instances, strict=True):
        component = snapshot.component(instance)
        if component is None:
            raise NotFound(f"No such object: {spec.path.typed}")
        port, name = _port_and_stream(spec, {port.name: port for port in component.ports})
        if port.port_type is not wanted:
            raise Refused(f"Port is not {WORDS[wanted]}: {spec.path.typed}")
        end = ResolvedPort(spec.path, PortRef(instance, port.name), port)
        number = sum(len(group) for group in found.values())
        if not name:
            name = unnamed(number, end.ref) if unnamed else f"{STREAMS[wanted]}{number}"
            while name in found:
                name += "_"
        found.setdefault(name, []).append((end, spec))
    return tuple(_stream(name, group) for name, group in found.items())


def _port_and_stream(spec: PortSpec, ports: dict[str, PortProfile]) -> tuple[PortProfile, str]:
    text = spec.path.port or ""
    if text in ports:
        return ports[text], ""
    name, dot, stream = text.rpartition(".")
    if dot and name in ports:
        if not re.fullmatch(_STREAM, stream):
            raise Malformed(f"Bad port specification: {spec.typed}")
        return ports[name], stream
    raise no_port(spec.path, ports)


def _stream(name: str, group: Sequence[tuple[ResolvedPort, PortSpec]]) -> Stream:
    stream = Stream(name, tuple(end for end, _ in group), group[0][1].formatter)
    for end, spec in group:
        if spec.formatter != stream.formatter or end.port.data_type != stream.data_type:
            raise Refused(f"Streams of the same name, {name}, have different properties")
    return stream
