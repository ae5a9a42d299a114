"""Patterns of ports, ``Sensor*:out``: expand to the ports that live.

``*`` stands for any text, ``?`` for any character. A pattern without a slash is one of names
anywhere below the working directory, and ``.rtc`` may be left out; in one with a slash each
element is a pattern of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.deployment.listing import listing_of
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import NotFound
from rtkit.probe.port_spec import WORDS, PortSpec
from rtkit.rtc.enums import PortType
from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, glob, is_glob, is_local_host
from rtkit.rtc.profiles import PortRef
from rtkit.tree.resolve import find
from rtkit.tree.view import NodeKind, TreeNode, build, once

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.rtc.names import Path


def expanded(
    snapshot: Snapshot, specs: Sequence[PortSpec], wanted: PortType, *, is_patient: bool = False
) -> list[tuple[PortSpec, PortRef | None]]:
    """Return specifications with each pattern replaced by those of the ports that match it.

    Each has its port behind it, None where that is not there; each port is there once, as it was
    named first. A name that has * or ? in it is no pattern.

    Args:
        snapshot: Facts of the manager.
        specs: As the user gave them.
        wanted: The kind of ports that patterns match.
        is_patient: Whether a pattern may match nothing as yet.

    Raises:
        NotFound: A pattern matches nothing.
    """
    root = build(listing_of(snapshot))
    own = OwnEnds.of(snapshot)
    found: list[tuple[PortSpec, PortRef | None]] = []
    taken: set[PortRef] = set()
    for spec in sorted(specs, key=lambda each: each.is_pattern):
        named = list(_named(snapshot, root, spec.path))
        is_there = find(root, spec.path, snapshot.host) is not None
        if not spec.is_pattern or named or (is_there and not is_glob(spec.path.port or "")):
            found.append((spec, next(iter(named), None)))
            taken.update(map(own.end, named))
            continue
        matches = list(_matches(snapshot, root, spec, wanted))
        if not matches and not is_patient:
            raise NotFound(f"No {WORDS[wanted]} port matches: {spec.path.typed}")
        for each, ref in matches:
            end = own.end(ref)
            found += [(each, ref)] * (end not in taken)
            taken.add(end)
    return found


def _named(snapshot: Snapshot, root: TreeNode, path: Path) -> Iterator[PortRef]:
    """Yield the port that a path names, with or without a stream, if it is there."""
    node = find(root, path, snapshot.host)
    facts = snapshot.component(node.instance) if node is not None else None
    text = path.port or ""
    for name in (text, text.rpartition(".")[0]):
        if facts is not None and facts.port(name) is not None:
            yield PortRef(facts.instance, name)
            return


def _matches(
    snapshot: Snapshot, root: TreeNode, spec: PortSpec, wanted: PortType
) -> Iterator[tuple[PortSpec, PortRef]]:
    known = {facts.instance: facts for facts in snapshot.components}
    nodes = (n for n in root.walk() if n.kind is NodeKind.COMPONENT)
    for node in once(each for each in nodes if _is_at(each, spec.path, snapshot.host)):
        facts = known[node.instance]
        if not facts.is_tool:
            for name, text in _ports(facts, spec.path.port or "", wanted):
                elements = tuple(node.path[1:].split("/"))
                path = spec.path._replace(typed=f"{node.path}:{text}", elements=elements, port=text)
                yield spec._replace(typed=path.typed, path=path), PortRef(facts.instance, name)


def _is_at(node: TreeNode, path: Path, host: str) -> bool:
    *above, last = path.elements
    above = [LOCAL if not n and is_local_host(each, host) else each for n, each in enumerate(above)]
    names = node.path[1:].split("/")
    has_slash = "/" in path.typed
    if has_slash and len(names) != len(above) + 1:
        return False
    pairs = list(zip(above, names[:-1], strict=False))
    if len(pairs) < len(above) or not all(glob(want).fullmatch(name) for want, name in pairs):
        return False
    pattern = glob(last)
    stem = names[-1].removesuffix(COMPONENT_SUFFIX)
    return bool(pattern.fullmatch(names[-1]) or pattern.fullmatch(stem))


def _ports(facts: ComponentFacts, text: str, wanted: PortType) -> Iterator[tuple[str, str]]:
    """Yield the ports that match, each with the text that specifies it, and its stream."""
    head, dot, stream = text.rpartition(".")
    names = {port.name for port in facts.ports}
    for port in facts.ports:
        if port.port_type is wanted:
            with_stream = f"{port.name}.{stream}"
            if glob(text).fullmatch(port.name):
                yield port.name, port.name
            elif dot and glob(head).fullmatch(port.name) and with_stream not in names:
                yield port.name, with_stream
