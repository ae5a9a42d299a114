"""Annotations of how properties are presented: choices known only at run time, widgets."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rtkit.property.codes import PropertyError
from rtkit.property.conversion import to_value
from rtkit.property.property_spec import PropertySpec
from rtkit.property.values import Value
from rtkit.property.writing import write


class Choices:
    """The only values of a property: ``Annotated[str, Choices("modes")]``.

    Args:
        given: The values; or a function that returns them, given the object that has the property;
            or the name of an attribute or a method of that object. The latter are asked anew at
            each SET and each time somebody looks.
        code: Of the error of an action whose argument is none of what a function or name tells.
    """

    def __init__(
        self,
        given: str | Iterable[object] | Callable[[Any], Iterable[object]],
        *,
        code: str = "bad-value",
    ) -> None:
        self._given, self._code = given, code
        self.is_fixed = not (isinstance(given, str) or callable(given))

    def of(self, holder: object = None) -> tuple[Value, ...]:
        """Return the values for the property of an object; anything that its code raises."""
        given = self._given
        if isinstance(given, str):
            named = getattr(holder, given)
            found = named() if callable(named) else named
        else:
            found = given(holder) if callable(given) else given
        return tuple(to_value(each) for each in found)  # type: ignore[misc]

    def check(self, holder: object, value: object) -> None:
        """Refuse what is no choice.

        Raises:
            PropertyError: Of its code.
        """
        choices = self.of(holder)
        texts = [str(each) if isinstance(each, str) else each for each in choices]
        if (str(value) if isinstance(value, str) else value) not in texts:
            listed = " ".join(map(write, choices)) or "nothing just now"
            raise PropertyError(self._code, f"expected one of {listed}")


class Gui:
    """Widget of a property: ``Annotated[float, Gui("knob")]``.

    For a property ``speed``, a method ``gui_speed`` that is declared to return one (``-> Gui``)
    tells it anew at each look, and a method or attribute ``gui`` tells it of the object itself.

    Args:
        kind: Of widget, in place of the usual one for the type: ``knob``, ``image``, ``plot`` …
        html: Code of a component for browsers, the value of ``NAME.gui.html``.
        text: For terminals, the value of ``NAME.gui.text``.
        forms: For further kinds of clients, by name.
        **attributes: Further attributes of ``NAME.gui``.
    """

    def __init__(
        self,
        kind: str = "",
        *,
        html: str = "",
        text: str = "",
        forms: Mapping[str, str] | None = None,
        **attributes: Any,
    ) -> None:
        given = {"kind": kind} | {
            key: each if isinstance(each, str) else write(to_value(each))  # type: ignore[arg-type]
            for key, each in attributes.items()
        }
        self.attributes = {key: each for key, each in given.items() if each}
        every = {"html": html, "text": text, **(forms or {})}
        self.forms: dict[str, str] = {key: each for key, each in every.items() if each}

    def declared(self) -> dict[str, Any]:
        """Return it as fields of a `PropertySpec`."""
        return {"widget": self.attributes, "gui": self.forms}


def is_presentation(name: str) -> bool:
    """Return whether a member may be the widget of another, or of the object."""
    return name == "gui" or name.startswith("gui_")


def presented(holder: Callable[[], Any], name: str) -> Gui:
    """Return the widget that a member of an object is or returns now.

    Raises:
        PropertyError: ``internal``: it is none.
    """
    found = getattr(holder(), name)
    found = found() if callable(found) else found
    if not isinstance(found, Gui):
        raise PropertyError("internal", f"{name} gives no rtkit.Gui")
    return found


EMPTY = PropertySpec(access="r")
"""Declaration of a place that has no value."""
