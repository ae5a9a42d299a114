"""Reads the annotations of a data type, once, into a tree of layouts.

The codec, JSON literals and zero values all walk this tree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Annotated, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from rtkit.errors import Malformed


class BasicLayout(NamedTuple):
    """A number, a truth value, a character, a text or octets.

    Attributes:
        name: ``int32``, ``boolean``, ``wstring``; those that begin with w are UTF-16.
        code: Its format character in the struct module; empty where values differ in length.
        cls: Class of a value that was carried.
        zero: The value that is zero or empty.
    """

    name: str
    code: str
    cls: type
    zero: Any

    @property
    def bounds(self) -> tuple[int, int]:
        """The least and the greatest value of an integer."""
        bits = int(self.name.lstrip("uint"))
        return (
            (0, 2**bits - 1) if self.name[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        )


_INTEGERS = zip(("int8", "int16", "int32", "int64"), "bhiq", strict=True)
_BASICS = {
    each.name: each
    for each in (
        BasicLayout("boolean", "?", bool, False),
        BasicLayout("char", "c", str, "\0"),  # ISO 8859-1
        BasicLayout("wchar", "H", str, "\0"),
        BasicLayout("string", "", str, ""),  # UTF-8 with a closing NUL
        BasicLayout("wstring", "", str, ""),
        BasicLayout("sequence<octet>", "", bytes, b""),
        BasicLayout("float32", "f", float, 0.0),
        BasicLayout("float64", "d", float, 0.0),
        *(
            BasicLayout(f"{sign}{name}", code.upper() if sign else code, int, 0)
            for name, code in _INTEGERS
            for sign in ("", "u")
        ),
    )
}
_PLAIN = {
    bool: _BASICS["boolean"],
    int: _BASICS["int64"],
    float: _BASICS["float64"],
    str: _BASICS["string"],
    bytes: _BASICS["sequence<octet>"],
    bytearray: _BASICS["sequence<octet>"],
}
"""Layout of each class that is annotated without a width."""


class EnumLayout(NamedTuple):
    """A member of an enum, 32 bits: its value where all values are integers, else its ordinal."""

    cls: type[Enum]
    numbers: Mapping[Enum, int]
    name: str
    code: str = "i"


class ItemsLayout(NamedTuple):
    """Any number of one kind.

    Attributes:
        item: Of each of them.
        make: Builds the tuple, list or array of those that it is given.
        name: ``sequence<…>``.
        is_array: Whether they are an array of numpy, of one dimension.
    """

    item: Layout
    make: Callable[..., Any]
    name: str
    is_array: bool = False


class ArrayLayout(NamedTuple):
    """A fixed number of items, each of its own kind."""

    items: tuple[Layout, ...]
    name: str


class StructLayout(NamedTuple):
    """A dataclass."""

    cls: type
    fields: tuple[tuple[str, Layout], ...]
    name: str


Layout = BasicLayout | EnumLayout | ItemsLayout | ArrayLayout | StructLayout

_layouts: dict[type, StructLayout] = {}


def layout_of(cls: type) -> StructLayout:
    """Return the layout of a dataclass.

    Raises:
        Malformed: Names the field that cannot be carried.
    """
    known = _layouts.get(cls)
    if known is None:
        known = _layouts[cls] = _struct(cls, ())
    return known


def layout_of_hint(hint: Any, where: str) -> Layout:
    """Return the layout of an annotation; `where` is for messages.

    Raises:
        Malformed: It cannot be carried.
    """
    return _read(hint, where, ())


def _struct(cls: type, outer: tuple[type, ...]) -> StructLayout:
    if not is_dataclass(cls):
        raise Malformed(f"{cls.__name__} is not a dataclass")
    if cls in outer:
        raise Malformed(f"{cls.__name__} contains itself")
    try:
        hints = get_type_hints(cls, include_extras=True)
    except (NameError, TypeError) as error:
        raise Malformed(f"{cls.__name__}: its annotations cannot be read: {error}") from error
    members = [member for member in fields(cls) if member.init]
    if not members or len(members) != len(fields(cls)):
        raise Malformed(f"{cls.__name__} needs fields, all of them arguments of its constructor")
    inner = (*outer, cls)
    return StructLayout(
        cls,
        tuple(
            (member.name, _read(hints[member.name], f"{cls.__name__}.{member.name}", inner))
            for member in members
        ),
        cls.__name__,
    )


def _read(hint: Any, where: str, outer: tuple[type, ...]) -> Layout:
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _annotated(args, where, outer)
    if isinstance(hint, type) and hint in _PLAIN:
        return _PLAIN[hint]
    if _is_numpy(origin):
        return _numpy_array(args, where)
    if origin in (tuple, list) or origin is Sequence:
        return _collection(origin, args, where, outer)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return _enumeration(hint, where)
    if isinstance(hint, type) and is_dataclass(hint):
        if hint not in _layouts:
            _layouts[hint] = _struct(hint, outer)
        return _layouts[hint]
    reason = "is optional, which CDR has no form for" if origin is Union else f"has type {hint}"
    raise Malformed(f"{where} cannot be carried: it {reason}")


def _annotated(args: tuple[Any, ...], where: str, outer: tuple[type, ...]) -> Layout:
    base, *notes = args
    for note in notes:
        if isinstance(note, str) and note in _BASICS:
            return _BASICS[note]
    return _read(base, where, outer)


def _collection(
    origin: Any, args: tuple[Any, ...], where: str, outer: tuple[type, ...]
) -> ItemsLayout | ArrayLayout:
    if origin is tuple and args and args[-1] is not Ellipsis:
        first = _read(args[0], where, outer)
        items = tuple(first if arg == args[0] else _read(arg, where, outer) for arg in args)
        return ArrayLayout(items, f"array of {len(items)}")
    if not args:
        raise Malformed(f"{where} cannot be carried: it does not say what it is a sequence of")
    item = _read(args[0], where, outer)
    return ItemsLayout(item, list if origin is list else tuple, f"sequence<{item.name}>")


def _is_numpy(origin: Any) -> bool:
    return getattr(origin, "__module__", "") == "numpy" and origin.__name__ == "ndarray"


def _numpy_array(args: tuple[Any, ...], where: str) -> ItemsLayout:
    """Return the layout of ``numpy.typing.NDArray[numpy.float32]``."""
    from rtkit.component.values import arrays

    numbers = get_args(args[1]) if len(args) > 1 else ()
    name = arrays.name_of(numbers[0]) if numbers else ""
    if name not in _BASICS:
        raise Malformed(
            f"{where} cannot be carried: it does not say what numbers it is an array of"
        )
    item = _BASICS[name]
    sequence = "sequence<octet>" if name == "uint8" else f"sequence<{name}>"
    return ItemsLayout(item, arrays.maker(item.code), sequence, is_array=True)


def _enumeration(cls: type[Enum], where: str) -> EnumLayout:
    members = list(cls)
    if not members:
        raise Malformed(f"{where} cannot be carried: {cls.__name__} has no members")
    is_numeric = all(type(member.value) is int or isinstance(member, int) for member in members)
    numbers = {
        member: int(member.value) if is_numeric else index for index, member in enumerate(members)
    }
    if not all(-(2**31) <= number < 2**31 for number in numbers.values()):
        raise Malformed(f"{where} cannot be carried: {cls.__name__} exceeds 32 bits")
    return EnumLayout(cls, numbers, cls.__name__)


def zero(layout: Layout) -> Any:
    """Return the value with every number 0, every text and sequence empty."""
    if isinstance(layout, StructLayout):
        return layout.cls(**{name: zero(item) for name, item in layout.fields})
    if isinstance(layout, ArrayLayout):
        return tuple(zero(item) for item in layout.items)
    if isinstance(layout, ItemsLayout):
        return layout.make()
    return next(iter(layout.cls)) if isinstance(layout, EnumLayout) else layout.zero


def as_items(value: Any) -> Sequence[Any]:
    """Return the items of a sequence or an array of one dimension or more.

    Raises:
        TypeError: It is neither; a text, a set and a mapping are neither.
    """
    listed = getattr(value, "tolist", None)
    items = value if listed is None else listed()
    if isinstance(items, Sequence) and not isinstance(items, str):
        return items
    raise TypeError(f"{type(value).__name__} is no sequence")


def as_octets(value: Any) -> bytes:
    """Return the bytes of a container of octets: bytes, a bytearray, an array of ``uint8``.

    Raises:
        TypeError: It holds none, or numbers of another width.
    """
    if value.__class__ is bytes:
        return bytes(value)
    view = memoryview(value)
    if view.format.lstrip("@=<>!") not in ("B", "c"):
        raise TypeError(f"{type(value).__name__} holds no octets")
    return view.tobytes()


def as_truth(value: Any) -> bool:
    """Return a truth value; 0 and 1 are some.

    Raises:
        ValueError: It is none.
    """
    if value is True or value is False:
        return bool(value)
    if value in (0, 1):
        return bool(value)
    raise ValueError("no truth value")


def complaint(layout: Layout, value: Any, where: str) -> str:
    """Return the reason why `value` cannot be carried, naming the field; "" when it can."""
    if isinstance(layout, StructLayout):
        for name, item in layout.fields:
            if not hasattr(value, name):
                return f"{where}: {type(value).__name__} has no field {name}"
            found = complaint(item, getattr(value, name), f"{where}.{name}")
            if found:
                return found
        return ""
    if isinstance(layout, (ItemsLayout, ArrayLayout)):
        return _complaint_of_items(layout, value, where)
    if _is_carried(layout, value):
        return ""
    return f"{where}: {_short(value)} is not a value of type {layout.name}"


def _complaint_of_items(layout: ItemsLayout | ArrayLayout, value: Any, where: str) -> str:
    wrong = f"{where}: {_short(value)} is not a value of type {layout.name}"
    try:
        found = as_items(value)
    except TypeError:
        return wrong
    if isinstance(layout, ArrayLayout):
        if len(found) != len(layout.items):
            return f"{where}: {len(found)} items, wanted {len(layout.items)}"
        items = layout.items
    else:
        items = (layout.item,) * len(found)
    for index, (item, one) in enumerate(zip(items, found, strict=False)):
        misfit = complaint(item, one, f"{where}[{index}]")
        if misfit:
            return wrong if hasattr(value, "dtype") else misfit
    return ""


def _is_carried(layout: BasicLayout | EnumLayout, value: Any) -> bool:
    if isinstance(layout, EnumLayout):
        return isinstance(value, layout.cls)
    if layout.cls in (int, float):
        return _fits(layout, value)
    if layout.cls is not str:
        return _can_be(as_truth if layout.cls is bool else as_octets, value)
    if not isinstance(value, str):
        return False
    is_wide = layout.name[0] == "w"
    if layout.code:
        return len(value) == 1 and _is_unit(ord(value), is_wide)
    is_whole = not any("\ud800" <= char <= "\udfff" for char in value)
    return is_whole and (is_wide or "\0" not in value)


def _can_be(read: Callable[[Any], object], value: Any) -> bool:
    try:
        read(value)
    except (TypeError, ValueError):
        return False
    return True


def _fits(layout: BasicLayout, value: Any) -> bool:
    try:
        if layout.cls is float:
            number = float(value)
            largest = 3.4028235677973366e38
            is_small = abs(number) < largest or number in (float("inf"), float("-inf"))
            return not isinstance(value, str) and (layout.code == "d" or is_small or value != value)
        number = value.__index__()
    except (TypeError, ValueError, OverflowError, AttributeError):
        return False
    low, high = layout.bounds
    return bool(low <= number <= high)


def _is_unit(number: int, is_wide: bool) -> bool:
    return number < 0x100 or (is_wide and number < 0x10000 and not 0xD800 <= number < 0xE000)


def _short(value: Any) -> str:
    if hasattr(value, "dtype") and hasattr(value, "shape"):
        return f"array of {value.dtype} and shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 60 else text[:59] + "…"
