"""Check a normalised tree against rtkit's own schemas."""

from __future__ import annotations

from functools import cache
from itertools import islice
from typing import Any

from rtkit.profile.common import Note
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
    """Return what is against the schema, by line; quick, with lxml's words."""
    schema = _schema(schema_name)
    if schema.validate(root):
        return []
    return [
        Note(
            entry.line,
            " ".join(shorten(entry.message).split()),
            " ".join(str(entry.path).split()),
            SCHEMA_RULE,
        )
        for entry in schema.error_log
    ]


def explained_violations(root: Any, schema_name: str) -> list[Note]:
    """Return what is against the schema, with element path and reason; slow (xmlschema)."""
    schema = _explaining_schema(schema_name)
    return [
        Note(
            error.sourceline or 0,
            " ".join(shorten(f"{error.path}: {error.reason}").split()),
        )
        for error in islice(schema.iter_errors(root, use_location_hints=False), _MOST)
    ]
