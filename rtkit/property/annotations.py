"""Reads type, unit, range and choices of properties from the annotations of a class.

``speed: Annotated[float, Unit("m/s"), Range(-1, 1)]``. A bare text is a unit too; what has ``ge``,
``gt``, ``le``, ``lt`` (the package annotated-types) is a range.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import is_dataclass
from enum import Enum
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar, get_args, get_origin

from rtkit.property.conversion import has_element, to_value
from rtkit.property.presenting import Choices, Gui
from rtkit.property.property_spec import PropertySpec
from rtkit.property.types import Type, parse_type
from rtkit.property.values import Element, Value, Word, is_number

T = TypeVar("T")


class Unit(NamedTuple):
    """Unit of a number: ``Annotated[float, Unit("m/s")]``."""

    unit: str


class Range(NamedTuple):
    """Bounds of a number, and the step of its slider."""

    minimum: float | None = None
    maximum: float | None = None
    step: float | None = None


class Returns(NamedTuple):
    """A value that was set returns by itself: ``Annotated[Velocity, Returns(after=0.5)]``.

    ``NAME.timeout`` tells how long it stays, and can be set.

    Attributes:
        after: How long after the last SET [s].
        to: The value it returns to; None for the one that it has before it is set first.
    """

    after: float = 0.5
    to: Any = None


class Concurrent(NamedTuple):
    """Several requests may read a value at once, each on a thread of its own.

    For a getter that waits for others: ``def get_best(self) -> Annotated[str, Concurrent()]``.
    Else those of one property wait for each other.
    """


Text = typing.NewType("Text", str)
"""Text that is no value: as it is, without quotes (``text``)."""

_BASES = {bool: "boolean", int: "integer", float: "number", str: "string", bytes: "bytes"}
_BASES[Text] = "text"
_OPEN = {bool: "boolean", int: "number", float: "number", str: "string", bytes: "bytes"}


def hints_of(cls: type) -> dict[str, Any]:
    """Return the annotations of a class and of ``self.x: …`` in its ``__init__``.

    There are none of a class where one names what cannot be found.
    """
    found: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        init = vars(base).get("__init__")
        found |= _of_init(init) if isinstance(init, types.FunctionType) else {}
    return found | hints_of_function(cls)


@lru_cache(256)
def _of_init(init: types.FunctionType) -> dict[str, Any]:
    """Return the annotations of attributes in a function, which only its source has."""
    import ast
    import inspect
    import textwrap

    try:
        tree = ast.parse(textwrap.dedent(inspect.getsource(init)))
    except (OSError, TypeError, SyntaxError):
        return {}  # its source is not there
    own = init.__code__.co_varnames[:1]
    found: dict[str, Any] = {}
    for node in ast.walk(tree):
        if not (isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Attribute)):
            continue
        of = node.target.value
        if isinstance(of, ast.Name) and (of.id,) == own:
            text = ast.unparse(node.annotation)
            with suppress(NameError, TypeError, AttributeError, SyntaxError):
                found[node.target.attr] = _evaluated(text, init)
    return found


def _evaluated(annotation: str, function: types.FunctionType) -> Any:
    """Return what an annotation names where a function stands."""
    holder = type("Holder", (), {"__annotations__": {"it": annotation}})
    return typing.get_type_hints(holder, function.__globals__, include_extras=True)["it"]


def hints_of_function(function: object) -> dict[str, Any]:
    """Return the annotations of a function; none where one names what cannot be found."""
    try:
        return typing.get_type_hints(function, include_extras=True)
    except (NameError, TypeError, AttributeError):
        return {}


def returned(function: object) -> Any:
    """Return the annotation of what a function returns, None if it has none."""
    return hints_of_function(function).get("return")


def taken(function: object) -> Any:
    """Return the annotation of the only argument of a function, None if it has none."""
    hints = hints_of_function(function)
    return next((hint for name, hint in hints.items() if name != "return"), None)


def is_final(hint: Any) -> bool:
    """Return whether an annotation says that the attribute is not to be changed."""
    return hint is typing.Final or get_origin(hint) is typing.Final


def bare(hint: Any) -> Any:
    """Return an annotation without its metadata and qualifiers."""
    while get_origin(hint) in (typing.Annotated, typing.Final, typing.ClassVar):
        hint = get_args(hint)[0]
    return None if hint in (typing.Final, typing.ClassVar, typing.Any) else hint


def spec_of(hint: Any, present: object, access: str, doc: str) -> PropertySpec:
    """Return what is declared of a property by its annotation, else by its present value."""
    bounds, unit = _range_and_unit(hint)
    plain = bare(hint)
    if plain is None and isinstance(present, Enum):
        plain = type(present)
    kind = type_of(plain) if plain is not None else _type_of_value(present)
    gui, chosen = extra_of(hint, Gui), extra_of(hint, Choices)
    choices = chosen.of() if chosen is not None and chosen.is_fixed else choices_of(plain)
    return PropertySpec(
        kind, access, unit, bounds.minimum, bounds.maximum, bounds.step, choices, doc=doc,
        **({} if gui is None else gui.declared()),
    )  # fmt: skip


def choices_of(hint: Any) -> tuple[Value, ...]:
    """Return the only values that an annotation allows, none for all."""
    if isinstance(hint, type) and issubclass(hint, Enum):
        return tuple(Word(member.name) for member in hint)
    if get_origin(hint) is typing.Literal:
        return tuple(_choice(each) for each in get_args(hint))
    return ()


def _choice(value: object) -> Value:
    converted = to_value(value)
    assert not isinstance(converted, bytes)
    return converted


def type_of(hint: Any) -> Type:
    """Return the declared type for an annotation; ``any`` for what is not known."""
    if hint in _BASES:
        return parse_type(_BASES[hint])
    if isinstance(hint, type):
        if issubclass(hint, Enum | Word):
            return parse_type("word")
        if issubclass(hint, Element) or has_element(hint) or is_dataclass(hint):
            name = hint.__name__.lower()
            return parse_type("marker" if name == "marker" else "element")
    origin = get_origin(hint)
    if origin is typing.Literal and all(isinstance(each, str) for each in get_args(hint)):
        return parse_type("string")
    items = _items(hint, origin)
    if items is None:
        return parse_type("any")
    is_numeric = bool(items) and all(bare(each) in (int, float) for each in items)
    is_sized = origin is tuple and get_args(hint)[-1] is not Ellipsis
    if not is_numeric:
        item = type_of(bare(items[0])) if len(items) == 1 and not is_sized else None
        is_typed = item is not None and item.base not in ("any", "bytes")
        return parse_type(f"list<{item.name}>" if item is not None and is_typed else "list")
    return parse_type(f"vector[{len(items)}]" if is_sized else "vector")


def _items(hint: Any, origin: Any) -> tuple[Any, ...] | None:
    """Return the annotations of what a sequence holds, None if it is no sequence."""
    kind = origin or hint
    if not isinstance(kind, type) or kind in (types.UnionType, str, bytes, bytearray):
        return None
    if not issubclass(kind, Sequence | set | frozenset) or issubclass(kind, Mapping):
        return None
    return tuple(each for each in get_args(hint) if each is not Ellipsis)


def _type_of_value(present: object) -> Type:
    if type(present) in _OPEN:
        return parse_type(_OPEN[type(present)])
    if isinstance(present, bool):
        return parse_type("boolean")
    if isinstance(present, list | tuple) and present:
        is_numeric = all(is_number(each) for each in present)
        return parse_type("vector" if is_numeric else "list")
    return (
        type_of(type(present))
        if isinstance(present, Word | Element) or (has_element(present))
        else parse_type("any")
    )


def _extras(hint: Any) -> tuple[Any, ...]:
    while get_origin(hint) in (typing.Final, typing.ClassVar):
        hint = get_args(hint)[0]
    return hint.__metadata__ if get_origin(hint) is typing.Annotated else ()


def extra_of(hint: Any, kind: type[T]) -> T | None:
    """Return what of a kind stands beside an annotation, None if nothing does."""
    return next((each for each in _extras(hint) if isinstance(each, kind)), None)


def _range_and_unit(hint: Any) -> tuple[Range, str]:
    """Return range and unit that stand beside an annotation."""
    bounds, unit = Range(), ""
    for extra in _extras(hint):
        if isinstance(extra, Range):
            bounds = extra
        elif isinstance(extra, str):
            unit = extra
        elif isinstance(getattr(extra, "unit", None), str):
            unit = extra.unit
        else:
            low = getattr(extra, "ge", getattr(extra, "gt", None))
            high = getattr(extra, "le", getattr(extra, "lt", None))
            bounds = Range(
                low if isinstance(low, int | float) else bounds.minimum,
                high if isinstance(high, int | float) else bounds.maximum,
                bounds.step,
            )
    return bounds, unit
