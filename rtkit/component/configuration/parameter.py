"""Configuration parameters: the descriptor that authors declare on a component class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, cast, overload

from rtkit.component.configuration.kinds import Value, kind_of
from rtkit.errors import Malformed
from rtkit.rtc.names import check_set_name

if TYPE_CHECKING:
    from rtkit.component.configuration.config import Configuration

T = TypeVar("T")


class Configured(Protocol):
    """An owner of configuration sets that hold the values of its parameters."""

    configuration: Configuration


class Parameter(Generic[T]):
    """A configuration parameter, declared on a component class with its default value.

    On an instance it reads as the value in force: bool, int, float, str or a tuple of numbers.
    It is changed through configuration sets only.

    Attributes:
        default: Value while no set says otherwise, or when the text cannot be converted.
        unit: Unit of the value, for documentation.
        doc: One line for users.
        constraint: Range in the words of RTC profiles, ``0<=x<=100`` or ``(a,b,c)``.
        widget: How editors show it: ``text slider.0.1 spin radio checkbox``.
        sets: Text of its value in further configuration sets, by name of the set.

    Raises:
        Malformed: A value is none of a parameter, or breaks the constraint in a further set.
    """

    def __init__(
        self,
        default: T,
        *,
        unit: str = "",
        doc: str = "",
        constraint: str = "",
        widget: str = "",
        name: str = "",
        sets: Mapping[str, T] | None = None,
    ) -> None:
        self.default: T = cast(T, tuple(default) if isinstance(default, list) else default)
        self.unit = unit
        self.doc = doc
        self.constraint = constraint
        self.widget = widget
        self.name = name
        kind_of(cast(Value, self.default))
        self.sets = {name: self._text(name, value) for name, value in (sets or {}).items()}

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = self.name or name.rstrip("_")

    def _text(self, set_id: str, value: object) -> str:
        """Return the text of a value in a further set, as if it had been set there."""
        from rtkit.component.configuration.constraint_check import (
            Declared,
            misfit_of,
            read_constraint,
        )

        check_set_name(set_id)
        kind = kind_of(cast(Value, self.default))
        plain = cast(Value, tuple(value) if isinstance(value, list) else value)
        text = kind_of(plain).write(plain)
        rule = Declared(kind.name, self.constraint, read_constraint(self.constraint))
        why = misfit_of(rule, text)
        if why:
            label = f"{self.name} " if self.name else ""
            raise Malformed(f"parameter {label}cannot be {text!r} in set {set_id}: {why}")
        return kind.write(kind.read(text))

    @property
    def description(self) -> str:
        """The documentation with its unit."""
        return f"{self.doc} [{self.unit}]".strip() if self.unit else self.doc

    @overload
    def __get__(self, component: None, owner: type) -> Parameter[T]: ...

    @overload
    def __get__(self, component: Configured, owner: type) -> T: ...

    def __get__(self, component: Configured | None, owner: type) -> Parameter[T] | T:
        if component is None:
            return self
        return cast(T, component.configuration.values[self.name])

    def __set__(self, component: Configured, value: T) -> None:
        raise AttributeError(
            f"{self.name} is a configuration parameter: change it in a configuration set"
        )


def declared_parameters(cls: type) -> dict[str, Parameter[Any]]:
    """Return the parameters that a component class and its bases declare, by attribute."""
    found = {name: value for base in reversed(cls.__mro__) for name, value in vars(base).items()}
    return {name: value for name, value in found.items() if isinstance(value, Parameter)}
