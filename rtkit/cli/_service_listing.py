"""What ``rtls`` shows of a property service: names, or with them type, access, unit, value."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.cli import _out
from rtkit.cli._app import App, working_directory
from rtkit.cli._properties import record, shown

if TYPE_CHECKING:
    from rtkit.property.values import Element, Value
    from rtkit.tree.properties import Place

_HEAD = ("type", "access", "unit", "quality")


def service_at(typed: str) -> Place | None:
    """Return the place in a service that a path names, None if it names something else."""
    from rtkit.link.places import services

    known = services()
    if not known:
        return None
    from rtkit.tree.properties import parse

    place = parse(typed, working_directory(), known, os.uname().nodename)
    return place if place.service else None


def listed(app: App, place: Place, *, is_long: bool, recurse: bool, is_json: bool) -> list[str]:
    """Return what is shown of a service.

    Raises:
        PropertyError: As the service answers.
    """
    from rtkit.tree.properties import Places, asked

    typed = place.typed
    places = Places(working_directory(), "", app.timeout_s)
    try:
        _, end = places.find(typed)
        base = f"{place.name}.properties" if place.name else "properties"
        more = "all" if recurse else ""
        if not is_long and not is_json:
            text = asked(lambda: end.ask(f"{base}?{more}" if more else base), typed)
            return [shown(str(name)) for name in _group(text)]
        target = f"{base}?meta&{more}" if more else f"{base}?meta"
        rows = _group(asked(lambda: end.ask(target), typed))
    finally:
        places.close()
    if is_json:
        return [_record(typed, row) for row in rows]
    return _columns([_cells(row) for row in rows])


def _group(text: str | bytes) -> tuple[Value, ...]:
    from rtkit.property.reading import Limits, read

    value = read(str(text), Limits(text=1 << 26, items=1 << 24))
    return value if isinstance(value, tuple) else (value,)


def _cells(row: Value) -> tuple[str, ...]:
    from rtkit.property.values import Element
    from rtkit.property.writing import write

    assert isinstance(row, tuple)
    name, meta, *value = row
    told = [_field(meta, key) for key in _HEAD] if isinstance(meta, Element) else ["-"] * 4
    text = write(value[0]) if value else ""
    return (*told, str(name), text if len(text) <= 200 else f"{text[:200]}…")


def _field(meta: Element, key: str) -> str:
    found = meta.find(key)
    return str(found.leaf) if found is not None and found.leaf is not None else "-"


def _columns(rows: list[tuple[str, ...]]) -> list[str]:
    cells = [tuple(map(_out.printable, row)) for row in rows]
    widths = [max(map(len, column)) + 2 for column in zip(*cells, strict=True)]
    return ["".join(map(str.ljust, row, widths)).rstrip() for row in cells]


def _record(typed: str, row: Value) -> str:
    from rtkit.property.writing import write

    assert isinstance(row, tuple)
    name, _, *value = row
    return record("property", f"{typed.rstrip('/')}.{name!s}", write(value[0]) if value else "()")
