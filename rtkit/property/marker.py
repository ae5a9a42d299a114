"""Markers: places with what is known of them, as robots and sensors tell them to each other.

Source: `property-service` reference, section 3.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Generic, TypeVar, overload

from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.types import check, parse_type
from rtkit.property.values import Element, Value, Word, is_number, is_vector
from rtkit.property.writing import worded, write

T = TypeVar("T")
Vector = tuple[float, ...]
_KIND = parse_type("marker")


class _Child(Generic[T]):
    """Child of the element of a marker, as an attribute that is only read."""

    def __init__(self, read: Callable[[Value], T], absent: T) -> None:
        self.read = read
        self._absent = absent

    def __set_name__(self, owner: object, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, marker: None, owner: object = None) -> _Child[T]: ...
    @overload
    def __get__(self, marker: Marker, owner: object = None) -> T: ...
    def __get__(self, marker: Marker | None, owner: object = None) -> T | _Child[T]:
        if marker is None:
            return self
        child = marker.element.find(self._name)
        return self._absent if child is None else self.read(_leaf(child))

    def __set__(self, marker: Marker, value: object) -> None:
        raise AttributeError(f"markers are not changed: take with_({self._name}=…)")


def _leaf(child: Element) -> Value:
    return child if child.children else "" if child.leaf is None else child.leaf


def _text(value: Value) -> str:
    return str(value) if isinstance(value, str) else write(value)


def _number(value: Value) -> float:
    if not is_number(value):
        raise PropertyError("bad-value", f"expected a number, found {write(value)[:60]}")
    return float(value)  # type: ignore[arg-type]


def _numbers(value: Value) -> Vector:
    if not is_vector(value):
        raise PropertyError("bad-value", f"expected numbers, found {write(value)[:60]}")
    return tuple(map(float, value))  # type: ignore[arg-type]


def _size(value: Value) -> float | Vector:
    return _numbers(value) if isinstance(value, tuple) else _number(value)


def _rows(value: Value) -> tuple[Vector, ...]:
    rows = tuple(map(_numbers, value)) if isinstance(value, tuple) else ()
    if not rows or any(len(row) != len(rows) for row in rows):
        raise PropertyError("bad-value", f"expected rows of a square, found {write(value)[:60]}")
    return rows


def _plain(value: Value) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return str(value) if isinstance(value, Word) else value


class Marker:
    """Place of something, in a frame, with what is known of it; it is never changed.

    ``Marker((1.0, 2.0, 0.0), type="ball", frame="world", color=(1, 0, 0))``. As an annotation of
    what is served (``Marker``, ``list[Marker]``, ``Marker | None``) it is the type ``marker``.

    Args:
        location: 2 or 3 coordinates, or a pose ``x y z a b c`` [m, rad]; None for a marker that
            has a feature ``polar`` or ``region`` instead.
        frame: To which the location belongs; empty: the sender's own base.
        id: Of this one thing.
        name: For people.
        type: Kind of thing.
        time: When it was seen [s since 1970].
        confidence: How sure it is that it is there, 0 to 1.
        variance: Of each coordinate [square of the unit of the location].
        covariance: Rows of it, in place of the variance.
        size: Diameter, or the extent along each axis [m].
        source: Name of the observer.
        **features: Further features: numbers, texts, sequences of them, elements.

    Raises:
        PropertyError: ``bad-value``: it is no marker; the message names the part.
    """

    __slots__ = ("_element",)

    location = _Child[Vector | None](_numbers, None)
    frame = _Child(_text, "")
    id = _Child(_text, "")
    name = _Child(_text, "")
    type = _Child(_text, "")
    time = _Child[float | None](_number, None)
    confidence = _Child[float | None](_number, None)
    variance = _Child[float | None](_number, None)
    covariance = _Child[tuple[Vector, ...] | None](_rows, None)
    size = _Child[float | Vector | None](_size, None)
    source = _Child(_text, "")

    def __init__(
        self,
        location: Any,
        *,
        frame: str = "",
        id: str = "",
        name: str = "",
        type: str = "",
        time: float | None = None,
        confidence: float | None = None,
        variance: float | None = None,
        covariance: Any = None,
        size: Any = None,
        source: str = "",
        **features: Any,
    ) -> None:
        known = {"location": location, "id": id, "name": name, "type": type, "frame": frame,
                 "time": time, "confidence": confidence, "variance": variance,
                 "covariance": covariance, "size": size, "source": source}  # fmt: skip
        self._element = _checked(_changed(Element("marker"), known | features))

    @classmethod
    def from_element(cls, element: Element) -> Marker:
        """Return the marker that an element describes; nothing of the element is lost.

        Raises:
            PropertyError: ``bad-value``: it is no marker.
        """
        made = cls.__new__(cls)
        object.__setattr__(made, "_element", _checked(element))
        return made

    @property
    def element(self) -> Element:
        """The ``<marker>`` that travels."""
        return self._element

    def __element__(self) -> Element:
        return self._element

    @property
    def features(self) -> Mapping[str, Any]:
        """Further children, by name; of a name that is there more than once all values."""
        found: dict[str, list[Any]] = {}
        for child in self._element.children:
            if child.name not in _KNOWN:
                is_value = not child.children and not child.attributes
                found.setdefault(child.name, []).append(_plain(_leaf(child)) if is_value else child)
        values = {name: each[0] if len(each) == 1 else tuple(each) for name, each in found.items()}
        return MappingProxyType(values)

    def with_(self, **changes: Any) -> Marker:
        """Return a marker that differs in some parts or features; None or "" leaves one out.

        Raises:
            PropertyError: ``bad-value``: that is no marker.
        """
        for one, other in (("variance", "covariance"), ("covariance", "variance")):
            if changes.get(one) is not None:
                changes.setdefault(other, None)
        return type(self).from_element(_changed(self._element, changes))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Marker) and self._element == other._element

    def __hash__(self) -> int:
        return hash(self._element)

    def __reduce__(self) -> Any:
        return type(self).from_element, (self._element,)

    def __str__(self) -> str:
        return write(self._element)

    def __repr__(self) -> str:
        shown = {name: getattr(self, name) for name in _KNOWN} | dict(self.features)
        location = shown.pop("location")
        parts = [f"{name}={each!r}" for name, each in shown.items() if each not in (None, "")]
        return f"Marker({', '.join([repr(location), *parts])})"


_KNOWN: dict[str, _Child[Any]] = {
    name: each for name, each in vars(Marker).items() if isinstance(each, _Child)
}


def _changed(element: Element, changes: Mapping[str, Any]) -> Element:
    """Return an element with some children put in place of others, at the end, or left out."""
    children = {name: _child(name, each) for name, each in changes.items()}
    kept: list[Element] = []
    for child in element.children:
        if child.name not in changes:
            kept.append(child)
        elif (new := children.pop(child.name, None)) is not None:
            kept.append(new)
    kept += [each for each in children.values() if each is not None]
    return Element(element.name, element.attributes, tuple(kept))


def _child(name: str, given: Any) -> Element | None:
    if given is None or (name in _KNOWN and isinstance(given, str) and not given):
        return None
    value = to_value(given)
    if isinstance(value, bytes):
        raise PropertyError("bad-value", f"{name}: bytes are no part of a marker")
    if name in _KNOWN:
        value = _read(name, value)
    if isinstance(value, Element):
        return value if value.name == name else Element(name, {}, (value,))
    return Element(name, {}, (), worded(value))


def _read(name: str, value: Value) -> Any:
    try:
        return _KNOWN[name].read(value)
    except PropertyError as error:
        raise PropertyError("bad-value", f"{name}: {error}") from None


def _checked(element: Element) -> Element:
    check(_KIND, element)
    for name in _KNOWN:
        child = element.find(name)
        if child is not None:
            _read(name, _leaf(child))
    location, covariance = element.find("location"), element.find("covariance")
    if covariance is not None:
        if element.find("variance") is not None:
            raise PropertyError("bad-value", "expected variance or covariance, found both")
        if location is not None and len(location.leaf) != len(covariance.leaf):  # type: ignore[arg-type]
            raise PropertyError("bad-value", "covariance: expected as many rows as coordinates")
    return element
