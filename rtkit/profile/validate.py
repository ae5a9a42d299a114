"""Validates a normalised tree against rtkit's own schemas."""

from __future__ import annotations

from functools import cache
from itertools import islice
from typing import Any

from rtkit.profile.common import Note
from rtkit.profile.findings import ElementPaths
from rtkit.profile.xmlnames import shorten
from rtkit.resources import resource

RTC, RTS = "RtcProfile.xsd", "RtsProfile.xsd"
SCHEMA_RULE = "schema"
_MOST = 100


@cache
def _schema(name: str) -> Any:
    from lxml import etree

    parser = etree.XMLParser(no_network=True, resolve_entities=False)
    return etree.XMLSchema(etree.parse(resource("schemas", name), parser))


@cache
def _explaining_schema(name: str) -> Any:
    import xmlschema

    return xmlschema.XMLSchema10(resource("schemas", name), allow="local")


def violations(root: Any, schema_name: str) -> list[Note]:
    """Return violations of the schema by line; quick, with lxml's words."""
    schema = _schema(schema_name)
    if schema.validate(root):
        return []
    return [
        Note(entry.line, _one_line(entry.message), _one_line(entry.path), SCHEMA_RULE)
        for entry in schema.error_log
    ]


def explained_violations(root: Any, schema_name: str) -> list[Note]:
    """Return violations of the schema, with reasons and allowed content; slow (xmlschema)."""
    places = ElementPaths()
    schema = _explaining_schema(schema_name)
    return [
        Note(
            error.sourceline or 0,
            _one_line(error.reason),
            places.path(error.elem) if error.elem is not None else _one_line(error.path),
            SCHEMA_RULE,
            allowed=_expected(error),
        )
        for error in islice(schema.iter_errors(root, use_location_hints=False), _MOST)
    ]


def _one_line(text: object) -> str:
    return " ".join(shorten(str(text)).split())


def _expected(error: Any) -> str:
    """Return the allowed content, where the library knows it: children or an enumeration."""
    names = [str(item.name) for item in getattr(error, "expected", None) or () if item.name]
    names = names or [str(word) for word in getattr(error.validator, "enumeration", None) or ()]
    return shorten(", ".join(names))
