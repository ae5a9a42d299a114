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


def writer_of(form: str) -> Callable[[Any], memoryview | bytes]:
    """Return a function to the octets of an array, without a copy if they lie as they are sent.

    The function takes a sequence of numbers, too. It raises TypeError for another kind of number,
    which could lose something.

    Args:
        form: Order of bytes and kind of number, ``<f``.
    """
    import numpy

    wanted, array, asarray = numpy.dtype(form), numpy.ndarray, numpy.ascontiguousarray

    def octets_of(value: Any) -> memoryview | bytes:
        if value.__class__ is not array or value.dtype != wanted or not value.flags.c_contiguous:
            value = asarray(_as_kind(numpy.asarray(value), wanted))
        return memoryview(value).cast("B") if value.size else b""

    return octets_of


def _as_kind(found: Any, wanted: Any) -> Any:
    import numpy

    if found.dtype == wanted:
        return found
    made = found.astype(wanted)
    is_rounded = found.dtype.kind == wanted.kind == "f"
    if not (is_rounded or numpy.can_cast(found.dtype, wanted) or (made == found).all()):
        raise TypeError(f"numbers of {found.dtype} are none of {wanted.name}")
    return made


def reader_of(form: str) -> Callable[[Any, int, int], Any]:
    """Return a function to a view of numbers that stand in octets; it cannot be written to.

    The function takes the octets, the number of numbers, and where they begin.
    """
    import numpy

    kind, view = numpy.dtype(form), numpy.frombuffer

    def view_of(data: Any, count: int, at: int) -> Any:
        found = view(data, kind, count, at) if count else numpy.zeros(0, kind)
        if found.flags.writeable:
            found.flags.writeable = False
        return found

    return view_of


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
