"""Writes profiles as strict XML, YAML or JSON; always the same bytes for the same model."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from rtkit.errors import Malformed
from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.forms import XML as XML_FORM
from rtkit.profile.forms import YAML as YAML_FORM
from rtkit.profile.forms import check_form
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, Attr, Child, ElementSpec, is_real, is_whole
from rtkit.profile.tree_form import (
    CONDITION,
    FOREIGN_ATTRIBUTES,
    FOREIGN_ELEMENTS,
    WAITS,
    date_table,
    key_of,
)
from rtkit.profile.xmlnames import NAMESPACES, RTKIT, XML, clark, short, split
from rtkit.xmltext import TEXT_ESCAPES, VALUE_ESCAPES, bad_character

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile


_LOCAL_NAME = r"[^\W\d][\w.-]*"


def check_text(text: str) -> str:
    """Return `text` if XML can carry it.

    Raises:
        Malformed: It has a character that XML cannot carry.
    """
    bad = bad_character(text)
    if bad:
        around = text[max(0, bad.start() - 20) : bad.start()]
        raise Malformed(f"character {bad[0]!r} after {around!r} cannot be written to XML")
    return text


def checked_name(name: str) -> str:
    """Return ``{namespace}local`` if XML can have such a name.

    Raises:
        Malformed: It cannot.
    """
    local = split(name)[1]
    if not re.fullmatch(_LOCAL_NAME, local):
        raise Malformed(f"{local!r} is not an XML name")
    return check_text(name)


def in_order(spec: ElementSpec, value: Any) -> tuple[Child, ...]:
    """Return the children to write; of the alternatives of one field, the one that fits."""
    return tuple(child for child in spec.children if _fits(child, value))


def _fits(child: Child, value: Any) -> bool:
    tag_field = child.spec.tag_field if child.spec is not None else None
    if tag_field is None:
        return True
    return bool(getattr(getattr(value, child.field), tag_field) == split(child.name)[1])


def format_value(item: Attr, value: Any) -> str:
    """Return the text of an attribute's value.

    Raises:
        Malformed: It is a number that no reader would take.
    """
    if item.kind == FLAG:
        return "true" if value else "false"
    if item.kind == REAL:
        text = repr(float(value))
        if not is_real(text):
            raise Malformed(f"{short(item.name)} must be a finite number, not {text}")
        return text
    if item.kind == WHOLE:
        text = str(int(value))
        if not is_whole(text):
            raise Malformed(f"{short(item.name)} is beyond 18 digits: {text}")
        return text
    return str(value)


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
        usual = "rtkit" if namespace == RTKIT else f"ns{len(self._prefixes)}"
        prefix = self._prefixes.setdefault(namespace, usual)
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


def write_rts(profile: RtsProfile) -> bytes:
    """Write an RTS profile.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rts_spec import RTS_PROFILE

    own = ("rtkit",) if profile.variables or profile.includes else ()
    writer = XmlWriter(("rts", "rtsExt", "xsi", *own))
    return writer.document(profile, RTS_PROFILE, "rts:RtsProfile")


def write_rtc(profile: RtcProfile) -> bytes:
    """Write an RTC profile.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rtc_spec import RTC_PROFILE

    prefixes = ("rtc", "rtcDoc", "rtcExt", "xsi")
    return XmlWriter(prefixes).document(profile, RTC_PROFILE, "rtc:RtcProfile")


def write_profile(profile: RtcProfile | RtsProfile, form: str = XML_FORM) -> bytes:
    """Write a profile of either kind in a form of `rtkit.profile.forms.FORMS`.

    Raises:
        Malformed: There is no such form, a text holds a character that XML cannot carry, or a
            number is not finite.
    """
    from rtkit.profile.rts_model import RtsProfile

    check_form(form)
    if form == XML_FORM:
        return write_rts(profile) if isinstance(profile, RtsProfile) else write_rtc(profile)
    data = plain_profile(profile)
    if form == YAML_FORM:
        from rtkit.profile.yaml_text import write_yaml as write
    else:
        from rtkit.profile.json_text import write_json as write
    return write(data).encode("utf-8")


def plain_profile(profile: RtcProfile | RtsProfile) -> dict[str, Any]:
    """Return a profile as the plain data that its YAML and JSON forms hold.

    Raises:
        Malformed: A text holds a character that XML cannot carry, or a number is not finite.
    """
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile.tree_form import ROOTS

    if isinstance(profile, RtsProfile):
        from rtkit.profile.rts_spec import RTS_PROFILE

        return {ROOTS["rts"]: plain(profile, RTS_PROFILE, clark("rts:RtsProfile"))}
    from rtkit.profile.rtc_spec import RTC_PROFILE

    return {ROOTS["rtc"]: plain(profile, RTC_PROFILE, clark("rtc:RtcProfile"))}


def plain(value: Any, spec: ElementSpec, tag: str) -> dict[str, Any]:
    """Return a model as a table of keys, lists and scalars; `tag` is its element's name.

    Raises:
        Malformed: It holds what XML could not, so that no reader would take it.
    """
    made: dict[str, Any] = {}
    for attribute in spec.attributes:
        field = getattr(value, attribute.field)
        if field is not None:
            made[key_of(attribute.name, tag)] = _scalar(attribute, field)
    for part in in_order(spec, value):
        field = value if spec.wraps else getattr(value, part.field)
        if field is None or (part.is_many and not field):
            continue
        key = key_of(part.name, tag)
        content = [_child(part, each) for each in (field if part.is_many else (field,))]
        written = content if part.is_many else content[0]
        if part.field in WAITS:
            made[CONDITION] = {key: written}
        else:
            made[key] = written
    return made | _foreign(getattr(value, spec.foreign_field), tag)


def _child(part: Child, value: Any) -> Any:
    return check_text(value) if part.spec is None else plain(value, part.spec, part.name)


def _scalar(attribute: Attr, value: Any) -> Any:
    text = check_text(format_value(attribute, value))
    if attribute.kind == FLAG:
        return bool(value)
    if attribute.kind == REAL:
        return float(value)
    if attribute.kind == WHOLE:
        return int(value)
    date = date_table(text) if attribute.kind == DATE else None
    return text if date is None else date


def _foreign(foreign: Foreign, tag: str) -> dict[str, Any]:
    own = {name: text for name, text in foreign.attributes if split(name)[0] == RTKIT}
    made: dict[str, Any] = {key_of(name, tag): check_text(text) for name, text in own.items()}
    if len(own) < len(foreign.attributes):
        others = tuple(each for each in foreign.attributes if each[0] not in own)
        made[FOREIGN_ATTRIBUTES] = _named(others)
    if foreign.elements:
        made[FOREIGN_ELEMENTS] = [_foreign_element(each) for each in foreign.elements]
    return made


def _foreign_element(element: ForeignElement) -> dict[str, Any]:
    made: dict[str, Any] = {"name": checked_name(element.name)}
    if element.attributes:
        made["attributes"] = _named(element.attributes)
    if element.text:
        made["text"] = check_text(element.text)
    if element.tail:
        made["tail"] = check_text(element.tail)
    if element.children:
        made["children"] = [_foreign_element(each) for each in element.children]
    return made


def _named(attributes: tuple[tuple[str, str], ...]) -> dict[str, str]:
    return {checked_name(name): check_text(text) for name, text in attributes}
