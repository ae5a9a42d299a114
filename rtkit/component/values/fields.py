"""Fields of data types: checks names like ``data.position.x`` and lists the numbers of a value."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any

from rtkit.component.values.type_layout import (
    ArrayLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
)
from rtkit.errors import Malformed, NotFound
from rtkit.rtc.nearest import did_you_mean

_STEP = r"([A-Za-z_]\w*)|\[(\d{1,9})\]"
_STAMP = "tm"


def steps_of(text: str) -> list[str | int]:
    """Return the names and indices that ``data.position.x`` or ``ranges[0]`` goes through.

    Raises:
        Malformed: It is no such text.
    """
    steps: list[str | int] = []
    for part in text.split("."):
        position = 0
        while position < len(part):
            match = re.compile(_STEP).match(part, position)
            if match is None or (position == 0) is (match[1] is None):
                raise Malformed(f"Bad field: {text} (it is NAME.NAME or NAME[INDEX])")
            steps.append(match[1] or int(match[2]))
            position = match.end()
        if not part:
            raise Malformed(f"Bad field: {text} (it is NAME.NAME or NAME[INDEX])")
    return steps


def check_field(cls: type, text: str) -> None:
    """Refuse a field that no value of a data type can have; bytes may be of any type.

    Raises:
        Malformed: It is no field at all.
        NotFound: The type has none of that name; lists those that it has.
    """
    steps = steps_of(text)
    layout: Layout | None = None if cls is bytes else layout_of(cls)
    for step in steps:
        if layout is None:
            return
        layout = _below(layout, step, text)


def _below(layout: Layout, step: str | int, text: str) -> Layout | None:
    if isinstance(step, str):
        known = dict(layout.fields) if isinstance(layout, StructLayout) else {}
        if step not in known:
            has = ", ".join(known) or "no fields"
            hint = did_you_mean(step, known)
            raise NotFound(f"no field {text}: {layout.name} has {has}{hint}")
        return known[step]
    if isinstance(layout, ItemsLayout):
        return layout.item
    if isinstance(layout, ArrayLayout):
        if step >= len(layout.items):
            raise NotFound(f"no field {text}: {layout.name} has {len(layout.items)} items")
        return layout.items[step]
    if isinstance(layout, StructLayout):
        raise NotFound(f"no field {text}: {layout.name} has {', '.join(dict(layout.fields))}")
    return None


def numbers(value: Any, name: str = "") -> Iterator[tuple[str, float]]:
    """Yield the numbers in a value, by field; time stamps are left out."""
    for field, item in scalars(value, name):
        if isinstance(item, int | float):
            yield field, float(item)


def scalars(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the scalars of a value, by field; time stamps and octets are left out."""
    if is_dataclass(value) and not isinstance(value, type):
        for each in fields(value):
            if each.name != _STAMP:
                yield from scalars(getattr(value, each.name), f"{name}.{each.name}".lstrip("."))
    elif isinstance(value, list | tuple):
        for index, item in enumerate(value):
            yield from scalars(item, f"{name}[{index}]")
    elif isinstance(value, Enum):
        yield name, value.name
    elif not isinstance(value, bytes):
        yield name, value
