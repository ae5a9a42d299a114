"""Steps of the page: command lines, what takes each back, and reading the actions behind them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rtkit.api.live_records import Record, Records, SystemRecords
from rtkit.errors import NotFound
from rtkit.web.fields import Fields, text_in

Action = Fields


class CommandStep(NamedTuple):
    """One action, ready to be done.

    Attributes:
        text: What it does, as a sentence.
        line: The command line.
        undo: The actions that take it back; None where nothing does.
        undo_reason: Why nothing does.
        stdin: What the command reads from stdin.
        target: The property that it sets; empty for none.
        old: The value before; None where none is known.
        new: The value that it sets; None for none.
    """

    text: str
    line: tuple[str, ...]
    undo: tuple[Action, ...] | None = None
    undo_reason: str = ""
    stdin: str = ""
    target: str = ""
    old: str | None = None
    new: str | None = None


def found_in(action: Action, key: str, records: Records, what: str) -> Record:
    """Return the record that an action names by its id.

    Raises:
        NotFound: There is none.
    """
    id = text_in(action, key)
    if id not in records:
        raise NotFound(f"No such {what}: {id}")
    return records[id]


def component_in(action: Action, records: SystemRecords) -> Record:
    """Return the component that an action is about.

    Raises:
        NotFound: There is none.
    """
    return found_in(action, "component", records.components, "component")


def port_in(action: Action, key: str, records: SystemRecords) -> str:
    """Return the path of the port that an action names.

    Raises:
        NotFound: There is none.
    """
    path = text_in(action, key)
    component, _, name = path.rpartition(":")
    known: Sequence[Record] = records.components.get(component, {}).get("ports", ())
    if all(port["name"] != name for port in known):
        raise NotFound(f"No such port: {path}")
    return path


def context_in(action: Action, component: Record) -> int:
    """Return the number of the execution context that is meant, the first one by default.

    Raises:
        NotFound: The component has none of that id, or none at all.
    """
    id = text_in(action, "context", "")
    ids = [each["id"] for each in component["contexts"]]
    if not ids or (id and id not in ids):
        raise NotFound(f"{component['id']} has no execution context {id or 0}")
    return ids.index(id) if id else 0


def wires_of(ids: Iterable[str], records: SystemRecords) -> list[str]:
    """Return the connectors of some components in words."""
    known = frozenset(ids)
    pairs = ((wire["source"], wire["target"]) for wire in records.connectors.values())
    return [
        f"{source['component']}:{source['port']} to {target['component']}:{target['port']}"
        for source, target in pairs
        if source["component"] in known or target["component"] in known
    ]


def listed(what: str, ids: Sequence[str]) -> str:
    """Return some ids in words: ``the component A``, ``3 components: A, B, C``."""
    names = ", ".join(ids)
    return f"the {what} {names}" if len(ids) == 1 else f"{len(ids)} {what}s: {names}"
