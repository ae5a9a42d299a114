"""Tells editors and xmllint where the schemas of profiles are: an XML catalogue, and settings."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import NamedTuple

from rtkit.errors import NotFound, Refused
from rtkit.profile.xmlnames import NAMESPACES
from rtkit.resources import resource

CATALOGUE = "catalog.xml"
SETTINGS = ".vscode/settings.json"
_KEY = "xml.catalogs"
_OASIS = "urn:oasis:names:tc:entity:xmlns:xml:catalog"


class Schema(NamedTuple):
    """A schema that ships: its form, the namespace of XML documents, and its file."""

    form: str
    namespace: str
    path: str


def schemas() -> list[Schema]:
    """Return the schemas that a document begins with; they name those that they need."""
    names = (("RtcProfile", NAMESPACES["rtc"]), ("RtsProfile", NAMESPACES["rts"]))
    return [
        Schema(form, space if form == "XML" else "", resource("schemas", f"{name}{end}"))
        for name, space in names
        for form, end in (("XML", ".xsd"), ("JSON", ".schema.json"))
    ]


def catalogue() -> bytes:
    """Return an OASIS XML catalogue of the schemas, by namespace."""
    from lxml import etree

    root = etree.Element(f"{{{_OASIS}}}catalog", nsmap={None: _OASIS})  # type: ignore[dict-item]
    for schema in schemas():
        if schema.namespace:
            file = Path(schema.path).as_uri()
            for kind, key in (("uri", "name"), ("system", "systemId")):
                etree.SubElement(root, f"{{{_OASIS}}}{kind}", {key: schema.namespace, "uri": file})
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def editor_settings(folder: str) -> bytes:
    """Return the settings of VS Code in a folder with our catalogue beside those that are there.

    Raises:
        NotFound: There is no such folder.
        Refused: They cannot be read as JSON, as when they have comments; says what to write.
    """
    if not os.path.isdir(folder):
        raise NotFound(f"no such folder: {folder}")
    path = os.path.join(folder, SETTINGS)
    settings: object = {}
    if os.path.exists(path):
        try:
            settings = json.loads(Path(path).read_bytes())
        except ValueError:
            settings = None
    catalogues = settings.get(_KEY, []) if isinstance(settings, dict) else None
    if not isinstance(settings, dict) or not isinstance(catalogues, list):
        line = f'"{_KEY}": ["{CATALOGUE}"]'
        raise Refused(f"{path} is not plain JSON: write {line} there by hand")
    kept = [each for each in catalogues if each != CATALOGUE]
    merged = {**settings, _KEY: [*kept, CATALOGUE]}
    return (json.dumps(merged, indent=2, ensure_ascii=False) + "\n").encode()
