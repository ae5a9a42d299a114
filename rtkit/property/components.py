"""Parts of values by name: of a pose ``x y z a b c``, of an element its children, else by index.

Attributes of an element are parts, too, where no child has the name; their text is read as that
of a leaf is.

Source: `property-service` reference, section 4.
"""

from __future__ import annotations

from collections.abc import Sequence

from rtkit.property.codes import PropertyError
from rtkit.property.reading import read
from rtkit.property.values import Element, Value, is_vector
from rtkit.property.writing import write

_LABELS = {3: ("x", "y", "z"), 6: ("x", "y", "z", "a", "b", "c")}


def names(value: object, labels: Sequence[str] = ()) -> list[str]:
    """Return the names of the parts of a value, in order; none if it has no parts."""
    if isinstance(value, tuple):
        labels = labels or (_LABELS.get(len(value), ()) if is_vector(value) else ())
        if len(labels) == len(value):
            return list(labels)
        return [str(index) for index in range(len(value))]
    if isinstance(value, Element):
        return list(dict.fromkeys((*value.attributes, *(child.name for child in value.children))))
    return []


def get(value: Value, path: Sequence[str], labels: Sequence[str] = ()) -> Value | None:
    """Return the part of a value at a path of names, None if there is none.

    An element with children is itself a part; one with a leaf stands for its leaf.
    """
    current: Value = value
    steps = list(path)
    while steps:
        name = steps.pop(0)
        if isinstance(current, tuple):
            index = _index(current, name, labels)
            if index is None:
                return None
            current = current[index]
        elif isinstance(current, Element):
            nth = int(steps[0]) if _has_several(current, name, steps) else 0
            child = current.find(name, nth)
            if child is None:
                text = current.attributes.get(name)
                return None if text is None or steps else _leaf(text)
            if _has_several(current, name, steps):
                steps.pop(0)
            current = child if child.leaf is None else child.leaf
        else:
            return None
        labels = ()
    return current


def _leaf(text: str) -> Value:
    try:
        return read(text)
    except PropertyError:
        return text


def replace(value: Value, path: Sequence[str], part: Value, labels: Sequence[str] = ()) -> Value:
    """Return a value with the part at a path, which there is, replaced.

    The path is at most as long as values are deep, so this may call itself.
    """
    if not path:
        return part
    name, rest = path[0], list(path[1:])
    if isinstance(value, tuple):
        index = _index(value, name, labels) or 0
        return (*value[:index], replace(value[index], rest, part), *value[index + 1 :])
    assert isinstance(value, Element)
    if value.find(name) is None:
        text = part if isinstance(part, str) else write(part)
        return Element(
            value.name, {**value.attributes, name: str(text)}, value.children, value.leaf
        )
    nth = int(rest.pop(0)) if _has_several(value, name, rest) else 0
    children = []
    for child in value.children:
        if child.name == name:
            child = _child(child, rest, part) if nth == 0 else child
            nth -= 1
        children.append(child)
    return Element(value.name, value.attributes, tuple(children))


def _child(child: Element, rest: list[str], part: Value) -> Element:
    if child.leaf is None and rest:
        replaced = replace(child, rest, part)
        assert isinstance(replaced, Element)
        return replaced
    if child.leaf is None and isinstance(part, Element) and part.name == child.name:
        return part
    leaf = part if child.leaf is None else replace(child.leaf, rest, part)
    return Element(child.name, child.attributes, (), leaf)


def _index(value: tuple[Value, ...], name: str, labels: Sequence[str]) -> int | None:
    if name.isascii() and name.isdigit() and len(name) < 8:
        index = int(name)
        return index if index < len(value) and str(index) == name else None
    own = names(value, labels)
    return own.index(name) if name in own else None


def _has_several(value: Element, name: str, rest: Sequence[str]) -> bool:
    """Return whether the next step is which of several children of a name is meant."""
    if not rest or not (rest[0].isascii() and rest[0].isdigit()) or len(rest[0]) > 7:
        return False
    return sum(child.name == name for child in value.children) > 1
