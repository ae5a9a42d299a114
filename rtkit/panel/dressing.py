"""Dresses widgets with the components that services bring along, as ``<gui>`` elements."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.panel.description import Panel, dressed

Find = Callable[[str], Panel | None]
"""Returns the component of a name, None if there is none, or it is no ``<gui>``."""


def own_form(target: str, panel: Panel, form: str) -> str:
    """Return where a property has a component of its own; `target` is the property."""
    return f"{target}.gui.{form}" if panel.name else f"{target}/gui.{form}"


def words_of(panel: Panel) -> list[str]:
    """Return the types for which there may be a component, the best first."""
    words = panel.texts("type") or [panel.spec.type.name]
    return [each for each in words if each and each != "any"]


def service_of_components(panel: Panel) -> str:
    """Return the name of a GUI service that is mounted in a service, empty if there is none."""
    return next((each.name for each in panel.children if "gui" in each.texts("type")), "")


def worn(panel: Panel, service: str, own: Find, of_type: Find) -> Panel:
    """Return widgets with the components of properties, or of their types, put on.

    Args:
        panel: As the service describes them.
        service: Its name.
        own: Finds a component by its target.
        of_type: Finds that of a type; asked once for each.
    """
    known: dict[str, Panel | None] = {}

    def found(word: str) -> Panel | None:
        if word not in known:
            known[word] = of_type(word)
        return known[word]

    def one(each: Panel) -> Panel:
        made = each._replace(children=tuple(map(one, each.children)))
        target = f"{service}.{each.name}" if each.name else service
        has_own = "text" in each.texts("forms")
        component = own(own_form(target, each, "text")) if has_own else None
        for word in () if component else words_of(each):
            component = component or found(word)
        return made if component is None else dressed(made, component)

    return one(panel)
