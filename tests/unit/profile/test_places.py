"""Each finding says where: an XPath that selects what it is about in the document as read."""

from __future__ import annotations

import os.path
import re
from pathlib import Path
from typing import Any

import pytest
from corpus import ROOT, corpus, needs_corpus
from lxml import etree
from profile_reading import profile_kind

from rtkit.profile.common import Note
from rtkit.profile.findings import ElementPaths, Findings, InvalidProfile
from rtkit.profile.parse import parse
from rtkit.profile.read import read_rtc, read_rts
from rtkit.profile.rules import RULES
from rtkit.profile.xmlnames import NAMESPACES, clark

RTS = NAMESPACES["rts"]
HEAD = (
    f'<rts:RtsProfile xmlns:rts="{RTS}" xmlns:rtsExt="{RTS}_ext" rts:id="i" rts:version="0.2"'
    ' rts:creationDate="2020-01-01T00:00:00" rts:updateDate="2020-01-01T00:00:00">\n'
)
COMPONENT = (
    '<rts:Components xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
    'xsi:type="rtsExt:component_ext" rts:id="RTC:v:c:A:1" rts:instanceName="{}" rts:pathUri="" {}>'
    "{}</rts:Components>\n"
)


def notes(data: bytes) -> list[Note]:
    """All that is found, in lenient and strict reading."""
    read = read_rts if profile_kind(data) == "rts" else read_rtc
    found: list[Note] = []
    for strict in (False, True):
        try:
            found += read(data, "a.xml", strict=strict).notes  # type: ignore[attr-defined]
        except InvalidProfile as error:
            found += error.problems
    return list(dict.fromkeys(found))


def selected(root: Any, path: str) -> list[Any]:
    prefixes = {prefix: NAMESPACES[prefix] for prefix in NAMESPACES}
    chosen: list[Any] = root.getroottree().xpath(path, namespaces=prefixes)
    return chosen


@needs_corpus
@pytest.mark.parametrize("file", list(map(str, corpus("rtc/*", "rts/*"))), ids=os.path.basename)
def test_paths_select_what_findings_are_about(file: str) -> None:
    with open(file, "rb") as stream:
        data = stream.read()
    root = parse(data, file)
    for note in notes(data):
        assert note.rule in RULES
        chosen = selected(root, note.path)
        assert len(chosen) == 1, note
        element = chosen[0].getparent() if "/@" in note.path else chosen[0]
        assert element.sourceline == note.line
        if "/@" in note.path and note.rule != "attribute-name":
            assert str(chosen[0]) == note.found


def test_a_bad_value_tells_what_is_there_and_what_may_be() -> None:
    body = COMPONENT.format("A", "rts:isRequired='maybe'", "")
    data = f"{HEAD}{body}</rts:RtsProfile>"
    (note,) = notes(data.encode())
    assert note == Note(
        2,
        "rts:isRequired is 'maybe'; allowed: true, false, 1, 0",
        "/rts:RtsProfile/rts:Components/@rts:isRequired",
    )
    assert (note.rule, note.found, note.allowed) == ("bad-value", "maybe", "true, false, 1, 0")


def test_what_is_absent_is_found_at_its_element() -> None:
    body = COMPONENT.format("A", "", "") + COMPONENT.format("B", "", "")
    second = notes(f"{HEAD}{body}</rts:RtsProfile>".encode())[1]
    assert (second.line, second.path) == (3, "/rts:RtsProfile/rts:Components[2]")
    assert (second.rule, second.found, second.allowed) == (
        "absent-attribute",
        None,
        "true, false, 1, 0",
    )


def test_equal_findings_on_one_line_are_told_apart_by_their_path() -> None:
    ports = "<rts:DataPorts rts:name='a'/><rts:DataPorts rts:name='b'/>"
    body = COMPONENT.format("A", "rts:isRequired='true'", ports)
    found = notes(f"{HEAD}{body}</rts:RtsProfile>".encode())
    assert [note.path.rpartition("/")[2] for note in found] == [
        "rts:DataPorts[1]",
        "rts:DataPorts[2]",
    ]


def test_numbers_are_those_before_any_repair() -> None:
    root = parse(b"<a><b/><c/><b/><c><d/></c></a>", "x")
    places = ElementPaths()
    first, second, third, fourth = root
    assert places.path(fourth) == "/a/c[2]"
    root.remove(second)
    fourth.tag = "b"
    assert places.path(third) == "/a/b[2]"
    assert places.path(fourth[0]) == "/a/c[2]/d"
    assert places.path(first, "z") == "/a/b[1]/@z"


def test_what_a_repair_added_is_found_where_its_reason_is() -> None:
    root = parse(b"<a><b><c/></b></a>", "x")
    found = Findings("x.xml")
    added = found.add(root, "b", root[0][0])
    below = etree.SubElement(added, "e")
    for element in (added, below, root[0]):
        found.repaired(element, "bad-value", "text", at="z")
    assert [note.path for note in found.repairs] == ["/a/b/c", "/a/b/c", "/a/b/@z"]


def test_a_lifted_element_keeps_the_path_that_it_had() -> None:
    root = parse(b"<a><b><c/></b><d/></a>", "x")
    places = ElementPaths()
    lifted = root[0][0]
    assert places.path(lifted) == "/a/b/c"
    root.append(lifted)
    assert places.path(lifted) == "/a/b/c"
    assert places.path(root[1]) == "/a/d"


@pytest.mark.parametrize("namespace", ["urn:x", "urn:o'x"])
def test_foreign_names_are_selected_too(namespace: str) -> None:
    root = etree.Element(clark("rts:RtsProfile"))
    for value in "12":
        etree.SubElement(root, f"{{{namespace}}}part").set(f"{{{namespace}}}key", value)
    path = ElementPaths().path(root[1], f"{{{namespace}}}key")
    assert selected(root, path) == ["2"]


def test_the_first_of_too_many_errors_are_kept() -> None:
    bad = '<rts:Components rts:id="a" rts:instanceName="b" rts:isRequired="maybe"/>\n' * 2000
    with pytest.raises(InvalidProfile) as caught:
        read_rts(f"{HEAD}{bad}</rts:RtsProfile>".encode(), "a.xml")
    assert len(caught.value.problems) == 1001
    assert str(caught.value).endswith("a.xml: … and 951 more problems")


def test_every_rule_that_is_told_is_in_the_table() -> None:
    told: set[str] = set()
    for file in (Path(ROOT) / "rtkit" / "profile").rglob("*.py"):
        if file.name != "rules.py":
            text = file.read_text(encoding="utf-8")
            told |= set(re.findall(r'"([a-z]+(?:-[a-z]+)+|[a-z]+)"', text))
    assert set(RULES) <= told
