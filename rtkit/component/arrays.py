"""Arrays of numpy as fields of data types: written without a list between, read without a copy.

A field annotated ``numpy.typing.NDArray[numpy.float32]`` is a ``sequence<float>`` on every wire. An
array of any shape is written row by row; a reader gets one dimension, which it may not change:
where the value is large and comes from another process of the host, that is memory of its writer.
Only who has such a field needs numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

_KINDS = {"b": "boolean", "i": "int", "u": "uint", "f": "float"}


def name_of(number: Any) -> str:
    """Return the name of the layout of a kind of number of numpy, "" where there is none."""
    import numpy

    try:
        kind = numpy.dtype(number)
    except TypeError:
        return ""
    name = _KINDS.get(kind.kind, "")
    return name if name in ("", "boolean") else f"{name}{8 * kind.itemsize}"


def maker(code: str) -> Callable[..., Any]:
    """Return what builds an array of items, none if not given; `code` is that of `struct`."""

    def make(items: Iterable[Any] = ()) -> Any:
        import numpy

        made = numpy.array([*items], dtype=f"<{code}")
        made.flags.writeable = False
        return made

    return make


def octets_of(value: Any, form: str) -> memoryview | bytes:
    """Return the octets of an array, without a copy if they lie as they are sent.

    Args:
        value: An array, or a sequence of numbers.
        form: Order of bytes and kind of number, ``<f``.

    Raises:
        TypeError: It is of another kind of number, which could lose something.
    """
    import numpy

    found: Any = numpy.asarray(value)
    wanted = numpy.dtype(form)
    if found.dtype != wanted:
        made = found.astype(wanted)
        is_rounded = found.dtype.kind == wanted.kind == "f"
        if not (is_rounded or numpy.can_cast(found.dtype, wanted) or (made == found).all()):
            raise TypeError(f"numbers of {found.dtype} are none of {wanted.name}")
        found = made
    if not found.size:
        return b""
    octets: Any = numpy.ascontiguousarray(found).reshape(-1).view("u1")
    return memoryview(octets)


def view_of(data: Any, form: str, count: int, at: int) -> Any:
    """Return a view of numbers that stand in octets; it cannot be written to."""
    import numpy

    found = numpy.frombuffer(data, form, count, at) if count else numpy.zeros(0, form)
    found.flags.writeable = False
    return found


def is_frozen(value: Any, code: str) -> bool:
    """Return whether a value is an array of these numbers that nobody can change any more."""
    import numpy

    return (
        value.__class__ is numpy.ndarray
        and value.dtype == numpy.dtype(f"<{code}")
        and value.ndim == 1
        and not value.flags.writeable
        and (isinstance(value.base, (bytes, memoryview)) or not value.size)
    )
