"""Builds the model from a valid tree, along the tables of `rtkit.profile.spec`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtkit.profile.common import Foreign, ForeignElement
from rtkit.profile.spec import ElementSpec
from rtkit.profile.xmlnames import XSI_TYPE, split

_One = Callable[[str, str], str]
"""Returns one and the same object for equal texts: profiles say the same things often."""


class NotStrict(Exception):
    """The tree is not in strict form, or has content that a reader has to be told of."""


def build(element: Any, spec: ElementSpec) -> Any:
    """Return the model of `element`, which is valid.

    Raises:
        KeyError: The tree is not valid.
        ValueError: The tree is not valid.
    """
    known: dict[str, str] = {}
    return _built(element, spec, known.setdefault)


def build_strict(element: Any, spec: ElementSpec, depth: int) -> Any:
    """Return the model of `element` if it needs neither repair nor remark; it may yet be invalid.

    Prefixes must be the usual ones. `depth` is how many more levels there may be.

    Raises:
        NotStrict: It does need some.
        KeyError: The tree is not valid.
        ValueError: The tree is not valid.
    """
    known: dict[str, str] = {}
    return _strictly(element, spec, depth, known.setdefault)


def _built(element: Any, spec: ElementSpec, one: _One) -> Any:
    args = spec.blank[:]
    readers = spec.readers
    foreign_attributes: list[tuple[str, str]] = []
    for name, value in element.items():
        reader = readers.get(name)
        if reader is not None:
            place, read = reader
            args[place] = one(value, value) if read is None else read(value)
        elif name != XSI_TYPE:
            foreign_attributes.append((name, value))
    foreign_elements = _children(element, spec, args, one) if len(element) else ()
    if foreign_attributes or foreign_elements:
        args[spec.foreign_place] = Foreign(tuple(sorted(foreign_attributes)), foreign_elements)
    if spec.tag_place is not None:
        args[spec.tag_place] = split(element.tag)[1]
    return spec.make(*args)


def _strictly(element: Any, spec: ElementSpec, depth: int, one: _One) -> Any:
    args = spec.blank[:]
    readers = spec.readers
    seen_type = None
    for name, value in element.items():
        reader = readers.get(name)
        if reader is not None:
            place, read = reader
            args[place] = one(value, value) if read is None else read(value)
        elif name == XSI_TYPE:
            seen_type = value
        else:
            raise NotStrict
    if depth < 0 or (seen_type != spec.xsi_type_text and not _is_extended(seen_type, spec)):
        raise NotStrict
    if len(element):
        slots, last = spec.slots, 0
        for item in element:
            slot = slots.get(item.tag)
            if slot is None or slot[0] < last:
                raise NotStrict
            last, place, inner, is_many = slot
            if inner is not None:
                made = _strictly(item, inner, depth - 1, one)
            elif item.attrib:
                raise NotStrict
            else:
                made = item.text or ""
            if is_many:
                if args[place]:
                    args[place].append(made)
                else:
                    args[place] = [made]
            elif args[place] is None:
                args[place] = made
            else:
                raise NotStrict
        for place in spec.many_places:
            args[place] = tuple(args[place])
    if spec.tag_place is not None:
        args[spec.tag_place] = split(element.tag)[1]
    return spec.make(*args)


def _is_extended(seen_type: str | None, spec: ElementSpec) -> bool:
    return seen_type is not None and seen_type == spec.extended_type


def _children(
    element: Any, spec: ElementSpec, args: list[Any], one: _One
) -> tuple[ForeignElement, ...]:
    slots = spec.slots
    foreign: list[ForeignElement] = []
    for item in element:
        slot = slots.get(item.tag)
        if slot is None:
            foreign.append(_foreign(item, is_top=True))
            continue
        _, place, inner, is_many = slot
        made = _built(item, inner, one) if inner is not None else (item.text or "")
        if not is_many:
            args[place] = made
        elif args[place]:
            args[place].append(made)
        else:
            args[place] = [made]
    for place in spec.many_places:
        args[place] = tuple(args[place])
    return tuple(foreign)


def _foreign(item: Any, *, is_top: bool = False) -> ForeignElement:
    children = tuple(_foreign(below) for below in item)
    text = item.text if not children else _unless_blank(item.text)
    return ForeignElement(
        item.tag,
        tuple(sorted(item.items())),
        text or None,
        children,
        None if is_top else _unless_blank(item.tail),
    )


def _unless_blank(text: str | None) -> str | None:
    return text if text and not text.isspace() else None
