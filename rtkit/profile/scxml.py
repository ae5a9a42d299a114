"""Reads and writes SCXML: states, their nesting, transitions by events; nothing else of it.

A state inside another one is ``Outer.Inner`` in the table; in the document its id is the last
part where that is unique. Executable content (``onentry``, ``script`` …) is noted and left out:
what a component does in a state is its own code.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.profile.common import Note
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.parse import parse

NAMESPACE = "http://www.w3.org/2005/07/scxml"
_STATES = ("state", "final")
_REFUSED = ("parallel", "history")
_KNOWN = ("initial", "transition", *_STATES, *_REFUSED)
Table = Mapping[str, Mapping[str, str]]


class StateChart(NamedTuple):
    """A document read.

    Attributes:
        states: State to event to next state; the initial one is the first at every level.
        notes: Elements that were left out.
    """

    name: str
    states: Table
    notes: tuple[Note, ...]


def write_scxml(name: str, states: Table) -> str:
    """Return the SCXML text of a table of states."""
    from lxml import etree

    root = etree.Element(_tag("scxml"), nsmap={None: NAMESPACE})  # type: ignore[dict-item]
    root.set("version", "1.0")
    root.set("name", name)
    ids = _ids(states)
    elements: dict[str, Any] = {"": root}
    for state in states:
        outer = state.rpartition(".")[0]
        if elements[outer].get("initial") is None:
            elements[outer].set("initial", ids[state])
        elements[state] = etree.SubElement(elements[outer], _tag("state"), id=ids[state])
        for event, target in states[state].items():
            made = etree.SubElement(elements[state], _tag("transition"))
            made.set("event", event)
            made.set("target", ids[target])
    etree.indent(root, "    ")
    return etree.tostring(root, encoding="unicode") + "\n"


def read_scxml(data: bytes, source: str = "<stdin>") -> StateChart:
    """Read SCXML.

    Raises:
        InvalidProfile: All that is wrong with it, by line.
    """
    root = parse(data, source)
    problems: list[Note] = []
    notes: list[Note] = []
    if root.tag == "scxml":
        hint = f'the root is in no namespace: <scxml xmlns="{NAMESPACE}" …>'
        raise InvalidProfile(source, [Note(root.sourceline, hint)])
    if root.tag != _tag("scxml"):
        raise InvalidProfile(source, [Note(root.sourceline, "the root is no scxml element")])
    paths: dict[str, str] = {}
    elements = list(_states(root, "", paths, problems))
    states: dict[str, dict[str, str]] = {}
    for path, element in elements:
        states[path] = dict(_moves(element, paths, problems))
    for item in root.iter():
        space, _, local = str(item.tag).rpartition("}")
        if space != "{" + NAMESPACE or local not in (*_KNOWN, "scxml"):
            notes.append(Note(item.sourceline, f"{local} is left out"))
        elif local in _REFUSED:
            problems.append(Note(item.sourceline, f"{local} is not supported"))
    if not states:
        problems.append(Note(root.sourceline, "there is no state"))
    if problems:
        raise InvalidProfile(source, problems)
    return StateChart(root.get("name") or "", states, tuple(notes))


def _tag(local: str) -> str:
    return f"{{{NAMESPACE}}}{local}"


def _ids(states: Table) -> dict[str, str]:
    short = {state: state.rpartition(".")[2] for state in states}
    names = list(short.values())
    return {state: id if names.count(id) == 1 else state for state, id in short.items()}


def _states(
    outer: Any, path: str, paths: dict[str, str], problems: list[Note]
) -> Iterator[tuple[str, Any]]:
    """Yield path and element of each state below `outer`, the initial one first."""
    children = [child for child in outer if child.tag in map(_tag, _STATES)]
    first = _initial(outer)
    if first and all(child.get("id") != first for child in children):
        problems.append(Note(outer.sourceline, f"initial is none of the states inside: {first}"))
    children.sort(key=lambda child: child.get("id") != first)
    for child in children:
        id = (child.get("id") or "").strip()
        if not id:
            problems.append(Note(child.sourceline, "a state without id"))
            continue
        own = id.removeprefix(f"{path}.") if path else id
        below = f"{path}.{own.replace('.', '_')}" if path else own.replace(".", "_")
        if id in paths or below in paths.values():
            problems.append(Note(child.sourceline, f"state {id} is there twice"))
            continue
        paths[id] = below
        yield below, child
        yield from _states(child, below, paths, problems)


def _initial(element: Any) -> str:
    inner = element.find(f"{_tag('initial')}/{_tag('transition')}")
    target = inner.get("target") if inner is not None else None
    return str(target or element.get("initial") or "").strip()


def _moves(
    element: Any, paths: Mapping[str, str], problems: list[Note]
) -> Iterator[tuple[str, str]]:
    for item in element.iterchildren(_tag("transition")):
        events, target = (item.get("event") or "").split(), (item.get("target") or "").strip()
        if not events or item.get("cond"):
            why = "a transition without event" if not events else "a transition with a condition"
            problems.append(Note(item.sourceline, f"{why} is not supported"))
        elif target not in paths:
            problems.append(Note(item.sourceline, f"no state {target or '(none)'} to go to"))
        else:
            yield from ((event, paths[target]) for event in events)
