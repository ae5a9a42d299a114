"""Write the JSON Schemas of the profiles, from rtkit's tables and the texts of its XML schemas.

Usage: ``python tools/make_json_schemas.py [FOLDER]``; a test checks that ``schemas/`` holds what
this makes.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from rtkit.profile.rtc_spec import RTC_PROFILE
from rtkit.profile.rts_model import OrderStep
from rtkit.profile.rts_spec import RTS_PROFILE
from rtkit.profile.spec import DATE, FLAG, REAL, WHOLE, WORD, Attr, Child, ElementSpec
from rtkit.profile.tree_form import (
    CONDITION,
    DATE_PARTS,
    FOREIGN_ATTRIBUTES,
    FOREIGN_ELEMENTS,
    OWN_KEYS,
    ROOTS,
    WAITS,
    key_of,
)
from rtkit.profile.xmlnames import NAMESPACES, RTKIT, clark, split

SCHEMAS = Path(__file__).resolve().parent.parent / "schemas"
KINDS = {"rtc": RTC_PROFILE, "rts": RTS_PROFILE}
Tree = dict[str, Any]

_XS = "{http://www.w3.org/2001/XMLSchema}"
_LARGEST = 10**18 - 1
_TEXT = "^[^\\u0000-\\u0008\\u000b\\u000c\\u000e-\\u001f\\ufffe\\uffff]*$"
_TEXTS = {
    "description": "rtkit::if, rtkit::unless, or rtkit's own value of another attribute.",
    "$ref": "#/$defs/text",
}
_DATE_TEXT = (
    "^(?!0000)[0-9]{4}-[0-9]{2}-[0-9]{2}T([01][0-9]|2[0-3]):[0-5][0-9]:[0-5][0-9]"
    "(\\.[0-9]{1,12})?(Z|[+-]((0[0-9]|1[0-3]):[0-5][0-9]|14:00))?$"
)
_DATE_BOUNDS = {
    "year": (1, 9999),
    "month": (1, 12),
    "day": (1, 31),
    "hour": (0, 23),
    "minute": (0, 59),
    "second": (0, 59),
    "timezone": (-840, 840),
    "millisecond": (0, 999),
}
_DATE_TEXTS = {
    "timezone": "Distance from UTC in minutes; absent where the date has none.",
    "fractionalSecond": "Part of a second, from 0 to 1.",
    "millisecond": "Part of a second in milliseconds, where fractionalSecond is absent.",
}


def main(folder: Path) -> None:
    """Write the schemas to `folder`."""
    for name, text in made().items():
        (folder / name).write_text(text, encoding="utf-8")


def made() -> dict[str, str]:
    """Return the text of each schema by the name of its file."""
    return {
        f"{kind.capitalize()}Profile.schema.json": json.dumps(
            _Maker(kind).schema(spec), indent=2, ensure_ascii=False
        )
        + "\n"
        for kind, spec in KINDS.items()
    }


class _Texts:
    """What the XML schemas say about types, elements and attributes."""

    def __init__(self, kind: str) -> None:
        self._global: dict[tuple[str, str], Any] = {}
        for file in sorted(SCHEMAS.glob(f"{kind.capitalize()}Profile*.xsd")):
            root = etree.parse(file).getroot()
            for item in root.iterchildren(f"{_XS}*"):
                name = f"{{{root.get('targetNamespace')}}}{item.get('name')}"
                self._global[split(item.tag)[1], name] = item

    def about(self, item: Any) -> str:
        """Return the documentation of a declaration, on one line."""
        return " ".join(item.findtext(f"{_XS}annotation/{_XS}documentation", "").split())

    def element(self, name: str, parent: Any) -> Any:
        """Return the declaration of an element in a type, or the global one."""
        return self._find("element", name, parent)

    def attribute(self, name: str, parent: Any) -> Any:
        """Return the declaration of an attribute in a type, or the global one."""
        return self._find("attribute", name, parent)

    def type_of(self, element: Any) -> Any:
        """Return the type of an element; None for plain text."""
        return self.type_named(self._resolved(element, element.get("type")))

    def type_named(self, name: str) -> Any:
        """Return a type by ``{namespace}local``; None where it is none of these schemas'."""
        return self._global.get(("complexType", name))

    def _find(self, what: str, name: str, parent: Any) -> Any:
        local = split(name)[1]
        for place in self._with_bases(parent):
            for item in place.iter(f"{_XS}{what}"):
                namespace = place.getroottree().getroot().get("targetNamespace")
                if item.get("name") == local and split(name)[0] == namespace:
                    return item
        return self._global[what, name]

    def _with_bases(self, type_: Any) -> Iterator[Any]:
        while type_ is not None:
            yield type_
            extension = type_.find(f".//{_XS}extension")
            base = None if extension is None else self._resolved(extension, extension.get("base"))
            type_ = None if base is None else self.type_named(base)

    @staticmethod
    def _resolved(item: Any, name: str) -> str:
        prefix, _, local = name.rpartition(":")
        return f"{{{item.nsmap[prefix or None]}}}{local}"


class _Maker:
    """One schema in the making."""

    def __init__(self, kind: str) -> None:
        self._kind = kind
        self._texts = _Texts(kind)
        self._definitions: dict[str, Tree] = {}

    def schema(self, spec: ElementSpec) -> Tree:
        tag = clark(f"{self._kind}:{self._kind.capitalize()}Profile")
        element = self._texts.element(tag, None)
        body = self._reference(spec, tag, self._texts.type_of(element))
        shared = _shared()
        return {
            "$schema": "https://json-schema.org/draft/2020-12/schema",
            "$id": f"urn:rtkit:{self._kind}-profile",
            "title": f"{self._kind.upper()} profile as JSON or YAML",
            "description": "What rtkit writes. It reads what differs in form, too, and notes it.",
            "type": "object",
            "properties": {
                "$schema": {"description": "For editors; ignored.", "type": "string"},
                ROOTS[self._kind]: {"description": self._texts.about(element), **body},
            },
            "required": [ROOTS[self._kind]],
            "additionalProperties": False,
            "$defs": dict(sorted((self._definitions | shared).items())),
        }

    def _reference(self, spec: ElementSpec, tag: str, type_: Any) -> Tree:
        name = type_.get("name")
        # Of all documentation there is one type in XML, but each class has its own keys.
        name = f"{_prefix(type_)}.{spec.make.__name__ if name == 'doc' else name}"
        if name not in self._definitions:
            self._definitions[name] = {}
            self._definitions[name] = self._definition(spec, tag, type_)
        return {"$ref": f"#/$defs/{name}"}

    def _definition(self, spec: ElementSpec, tag: str, type_: Any) -> Tree:
        properties: Tree = {}
        for item in spec.attributes:
            about = self._texts.about(self._texts.attribute(item.name, type_))
            properties[key_of(item.name, tag)] = {"description": about, **_value(item)}
        waits: Tree = {}
        for part in spec.children:
            is_wait = spec.make is OrderStep and part.field in WAITS
            (waits if is_wait else properties)[key_of(part.name, tag)] = self._part(part, type_)
        rules: Tree = {
            "required": [key_of(item.name, tag) for item in spec.attributes if item.required]
        }
        for keys in _alternatives(spec, tag):
            if len(keys) == 1:
                rules["required"] += keys
            else:
                rules["oneOf"] = [{"required": [key]} for key in keys]
        if waits:
            properties[CONDITION] = {
                "description": "What to wait for: one of the two.",
                "type": "object",
                "properties": waits,
                "oneOf": [{"required": [key]} for key in waits],
                "additionalProperties": False,
            }
            rules["required"].append(CONDITION)
        properties[FOREIGN_ATTRIBUTES] = {"$ref": "#/$defs/foreign.attributes"}
        properties[FOREIGN_ELEMENTS] = {"$ref": "#/$defs/foreign.elements"}
        own = "^(if|unless)$" if split(tag)[0] == RTKIT else f"^{OWN_KEYS}(?!variable$|include$)"
        return {
            "description": self._texts.about(type_),
            "type": "object",
            "properties": properties,
            **({"patternProperties": {own: _TEXTS}} if self._kind == "rts" else {}),
            **{key: rule for key, rule in rules.items() if rule},
            "additionalProperties": False,
        }

    def _part(self, part: Child, parent: Any) -> Tree:
        element = self._texts.element(part.name, parent)
        about = {"description": self._texts.about(element)}
        if part.spec is None:
            one: Tree = {"$ref": "#/$defs/text"}
        else:
            given = part.spec.xsi_type
            type_ = (
                self._texts.type_of(element)
                if given is None
                else self._texts.type_named(f"{{{given[0]}}}{given[1]}")
            )
            one = self._reference(part.spec, part.name, type_)
        if not part.is_many:
            return about | one
        counts = {"minItems": part.least} if part.least else {}
        if element.get("minOccurs") is None and element.get("maxOccurs") is None and part.least:
            counts["maxItems"] = 1
        return about | {"type": "array", "items": one} | counts


def _prefix(type_: Any) -> str:
    namespace = type_.getroottree().getroot().get("targetNamespace")
    return next(prefix for prefix, uri in NAMESPACES.items() if uri == namespace)


def _alternatives(spec: ElementSpec, tag: str) -> list[list[str]]:
    """Return the keys of which one must be there, for each field that needs one."""
    found: dict[str, list[str]] = {}
    for part in spec.children:
        if part.least:
            found.setdefault(part.field, []).append(key_of(part.name, tag))
    return list(found.values())


def _value(item: Attr) -> Tree:
    if item.kind == WORD:
        return {"enum": list(item.words)}
    kinds: dict[str, Tree] = {
        FLAG: {"type": "boolean"},
        REAL: {"type": "number"},
        WHOLE: {"type": "integer", "minimum": -_LARGEST, "maximum": _LARGEST},
        DATE: {"$ref": "#/$defs/date"},
    }
    return kinds.get(item.kind, {"$ref": "#/$defs/text"})


def _shared() -> dict[str, Tree]:
    parts: Tree = {}
    for part in DATE_PARTS:
        low, high = _DATE_BOUNDS.get(part, (0, 0))
        kind = {"type": "integer", "minimum": low, "maximum": high}
        if part == "fractionalSecond":
            kind = {"type": "number", "minimum": 0, "exclusiveMaximum": 1}
        parts[part] = {"description": _DATE_TEXTS.get(part, f"The {part}."), **kind}
    table = {
        "type": "object",
        "properties": parts,
        "required": list(DATE_PARTS[:3]),
        "additionalProperties": False,
    }
    text = {"$ref": "#/$defs/text"}
    element = {
        "name": {"description": "Its name, as {namespace}name.", "type": "string", "minLength": 1},
        "attributes": {"$ref": "#/$defs/foreign.attributes"},
        "text": {"description": "Text before the first child.", **text},
        "tail": {"description": "Text after the element.", **text},
        "children": {"$ref": "#/$defs/foreign.elements"},
    }
    return {
        "text": {"description": "A text that XML can hold.", "type": "string", "pattern": _TEXT},
        "date": {
            "description": "A date and time, as a table of its parts or as text.",
            "oneOf": [table, {"type": "string", "pattern": _DATE_TEXT}],
        },
        "foreign.attributes": {
            "description": "Attributes that no profile format knows, by {namespace}name.",
            "type": "object",
            "additionalProperties": text,
        },
        "foreign.elements": {
            "description": "Elements that no profile format knows.",
            "type": "array",
            "items": {
                "type": "object",
                "properties": element,
                "required": ["name"],
                "additionalProperties": False,
            },
        },
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else SCHEMAS)
