"""Declaration of a property: type, access, unit, range, choices, alarms, parameters, GUI."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from rtkit.fast_dataclass import dataclass, field
from rtkit.property.codes import PropertyError
from rtkit.property.types import Content, Type, check, parse_type
from rtkit.property.values import Value, Word, is_number, is_vector
from rtkit.property.writing import write


class RequestParameter(NamedTuple):
    """Key that may follow the question mark, or an argument of a functional property.

    Attributes:
        spec: Range and widget, where they are declared.
    """

    key: str
    type: Type
    default: Value | None = None
    choices: tuple[Value, ...] = ()
    doc: str = ""
    spec: PropertySpec | None = None

    def described(self) -> Value:
        """Return it as ``.parameters`` shows it: ``(key type default choices doc)``."""
        default: Value = () if self.default is None else self.default
        return (Word(self.key), Word(self.type.name), default, self.choices, self.doc)

    def choose(self, value: Value) -> None:
        """Raise `PropertyError` unless it has no choices, or the value is one of them."""
        if self.choices and value not in self.choices:
            there = " ".join(map(write, self.choices))
            raise PropertyError("bad-value", f"{write(value)} is no choice (there is {there})")


Bounds = tuple[float, float]
_ANY = parse_type("any")


@dataclass(frozen=True, slots=True)
class PropertySpec:
    """Declaration of a property; many properties may share one.

    Attributes:
        access: ``r``, ``w`` or ``rw``.
        unit: Of each number, as the field writes it: ``m/s``.
        minimum: Smallest number allowed, in a vector for each of them.
        maximum: Largest number allowed.
        step: Step of a slider; not checked.
        choices: The only values allowed, all when empty.
        warn: Numbers outside of these deserve a look.
        alarm: Numbers outside of these are wrong.
        labels: Names of the parts of a vector, where they are not the usual ones.
        parameters: Parameters allowed behind the question mark; arguments of a functional property.
        gui: Code of a component by kind of client (``text``, ``html``, ``json`` …).
        widget: Attributes of its ``<gui>`` that are declared; ``kind`` stands for the usual one.
    """

    type: Type = _ANY
    access: str = "rw"
    unit: str = ""
    minimum: float | None = None
    maximum: float | None = None
    step: float | None = None
    choices: tuple[Value, ...] = ()
    warn: Bounds | None = None
    alarm: Bounds | None = None
    doc: str = ""
    labels: tuple[str, ...] = ()
    parameters: tuple[RequestParameter, ...] = ()
    gui: Mapping[str, str] = field(default_factory=dict)
    widget: Mapping[str, str] = field(default_factory=dict)
    is_functional: bool = False

    def admit(self, value: Content) -> Content:
        """Return a value that may be set.

        Raises:
            PropertyError: ``bad-value``: of another type, outside of the range, no choice.
        """
        return self.within(check(self.type, value))

    def within(self, value: Content) -> Content:
        """Return a value of the right type if it may be set.

        Raises:
            PropertyError: ``bad-value``: outside of the range, no choice.
        """
        if self.minimum is not None or self.maximum is not None:
            for number in _numbers(value):
                self._check_range(number)
        if self.choices and not isinstance(value, bytes) and value not in self.choices:
            listed = " ".join(map(write, self.choices))
            raise PropertyError("bad-value", f"expected one of {listed}, found {write(value)}")
        return value

    def _check_range(self, number: float) -> None:
        low, high = self.minimum, self.maximum
        if number != number:
            raise PropertyError("bad-value", "nan is in no range")
        if low is not None and number < low:
            raise PropertyError("bad-value", f"{write(number)} is below {write(low)}")
        if high is not None and number > high:
            raise PropertyError("bad-value", f"{write(number)} is above {write(high)}")

    def severity(self, value: Content | None) -> str:
        """Return ``none``, ``warn`` or ``alarm``, for the worst of the numbers of a value."""
        for word, bounds in (("alarm", self.alarm), ("warn", self.warn)):
            if bounds and any(not bounds[0] <= each <= bounds[1] for each in _numbers(value)):
                return word
        return "none"


def _numbers(value: Content | None) -> tuple[float, ...]:
    if is_number(value):
        return (value,)  # type: ignore[return-value]
    return value if is_vector(value) else ()  # type: ignore[return-value]


EMPTY_PLACE = PropertySpec(parse_type("list"), "r")
"""Declaration of a place below which there is nothing just now."""
_SHARED: dict[str, PropertySpec] = {}


def plain(type_name: str) -> PropertySpec:
    """Return what is declared of a property of which only the type is."""
    if type_name not in _SHARED:
        _SHARED[type_name] = PropertySpec(parse_type(type_name))
    return _SHARED[type_name]


Reader = Callable[[dict[str, Value]], object]
"""Returns the present value; gets the declared parameters that were given."""
Writer = Callable[[Content, dict[str, Value]], Content | None]
"""Puts a value in force; returns it if it is another than the one that was asked for."""
