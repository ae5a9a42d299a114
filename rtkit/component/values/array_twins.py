"""Types of the name of others, with arrays of numpy where those have octets or rows of numbers."""

from __future__ import annotations

from dataclasses import field, make_dataclass
from functools import cache, partial
from typing import Any, get_type_hints

from rtkit.component.values.type_layout import (
    BasicLayout,
    ItemsLayout,
    Layout,
    StructLayout,
    layout_of,
    layout_of_hint,
    zero,
)
from rtkit.component.values.typenames import give_name, type_name


@cache
def with_arrays(cls: type) -> type:
    """Return a data type like another one, with arrays where that has octets or rows of numbers.

    It has the name of that type, so its ports are connected to those of the other: a component
    that wants the pixels of a camera as an array takes ``with_arrays(CameraImage)``.

    Raises:
        Malformed: It is no data type.
    """
    hints, fields = get_type_hints(cls, include_extras=True), []
    for name, item in layout_of(cls).fields:
        hint = _array_hint(item) or hints[name]
        empty = partial(zero, layout_of_hint(hint, f"{cls.__name__}.{name}"))
        fields.append((name, hint, field(default_factory=empty)))
    made = make_dataclass(cls.__name__, fields, frozen=True, slots=True)
    give_name(made, type_name(cls))
    return made


def _array_hint(layout: Layout) -> Any:
    """Return the annotation of an array that takes the place of this; None where there is none."""
    import numpy
    from numpy.typing import NDArray

    if isinstance(layout, StructLayout):
        return with_arrays(layout.cls)
    if isinstance(layout, BasicLayout):
        return NDArray[numpy.uint8] if layout.cls is bytes else None
    item = layout.item if isinstance(layout, ItemsLayout) else None
    if not isinstance(item, BasicLayout) or item.cls not in (bool, int, float):
        return None
    return NDArray[numpy.dtype(item.code).type]  # type: ignore[misc]
