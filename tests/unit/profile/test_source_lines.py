"""Findings are told at the lines where people look, also of tags over several lines."""

from __future__ import annotations

import pytest

from rtkit.profile.common import Note
from rtkit.profile.examine import at_their_lines, examine, objections

RTS = "http://www.openrtp.org/namespaces/rts"
DOCUMENT = f"""<?xml version="1.0" encoding="{{}}"?>
<rts:RtsProfile
    xmlns:rts="{RTS}" xmlns:rtsExt="{RTS}_ext"
    rts:id="i"
    rts:version="0.2" rts:creationDate="2020-01-01T00:00:00"
    rts:updateDate="yesterday">
  <!-- 日本 -->
  <rts:Components rts:id="RTC:v:c:A:1" rts:pathUri=""
      rts:instanceName="A"
      rts:isRequired
         ="maybe"
      foreign="1"
      ><rts:DataPorts
      rts:name="out"/></rts:Components>
</rts:RtsProfile>
"""
EXPECTED = [
    (6, "rts:updateDate is 'yesterday'"),
    (8, "xsi:type is absent: taken as 'rtsExt:component_ext'"),
    (10, "rts:isRequired is 'maybe'"),
    (12, "unknown attribute foreign dropped"),
    (13, "xsi:type is absent: taken as 'rtsExt:dataport_ext'"),
]


@pytest.mark.parametrize("encoding", ["utf-8", "shift_jis", "euc-jp"])
@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
def test_lines_are_those_of_tags_and_attributes(encoding: str, line_end: str) -> None:
    text = DOCUMENT.format(encoding).replace("\n", line_end)
    found = examine(text.encode(encoding), "a.xml")
    told = sorted((note.line, note.text) for note in (*found.errors, *found.repairs))
    assert [line for line, _ in told] == [line for line, _ in EXPECTED]
    assert all(text.startswith(start) for (_, text), (_, start) in zip(told, EXPECTED, strict=True))


def test_the_schema_is_told_at_the_same_lines() -> None:
    lines = {note.line for note in objections(DOCUMENT.format("utf-8").encode())}
    assert {2, 8} <= lines


def test_other_encodings_keep_the_lines_of_the_parser() -> None:
    found = examine(DOCUMENT.format("utf-16").encode("utf-16"), "a.xml")
    assert [note.line for note in found.errors] == [6, 13]


def test_what_cannot_be_found_keeps_its_line() -> None:
    notes = [Note(3, "a"), Note(1, "b", "/x/y"), Note(99, "c", "/x"), Note(0, "d", "/x")]
    assert at_their_lines(notes, b"<x>\n</x>") == notes


def test_foreign_names_are_found_too() -> None:
    data = b"<x>\n<n:part\n\n n:key='1'/></x>"
    path = "/x/*[local-name()='part' and namespace-uri()='urn:a/b']"
    key = "/@*[local-name()='key' and namespace-uri()='urn:a/b']"
    (one, other) = at_their_lines([Note(4, "a", path), Note(4, "b", path + key)], data)
    assert (one.line, other.line) == (2, 4)


def test_a_name_that_begins_alike_is_another() -> None:
    data = b"<x>\n<rts:DataPorts\n a='1'/>\n<rts:DataPortsMore\n b='1'/></x>"
    (note,) = at_their_lines([Note(3, "a", "/x/rts:DataPorts")], data)
    assert note.line == 2
