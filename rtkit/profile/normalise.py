"""Repairs a profile's tree to the strict form, noting each repair with its line.

One walk along the tables of `rtkit.profile.spec`; nothing here knows RTC from RTS.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from typing import Any

from rtkit.profile.findings import Findings
from rtkit.profile.parse import MAX_ATTRIBUTES, MAX_DEPTH
from rtkit.profile.spec import DATE, FLAG, WHOLE, WORD, Attr, Child, ElementSpec, is_date
from rtkit.profile.xmlnames import NAMESPACES, RTKIT, XML, XSI, XSI_TYPE, clark, short, split

_LANGUAGE = r"[a-zA-Z]{1,8}(-[a-zA-Z0-9]{1,8})*"
_OUR_NAMESPACES = (frozenset(NAMESPACES.values()) | {""}) - {RTKIT}
_CONDITIONS = ("if", "unless")
"""Attributes of rtkit that any element may have."""

_CLOSED = frozenset(("", NAMESPACES["rtc"], NAMESPACES["rts"]))
"""Here all names are known; the extension namespaces grow, so unknown ones there are kept."""
_HINTS = ("schemaLocation", "noNamespaceSchemaLocation")


def normalise(element: Any, spec: ElementSpec, found: Findings, depth: int = 1) -> None:
    """Repair `element` and what is below it in place."""
    if depth > MAX_DEPTH:
        found.wrong(element, "too-deep", f"elements are nested deeper than {MAX_DEPTH}")
        return
    if spec.rule is not None:
        spec.rule(element, found)
    _attributes(element, spec, found)
    if spec.needs or len(element) or element.text is not None:
        _children(element, spec, found, depth)


def _attributes(element: Any, spec: ElementSpec, found: Findings) -> None:
    checks, required, seen_type = spec.checks, 0, None
    odd: list[tuple[str, str]] = []
    for name, value in element.items():
        expected = checks.get(name)
        if expected is None:
            if name == XSI_TYPE:
                seen_type = value
            else:
                odd.append((name, value))
            continue
        check, is_required = expected
        if check and not check(value) and not _respell(element, spec.known[name], value, found):
            continue
        required += is_required
    if len(odd) > MAX_ATTRIBUTES:
        text = f"{len(odd)} unknown attributes on {short(element.tag)}"
        found.wrong(element, "too-many-attributes", text, allowed=f"at most {MAX_ATTRIBUTES}")
        return
    for name, value in odd:
        required += _odd_attribute(element, spec, name, value, found)
    if required < spec.required_count:
        _supply(element, spec, found)
    if seen_type != spec.xsi_type_text or (seen_type and (seen_type, spec) not in found.good_types):
        _type(element, spec, seen_type, found)


def _respell(element: Any, attribute: Attr, value: str, found: Findings) -> bool:
    """Repair a value; return whether the attribute is there afterwards."""
    text = value.strip()
    better = value
    details = {"at": attribute.name, "seen": value, "allowed": attribute.allowed}
    if attribute.kind == WORD:
        better = attribute.respellings.get(text.lower(), value)
    elif not text and not (attribute.required and attribute.supply is None):
        if not attribute.required:
            message = f"empty {short(attribute.name)} taken as absent"
            found.repaired(element, "empty-value", message, **details)
        del element.attrib[attribute.name]
        return False
    elif attribute.kind == FLAG:
        better = text.lower()
    elif attribute.kind == WHOLE:
        whole, _, fraction = text.partition(".")
        better = whole if not fraction.strip("0") else value
    elif attribute.kind == DATE:
        better = text.replace("/", "-").replace(" ", "T", 1)
        better = better if "T" in better else f"{better}T00:00:00"
        better = better if is_date(better) else value
    if better != value:
        element.set(attribute.name, better)
        message = f"{short(attribute.name)} {value!r} taken as {better!r}"
        found.repaired(element, "respelled-value", message, **details)
    if attribute.check is not None and not attribute.check(better):
        name = short(attribute.name)
        message = f"{name} is {value!r}; allowed: {attribute.allowed}"
        if "${" in value:
            # Other tools read this document, too: they must find a value.
            message += f", and beside it rtkit:{split(attribute.name)[1]}={value!r}"
        found.wrong(element, "bad-value", message, **details)
    return True


def _odd_attribute(element: Any, spec: ElementSpec, name: str, value: str, found: Findings) -> int:
    """Deal with an attribute that is not in the table; return 1 if it stood for a required one."""
    namespace, local = split(name)
    details = {"at": name, "seen": value}
    if namespace == XSI:
        del element.attrib[name]
        if local not in _HINTS:
            found.repaired(element, "xml-attribute", f"{short(name)} dropped", **details)
        return 0
    if _is_wrong_xml(namespace, local, value):
        del element.attrib[name]
        found.repaired(element, "xml-attribute", f"{short(name)} {value!r} dropped", **details)
        return 0
    if namespace == RTKIT:
        _check_own(element, "attribute", local, (*_CONDITIONS, *spec.attribute_by_local), found)
        return 0
    if not namespace and local in _CONDITIONS:
        del element.attrib[name]
        element.set(clark(f"rtkit:{local}"), value)
        text = f"{local} taken as rtkit:{local}"
        found.repaired(element, "attribute-name", text, **details, allowed=f"rtkit:{local}")
        return 0
    if namespace in _OUR_NAMESPACES:
        meant = spec.attribute_by_local.get(local)
        if meant is not None and element.get(meant) is None:
            del element.attrib[name]
            element.set(meant, value)
            text = f"{short(name)} taken as {short(meant)}"
            found.repaired(
                element, "attribute-name", text, at=name, seen=short(name), allowed=short(meant)
            )
            attribute = spec.known[meant]
            if attribute.check is not None and not attribute.check(value):
                return int(_respell(element, attribute, value, found) and attribute.required)
            return int(attribute.required)
        if namespace in _CLOSED:
            del element.attrib[name]
            text = f"unknown attribute {short(name)} dropped"
            allowed = ", ".join(short(item.name) for item in spec.attributes)
            found.repaired(element, "unknown-attribute", text, **details, allowed=allowed)
            return 0
    found.remark(element, "foreign-kept", f"foreign attribute {short(name)} kept", **details)
    return 0


def _check_own(
    element: Any, what: str, local: str, known: Collection[str], found: Findings
) -> None:
    """Refuse a name of rtkit's namespace that is none of those known."""
    if local in known:
        return
    from rtkit.rtc.nearest import did_you_mean

    there = f"; there are {', '.join(known)}" if known else " here"
    text = f"no such {what}: rtkit:{local}{did_you_mean(local, known) or there}"
    found.wrong(element, "rtkit-part", text, seen=local, allowed=", ".join(known))


def _is_wrong_xml(namespace: str, local: str, value: str) -> bool:
    """Return whether this is an ``xml:`` attribute other than a sound ``xml:lang``.

    Schema libraries differ in what they know of these, so only that one is kept.
    """
    return namespace == XML and (local != "lang" or not re.fullmatch(_LANGUAGE, value))


def _supply(element: Any, spec: ElementSpec, found: Findings) -> None:
    for attribute in spec.attributes:
        if not attribute.required or element.get(attribute.name) is not None:
            continue
        supply = attribute.supply
        if supply is None:
            text = f"{short(element.tag)} has no {short(attribute.name)}"
            found.wrong(element, "missing-attribute", text, allowed=attribute.allowed)
            continue
        value = supply if isinstance(supply, str) else supply(element, found)
        element.set(attribute.name, value)
        text = f"{short(attribute.name)} is absent: taken as {value!r}"
        found.repaired(element, "absent-attribute", text, allowed=attribute.allowed)


def _type(element: Any, spec: ElementSpec, seen: str | None, found: Findings) -> None:
    if spec.xsi_type is None or spec.xsi_type_text is None:
        if seen is not None and not _is_extended(element, spec, seen, found):
            del element.attrib[XSI_TYPE]
            text = f"xsi:type {seen!r} dropped"
            found.repaired(element, "xsi-type", text, at=XSI_TYPE, seen=seen)
        return
    if seen is not None:
        prefix, _, local = seen.strip().rpartition(":")
        if local == spec.xsi_type[1] or any(local == other for _, other in spec.also_types):
            namespace = found.namespaces(element).get(prefix or None)
            if (namespace, local) == spec.xsi_type or (namespace, local) in spec.also_types:
                if found.scope is not None:
                    found.good_types.add((seen, spec))
                return
        text = f"unknown xsi:type {seen!r} taken as {spec.xsi_type_text!r}"
        found.repaired(
            element, "xsi-type", text, at=XSI_TYPE, seen=seen, allowed=spec.xsi_type_text
        )
    else:
        text = f"xsi:type is absent: taken as {spec.xsi_type_text!r}"
        found.repaired(element, "xsi-type", text, allowed=spec.xsi_type_text)
    set_type(element, spec.xsi_type_text, found)


def _is_extended(element: Any, spec: ElementSpec, seen: str, found: Findings) -> bool:
    prefix, _, local = seen.strip().rpartition(":")
    namespace = found.namespaces(element).get(prefix or None)
    return spec.extended_type is not None and clark(spec.extended_type) == f"{{{namespace}}}{local}"


def set_type(element: Any, wanted: str, found: Findings) -> None:
    """Set ``xsi:type`` to a type given with its usual prefix, by the document's prefix."""
    from lxml import etree

    namespace, local = split(clark(wanted))
    if found.scope is not None and found.scope.get(wanted.partition(":")[0]) == namespace:
        element.set(XSI_TYPE, wanted)
        return
    prefixed = {uri for prefix, uri in element.nsmap.items() if prefix}
    if element.nsmap.get(None) == namespace and namespace not in prefixed:
        element.set(XSI_TYPE, local)
    else:
        element.set(XSI_TYPE, etree.QName(namespace, local))


def _children(element: Any, spec: ElementSpec, found: Findings, depth: int) -> None:
    index, last, is_disordered = spec.index, -1, False
    counts: dict[str, int] = {}
    _no_text(element, element.text, found)
    for item in list(element):
        tail = item.tail
        if tail is not None and not tail.isspace():
            _no_text(element, tail, found)
        slot = index.get(item.tag) or _odd_child(element, item, spec, found, depth)
        if slot is None:
            last = len(index)
            continue
        rank, expected = slot
        if rank < last:
            is_disordered = True
        last = rank
        counts[expected.field] = count = counts.get(expected.field, 0) + 1
        if count > 1 and not expected.is_many:
            text = f"second {short(item.tag)}; at most one is allowed"
            found.wrong(item, "repeated-element", text, seen=str(count), allowed="at most one")
        if expected.spec is None:
            _text(item, found)
        else:
            normalise(item, expected.spec, found, depth + 1)
    if is_disordered:
        was = [item.tag for item in element if item.tag in index]
        _sort(element, spec)
        _note_order(element, was, found)
    for field, least in spec.needs.items():
        if counts.get(field, 0) < least:
            names = " | ".join(short(item.name) for item in spec.children if item.field == field)
            text = f"{short(element.tag)} needs at least {least} of: {names}"
            seen = str(counts.get(field, 0))
            found.wrong(element, "missing-element", text, seen=seen, allowed=f"at least {least}")


def _note_order(element: Any, was: list[str], found: Findings) -> None:
    present = set(was)
    tags = [item.tag for item in element if item.tag in present]
    seen, allowed = (", ".join(map(short, dict.fromkeys(each))) for each in (was, tags))
    text = f"children of {short(element.tag)} put in order"
    found.repaired(element, "element-order", text, seen=seen, allowed=allowed)


def _no_text(element: Any, text: str | None, found: Findings) -> None:
    if text is not None and not text.isspace():
        message = f"{short(element.tag)} may not hold text: {text.strip()[:40]!r}"
        found.wrong(element, "text-content", message, seen=text.strip(), allowed="elements only")


def _text(item: Any, found: Findings) -> None:
    for name, value in item.items():
        del item.attrib[name]
        text = f"unknown attribute {short(name)} dropped"
        found.repaired(item, "unknown-attribute", text, at=name, seen=value, allowed="none")
    if len(item):
        inside = short(item[0].tag)
        text = f"{short(item.tag)} may hold text only, not {inside}"
        found.wrong(item, "text-content", text, seen=inside, allowed="text only")


def _sort(element: Any, spec: ElementSpec) -> None:
    behind = (len(spec.index), None)
    # One by one: lxml assigns a slice in time quadratic in its length.
    for item in sorted(element, key=lambda item: spec.index.get(item.tag, behind)[0]):
        element.append(item)


def _odd_child(
    element: Any, item: Any, spec: ElementSpec, found: Findings, depth: int
) -> tuple[int, Child] | None:
    namespace, local = split(item.tag)
    if namespace in _OUR_NAMESPACES:
        meant = spec.child_by_local.get(local)
        if meant is not None:
            text = f"{short(item.tag)} taken as {short(meant)}"
            found.repaired(item, "element-name", text, seen=short(item.tag), allowed=short(meant))
            item.tag = meant
            return spec.index[meant]
        if namespace in _CLOSED:
            text = f"unknown element {short(item.tag)} dropped"
            allowed = ", ".join(dict.fromkeys(short(each.name) for each in spec.children))
            found.repaired(item, "unknown-element", text, seen=short(item.tag), allowed=allowed)
            element.remove(item)
            return None
    if namespace == RTKIT:
        known = [split(name)[1] for name in spec.index if split(name)[0] == RTKIT]
        _check_own(item, "element", local, known, found)
        return None
    seen = short(item.tag)
    found.remark(item, "foreign-kept", f"foreign element {seen} kept", seen=seen)
    _clean_foreign(item, found, depth + 1)
    return None


def _clean_foreign(item: Any, found: Findings, depth: int) -> None:
    if depth > MAX_DEPTH:
        found.wrong(item, "too-deep", f"elements are nested deeper than {MAX_DEPTH}")
        return
    if len(item.attrib) > MAX_ATTRIBUTES:
        text = f"{len(item.attrib)} attributes on {short(item.tag)}"
        found.wrong(item, "too-many-attributes", text, allowed=f"at most {MAX_ATTRIBUTES}")
        return
    for name, value in item.items():
        namespace, local = split(name)
        if namespace == XSI or _is_wrong_xml(namespace, local, value):
            del item.attrib[name]
            if local not in _HINTS:
                text = f"{short(name)} of a foreign element dropped"
                found.repaired(item, "xml-attribute", text, at=name, seen=value)
    for below in item:
        _clean_foreign(below, found, depth + 1)
