"""Fields of what a page sends: texts, lists, numbers and objects, or an error that names them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rtkit.errors import Malformed

Fields = Mapping[str, Any]
_LONGEST = 200
"""Part of a wrong value that is repeated [characters]."""


def text_in(fields: Fields, key: str, default: str | None = None) -> str:
    """Return a text.

    Raises:
        Malformed: There is none, or none that a command line can hold.
    """
    value = fields.get(key, default)
    if not isinstance(value, str) or "\0" in value:
        raise wrong(key, "a text", value)
    return value


def texts_in(fields: Fields, key: str) -> dict[str, str]:
    """Return texts by their names; none where the field is absent.

    Raises:
        Malformed: It is something else.
    """
    texts = object_in(fields, key, {})
    return {name: text_in(texts, name) for name in texts}


def list_in(fields: Fields, key: str) -> list[Any]:
    """Return a list; an empty one where the field is absent.

    Raises:
        Malformed: It is something else.
    """
    value = fields.get(key, [])
    if not isinstance(value, list):
        raise wrong(key, "a list", value)
    return value


def words_in(fields: Fields, key: str) -> list[str]:
    """Return a list of texts; an empty one where the field is absent.

    Raises:
        Malformed: It is something else.
    """
    return [text_in({key: each}, key) for each in list_in(fields, key)]


def object_in(fields: Fields, key: str, default: Fields | None = None) -> dict[str, Any]:
    """Return an object, as fields of their own.

    Raises:
        Malformed: There is none.
    """
    value = fields.get(key, default)
    if not isinstance(value, dict):
        raise wrong(key, "an object", value)
    return value


def number_in(fields: Fields, key: str) -> int:
    """Return a number of things.

    Raises:
        Malformed: There is none, or a negative one.
    """
    value = fields.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise wrong(key, "a number", value)
    return value


def wrong(key: str, wanted: str, value: object) -> Malformed:
    """Return the error about a field that holds something else."""
    return Malformed(f"{key}: {wanted} is wanted, not {value!r}"[:_LONGEST])
