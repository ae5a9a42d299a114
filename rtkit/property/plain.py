"""Converts values to and from JSON, for programs that do not know the grammar."""

from __future__ import annotations

from typing import Any

from rtkit.property.codes import PropertyError
from rtkit.property.limits import LIMITS, OF_REPLIES
from rtkit.property.messages import Payload
from rtkit.property.reading import read
from rtkit.property.types import Content
from rtkit.property.values import Element, Value


def payload_to_plain(payload: Payload) -> Any:
    """Return the content of a reply: a text if it is no value, bytes as ``{"base64": …}``."""
    if isinstance(payload, bytes):
        from base64 import b64encode

        return {"base64": b64encode(payload).decode("ascii")}
    try:
        return to_plain(read(payload, OF_REPLIES))
    except PropertyError:
        return payload


def to_plain(value: Value) -> Any:
    """Return numbers, booleans, texts, lists; elements as tables.

    ``{"element": NAME, "attributes": {…}, "children": […]}``, or ``"value"`` in place of children.
    Values are at most as deep as the grammar allows, so this may call itself.
    """
    if isinstance(value, tuple):
        return [to_plain(each) for each in value]
    if isinstance(value, Element):
        plain: dict[str, Any] = {"element": value.name}
        if value.attributes:
            plain["attributes"] = dict(value.attributes)
        if value.children:
            plain["children"] = [to_plain(each) for each in value.children]
        elif value.leaf is not None:
            plain["value"] = to_plain(value.leaf)
        return plain
    return str(value) if isinstance(value, str) else value


def from_plain(plain: Any, depth: int = 0) -> Content:
    """Return the value that JSON stands for; tables are elements, or bytes, as described above.

    Raises:
        PropertyError: ``bad-value``: another table; ``too-large``: nested too deep.
    """
    if depth > LIMITS.depth:
        raise PropertyError("too-large", f"nested deeper than {LIMITS.depth}")
    if plain is None:
        return ()
    if isinstance(plain, bool | int | float | str):
        return plain
    if isinstance(plain, list):
        return tuple(_from_item(each, depth) for each in plain)
    if isinstance(plain, dict) and plain.keys() == {"base64"}:
        return _from_base64(plain["base64"])
    return _from_table(plain, depth)


def _from_item(plain: Any, depth: int) -> Value:
    value = from_plain(plain, depth + 1)
    if isinstance(value, bytes):
        raise PropertyError("bad-value", "bytes stand alone")
    return value


def _from_base64(text: Any) -> bytes:
    from base64 import b64decode

    try:
        return b64decode(text, validate=True)
    except (ValueError, TypeError):
        raise PropertyError("bad-value", "expected base64") from None


def _from_table(plain: Any, depth: int) -> Element:
    given = dict(plain)
    name, attributes = given.pop("element", None), given.pop("attributes", {})
    children, leaf = given.pop("children", []), given.pop("value", None)
    is_right = isinstance(name, str) and isinstance(attributes, dict) and isinstance(children, list)
    if not is_right or given or not all(isinstance(each, str) for each in attributes.values()):
        raise PropertyError("bad-value", "expected an object of element, attributes, and children "
                                         "or value")  # fmt: skip
    made = [_from_item(each, depth) for each in children]
    elements = tuple(each for each in made if isinstance(each, Element))
    if len(elements) < len(made) or (made and leaf is not None):
        raise PropertyError("bad-value", "children are elements, and there is no value beside them")
    return Element(name, attributes, elements, None if leaf is None else _from_item(leaf, depth))
