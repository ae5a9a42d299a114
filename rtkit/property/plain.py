"""Values as JSON has them, for programs that do not know the grammar."""

from __future__ import annotations

from typing import Any

from rtkit.property.codes import PropertyError
from rtkit.property.messages import Payload
from rtkit.property.reading import read
from rtkit.property.values import Element, Value


def payload_to_plain(payload: Payload) -> Any:
    """Return what a reply carries: what is no value is a text, bytes are ``{"base64": …}``."""
    if isinstance(payload, bytes):
        from base64 import b64encode

        return {"base64": b64encode(payload).decode("ascii")}
    try:
        return to_plain(read(payload))
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
