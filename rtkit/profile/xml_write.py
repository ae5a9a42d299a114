"""Writes a model as XML in strict form: always the same bytes for the same model."""

from __future__ import annotations

from typing import Any

from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.spec import Attr, Child, ElementSpec
from rtkit.profile.written import check_text, checked_name, format_value, in_order
from rtkit.profile.xmlnames import NAMESPACES, XML, clark, short, split
from rtkit.xmltext import TEXT_ESCAPES, VALUE_ESCAPES

_DECLARATION = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
_INDENT = "    "


class XmlWriter:
    """One document in the making; foreign namespaces get prefixes as they are met."""

    def __init__(self, prefixes: tuple[str, ...]) -> None:
        self._prefixes = {NAMESPACES[prefix]: prefix for prefix in prefixes}
        self._out: list[str] = []

    def document(self, profile: Any, spec: ElementSpec, tag: str) -> bytes:
        """Return the document whose root is a profile's model.

        Raises:
            Malformed: A text holds a character that XML cannot carry, or a number is not finite.
        """
        self._element(profile, spec, tag, "")
        head = self._out[0].removeprefix(f"<{tag}")
        declared = "".join(
            f' xmlns:{prefix}="{uri.translate(VALUE_ESCAPES)}"'
            for uri, prefix in self._prefixes.items()
        )
        text = f"{_DECLARATION}<{tag}{declared}{head}{''.join(self._out[1:])}"
        return check_text(text).encode("utf-8")

    def _element(self, value: Any, spec: ElementSpec, tag: str, indent: str) -> None:
        foreign: Foreign = getattr(value, spec.foreign_field)
        parts = [f"{indent}<{tag}"]
        xsi_type = spec.xsi_type_text or _extended_type(spec, value)
        if xsi_type is not None:
            parts.append(f' xsi:type="{xsi_type}"')
        for item in spec.attributes:
            field = getattr(value, item.field)
            if field is not None:
                text = format_value(item, field).translate(VALUE_ESCAPES)
                parts.append(f' {short(item.name)}="{text}"')
        parts += [self._foreign_attribute(*pair) for pair in foreign.attributes]
        start = len(self._out)
        self._out.append("".join(parts))
        inner = indent + _INDENT
        for child in in_order(spec, value):
            self._child(child, value if spec.wraps else getattr(value, child.field), inner)
        for element in foreign.elements:
            self._out.append(f"{inner}{self._foreign(element, inner)}\n")
        if len(self._out) == start + 1:
            self._out[start] += "/>\n"
        else:
            self._out[start] += ">\n"
            self._out.append(f"{indent}</{tag}>\n")

    def _child(self, child: Child, field: Any, indent: str) -> None:
        if field is None:
            return
        for value in field if child.is_many else (field,):
            if child.spec is None:
                name = short(child.name)
                text = value.translate(TEXT_ESCAPES)
                self._out.append(f"{indent}<{name}>{text}</{name}>\n")
            else:
                self._element(value, child.spec, short(child.name), indent)

    def _foreign_attribute(self, name: str, value: str) -> str:
        return f' {self._name(name)}="{value.translate(VALUE_ESCAPES)}"'

    def _foreign(self, element: ForeignElement, indent: str) -> str:
        name = self._name(element.name)
        head = name + "".join(self._foreign_attribute(*pair) for pair in element.attributes)
        text = (element.text or "").translate(TEXT_ESCAPES)
        if not element.children:
            return f"<{head}>{text}</{name}>" if text else f"<{head}/>"
        inner = indent + _INDENT
        is_mixed = bool(text) or any(below.tail for below in element.children)
        below = [
            self._foreign(item, inner) + (item.tail or "").translate(TEXT_ESCAPES)
            for item in element.children
        ]
        if is_mixed:
            return f"<{head}>{text}{''.join(below)}</{name}>"
        lines = "".join(f"\n{inner}{item}" for item in below)
        return f"<{head}>{lines}\n{indent}</{name}>"

    def _name(self, name: str) -> str:
        namespace, local = split(checked_name(name))
        if not namespace:
            return local
        if namespace == XML:
            return f"xml:{local}"
        prefix = self._prefixes.setdefault(namespace, f"ns{len(self._prefixes)}")
        return f"{prefix}:{local}"


def _extended_type(spec: ElementSpec, value: Any) -> str | None:
    """Return the type that allows for content of its namespace, where there is some."""
    if spec.extended_type is None:
        return None
    namespace = split(clark(spec.extended_type))[0]
    parts: list[Attr | Child] = [*spec.attributes, *spec.children]
    fields = (part.field for part in parts if split(part.name)[0] == namespace)
    has_some = any(getattr(value, field) not in (None, ()) for field in fields)
    return spec.extended_type if has_some else None
