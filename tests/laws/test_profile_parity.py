"""Law of the schemas: lxml and xmlschema judge every document alike, whatever was done to it."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import xmlschema
from corpus import corpus, needs_corpus
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from lxml import etree

from rtkit.profile.xmlnames import NAMESPACES, XSI, XSI_TYPE
from rtkit.resources import resource

ROUNDS = int(os.environ.get("RTKIT_FUZZ", "200"))
SAMPLES = Path(__file__).parents[1] / "unit" / "profile" / "samples"
REAL = corpus("rtc/*", "rts/*")
TEXTS = """||x|true|TRUE|1|0| 1 |+1|-0|01|1.|.5|1e3|1E999|INF|-INF|NaN|0x1|1 2|123456789012345678
1234567890123456789|2024-02-29T00:00:00|2023-02-29T00:00:00|2024-13-01T00:00:00|2024-01-01T24:00:00
2024-01-01T23:59:60|2024-01-01T00:00:00+14:00|2024-01-01T00:00:00+14:01|2024-01-01T00:00:00-00:00
2024-01-01T00:00:00.1234567890123|-2024-01-01T00:00:00|12024-01-01T00:00:00|0000-01-01T00:00:00
2024-01-01|2024-01-01T00:00:00z| 2024-01-01T00:00:00 |LEFT|left|LEFT |DOWN|None|STATIC|PERIODIC
DataInPort|SYNC|Provided|rtsExt:component_ext|rtsExt:dataport_ext|rtcExt:dataport_ext|rts:component
rtcDoc:dataport_doc|rtcDoc:basic_info_doc|rtsExt:nothing|nowhere:x|xs:string|a b|日本"""
VALUES = st.sampled_from(
    ["\u0661", *(text for line in TEXTS.split("\n") for text in line.split("|"))]
)
NUMBER = st.integers(0, 10**6)
SPACES = (*NAMESPACES.values(), "urn:new", "")
NIL = f"{{{XSI}}}nil"
OTHERS = (
    NIL,
    f"{{{XSI}}}schemaLocation",
    f"{{{XSI}}}noNamespaceSchemaLocation",
    f"{{{XSI}}}what",
    "{http://www.w3.org/XML/1998/namespace}lang",
    "{http://www.w3.org/XML/1998/namespace}space",
    "{http://www.w3.org/XML/1998/namespace}base",
    XSI_TYPE,
)
WAYS = ("drop", "double", "swap", "move", "copy", "rename", "space", "text", "tail", "new", "new")
WAYS += ("unset", "set", "set", "set", "respace", "lend", "other", "type")
CHANGES = st.lists(st.tuples(st.sampled_from(WAYS), NUMBER, NUMBER, VALUES), min_size=1, max_size=4)


def local(name: str) -> str:
    return etree.QName(name).localname


def named(namespace: str, name: str) -> str:
    return f"{{{namespace}}}{name}" if namespace else name


def change(root: Any, how: str, which: int, what: int, value: str) -> None:
    """Do one thing to the tree; `which` picks an element, `what` a place, a name or another.

    The root keeps its name: a document with another root is refused before any schema sees it.
    """
    every = list(root.iter(etree.Element))
    element, other = every[which % len(every)], every[what % len(every)]
    space = SPACES[what % len(SPACES)]
    if how == "text":
        element.text = value
    elif how == "tail" and element is not root:
        element.tail = value
    elif how in ("rename", "space") and element is root:
        return
    elif how == "rename":
        element.tag = other.tag
    elif how == "space":
        element.tag = named(space, local(element.tag))
    elif how == "new":
        element.insert(what % 3, etree.Element(named(space, local(other.tag)), {"k": value}))
    elif how == "copy":
        element.append(copied(other))
    elif element is not root and how in ("drop", "double", "swap", "move"):
        place(element, other, how)
    else:
        attribute(element, other, how, what, value)


def place(element: Any, other: Any, how: str) -> None:
    parent = element.getparent()
    if how == "drop":
        parent.remove(element)
    elif how == "double":
        element.addnext(copied(element))
    elif how == "swap":
        parent.insert(0, element)
    elif other not in set(element.iter()):
        other.append(element)


def attribute(element: Any, other: Any, how: str, what: int, value: str) -> None:
    names = sorted(element.attrib) or ["none"]
    name = names[what % len(names)]
    if how == "unset":
        element.attrib.pop(name, None)
    elif how == "set":
        element.set(name, value)
    elif how == "respace":
        element.set(named(SPACES[what % len(SPACES)], local(name)), element.attrib.pop(name, value))
    elif how == "lend":
        for lent, text in other.attrib.items():
            element.set(lent, text)
    elif how == "other":
        element.set(OTHERS[what % len(OTHERS)], value)
    elif how == "type":
        element.set(XSI_TYPE, value)


def copied(element: Any) -> Any:
    return etree.fromstring(etree.tostring(element, with_tail=False))


@cache
def schemas(kind: str) -> tuple[etree.XMLSchema, xmlschema.XMLSchema10]:
    path = resource("schemas", f"{kind}Profile.xsd")
    return etree.XMLSchema(file=path), xmlschema.XMLSchema10(path)


def verdicts(data: bytes) -> tuple[bool, bool]:
    """What lxml and xmlschema say; each gets a tree of its own."""
    kind = "Rts" if b"RtsProfile" in data else "Rtc"
    quick, full = schemas(kind)
    return quick.validate(etree.fromstring(data)), slow(full, etree.fromstring(data))


def slow(full: xmlschema.XMLSchema10, root: Any) -> bool:
    try:
        return bool(full.is_valid(root, use_location_hints=False))
    except KeyError:
        return False  # its way to say that xsi:type is empty


@needs_corpus
@pytest.mark.parametrize("file", REAL, ids=lambda file: f"{file.parent.name}/{file.name[-50:]}")
def test_real_documents(file: Path) -> None:
    one, other = verdicts(file.read_bytes())
    assert one == other


@given(st.sampled_from(("rtc", "rts")), CHANGES)
@example("rts", [("other", 10364, 0, "\u0661")])
@settings(deadline=None, max_examples=ROUNDS, suppress_health_check=[HealthCheck.too_slow])
def test_samples_with_changes(kind: str, changes: list[tuple[str, int, int, str]]) -> None:
    agreed((SAMPLES / f"{kind}.xml").read_bytes(), changes)


@needs_corpus
@given(NUMBER, CHANGES)
@settings(deadline=None, max_examples=ROUNDS, suppress_health_check=[HealthCheck.too_slow])
def test_real_documents_with_changes(which: int, changes: list[tuple[str, int, int, str]]) -> None:
    agreed(REAL[which % len(REAL)].read_bytes(), changes)


def agreed(data: bytes, changes: list[tuple[str, int, int, str]]) -> None:
    root = etree.fromstring(data)
    for one in changes:
        change(root, *one)
    # libxml2 does not look at xsi:nil where a schema allows whatever another one declares.
    for element in root.iter(etree.Element):
        if etree.QName(element).namespace not in NAMESPACES.values():
            element.attrib.pop(NIL, None)
    quick, full = verdicts(etree.tostring(root))
    assert quick == full
