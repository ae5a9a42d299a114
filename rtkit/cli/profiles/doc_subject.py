"""Builds the page about a component from its own data: its hidden set ``__doc__``, its ports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rtkit.drawing.component import InterfaceSymbol, Pin, component_svg
from rtkit.drawing.dot import dot_lines
from rtkit.drawing.scene import IN, LEFT, OUT, RIGHT, SERVICE, Box, PortPin, Scene
from rtkit.profile_tools.page import Page, PageTable, Section, present, section
from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.profiles import PortProfile, TypeProfile

DOC_SET = "__doc__"
_DESCRIPTION_SET = "__description__"
_ORDER = "__order__"
_PORTS, _CONFIG = "ports", "config"
_TITLES = {
    "intro": "Introduction",
    "reqs": "Pre-requisites",
    "install": "Installation",
    "usage": "Usage",
    _PORTS: "Ports",
    _CONFIG: "Configuration parameters",
    "misc": "Miscellaneous",
    "changelog": "Changelog",
}
_FIELDS = (("License", "__license__"), ("Contact", "__contact__"), ("URL", "__url__"))


class DocumentedComponent(NamedTuple):
    """A component, live or made of a module only to be described.

    Attributes:
        sets: Its configuration sets, hidden ones too.
        more: Sections from its RTC profile, for one that says nothing itself.
    """

    type: TypeProfile
    ports: Sequence[PortProfile]
    sets: Mapping[str, Mapping[str, str]]
    more: tuple[Section, ...] = ()

    @property
    def has_documentation(self) -> bool:
        """Return whether it documents itself."""
        return bool(self.sets.get(DOC_SET))


class Made(NamedTuple):
    """A page, and warnings about the documentation that it is made of."""

    page: Page
    warnings: tuple[str, ...]


def page_of(subject: DocumentedComponent, *, has_picture: bool) -> Made:
    """Return the page about a component, its sections in the order that it asks for."""
    doc = subject.sets.get(DOC_SET, {})
    sections = _sections(subject, doc)
    order, warnings = _order(doc.get(_ORDER, ""), sections)
    name = subject.type.type_name
    pins = list(map(_pin, subject.ports))
    facts = [
        ("Vendor", subject.type.vendor),
        ("Version", subject.type.version),
        ("Category", subject.type.category),
        *((title, doc.get(key, "")) for title, key in _FIELDS),
    ]
    picture = component_svg(name, pins) if has_picture and pins else ""
    shown = (*(sections[key] for key in order), *subject.more)
    page = Page(
        name, subject.type.description, present(facts), picture, f"The ports of {name}", shown
    )
    return Made(page, tuple(warnings))


def dot_of(subject: DocumentedComponent) -> str:
    """Return the component alone as a graph for Graphviz."""
    ports = tuple(_pin(port).port for port in subject.ports)
    box = Box(subject.type.type_name, "", ports, "")
    return "\n".join(dot_lines(Scene((box,), ()), "component"))


def _sections(subject: DocumentedComponent, doc: Mapping[str, str]) -> dict[str, Section]:
    named = {key: text for key, text in doc.items() if not key.startswith("__")}
    made = {key: section(_TITLES.get(key, key), [text]) for key, text in named.items()}
    made[_PORTS] = _ports(subject.ports)
    made[_CONFIG] = _parameters(subject.sets)
    return {key: each for key, each in made.items() if each is not None}


def _ports(ports: Iterable[PortProfile]) -> Section | None:
    heads = ("Name", "Type", "DataType", "Description")
    rows = tuple(
        (
            port.name,
            port.port_type.value,
            port.data_type or ", ".join(each.type_name for each in port.interfaces),
            port.properties.get("description", ""),
        )
        for port in ports
    )
    return section(_TITLES[_PORTS], table=PageTable(heads, rows))


def _parameters(sets: Mapping[str, Mapping[str, str]]) -> Section | None:
    descriptions = sets.get(_DESCRIPTION_SET, {})
    rows = tuple(
        (name, value, descriptions.get(name, "")) for name, value in sets.get("default", {}).items()
    )
    return section(_TITLES[_CONFIG], table=PageTable(("Name", "Value", "Description"), rows))


def _order(text: str, there: Iterable[str]) -> tuple[list[str], list[str]]:
    """Return the keys of the sections in order, and warnings about names that are none."""
    known = list(there)
    wanted = [each.strip() for each in text.split(",") if each.strip()]
    warnings = [f"{_ORDER} names no section: {key}" for key in wanted if key not in known]
    usual = [*(key for key in _TITLES if key in known), *(k for k in known if k not in _TITLES)]
    first = [key for key in dict.fromkeys(wanted) if key in known]
    return [*first, *(key for key in usual if key not in first)], warnings


def _pin(port: PortProfile) -> Pin:
    if port.port_type is PortType.SERVICE:
        return Pin(PortPin(port.name, LEFT, SERVICE, ""), "", tuple(_interfaces(port)))
    kind, side = (OUT, RIGHT) if port.port_type is PortType.OUT else (IN, LEFT)
    return Pin(PortPin(port.name, side, kind, port.data_type), port.data_type)


def _interfaces(port: PortProfile) -> Iterator[InterfaceSymbol]:
    for each in port.interfaces:
        is_provided = each.polarity is Polarity.PROVIDED
        yield InterfaceSymbol(each.instance_name, each.type_name, is_provided)
