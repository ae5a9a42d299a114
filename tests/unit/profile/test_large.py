"""Long documents: lines beyond what libxml2 keeps, blanks that are dropped, and what it costs."""

from __future__ import annotations

import runpy
import time
from pathlib import Path
from typing import Any

import pytest
from lxml import etree

from rtkit.profile.examine import examine
from rtkit.profile.findings import FAR_LINE, InvalidProfile
from rtkit.profile.read import read_profile, read_rts
from rtkit.profile.write import write_profile
from rtkit.resources import resource

ROOT = Path(__file__).parents[3]
RTS = "http://www.openrtp.org/namespaces/rts"
HEAD = (
    f'<r:RtsProfile xmlns:r="{RTS}" xmlns:e="{RTS}_ext" r:id="i" r:version="0.2" '
    'r:creationDate="2020-01-01T00:00:00" r:updateDate="2020-01-01T00:00:00">'
)
PROMISED_RATIO, PROMISED_S, FORGIVEN = 5.0, 1.0, 10


def system(components: int, connectors: int) -> Any:
    make = runpy.run_path(str(ROOT / "bench" / "synthetic.py"))["system"]
    return make(components, connectors)


def group(name: str) -> str:
    member = '<r:Members r:componentId="a" r:instanceName="b"/>'
    return f'<r:Groups r:groupId="{name}">{member}</r:Groups>'


COMPONENT = '<r:Components r:id="a" r:pathUri="" r:instanceName="b" r:isRequired="true"/>'


@pytest.mark.parametrize("lines", [10, FAR_LINE - 10, FAR_LINE - 1, FAR_LINE, 3 * FAR_LINE])
def test_lines_of_xml(lines: int) -> None:
    text = f"{HEAD}\n{COMPONENT}" + "\n" * lines + "<r:What/>\n</r:RtsProfile>"
    (note,) = (note for note in read_rts(text).notes if "rts:What" in note.text)
    # Far down libxml2 knows the line of the text that follows, which may be the next one.
    assert note.line in (2 + lines, 2 + lines + (note.line > FAR_LINE))
    assert (2 + lines, note.text) in {(each.line, each.text) for each in examine(text).repairs}
    with pytest.raises(InvalidProfile, match=f":{note.line}: unknown element rts:What"):
        read_rts(text, strict=True)


@pytest.mark.parametrize("lines", [10, FAR_LINE - 10, FAR_LINE - 1, FAR_LINE, 3 * FAR_LINE])
def test_lines_of_yaml_and_json(lines: int) -> None:
    dates = '"creationDate": "2020-01-01T00:00:00", "updateDate": "2020-01-01T00:00:00"'
    head = f'{{"rtsProfile": {{"id": "i", "version": "0.2", {dates}, "components": ['
    text = head + "\n" * lines + '{"id": "a", "pathUri": "", "isRequired": true}]}}'
    for form in ("json", "yaml"):
        with pytest.raises(InvalidProfile) as caught:
            read_profile(text, form=form)
        (note,) = caught.value.problems
        assert (note.line, note.text) == (1 + lines, "rts:Components has no rts:instanceName")


def test_a_repeated_name_far_down_is_told_with_its_line() -> None:
    date = "{year: 2020, month: 1, day: 1}"
    text = f"rtsProfile:\n  id: i\n  version: '0.2'\n  creationDate: {date}\n  updateDate: {date}\n"
    text += "\n" * FAR_LINE + "  components:\n"
    for kind in "xyz":
        text += (
            f"  - {{id: {kind}, pathUri: '', instanceName: {min(kind, 'y')}, isRequired: true}}\n"
        )
    (note,) = read_rts(text).notes
    assert note.line == FAR_LINE + 9
    assert note.text == f"instance name y is also used on line {note.line - 1}"


@pytest.mark.parametrize(
    ("inside", "text"),
    [
        ("  x ", "  x "),
        ("   ", "   "),
        ("  <![CDATA[x]]>", "  x"),
        ("<![CDATA[ ]]>  x", "   x"),
        ("  <!-- c -->x", "  x"),
        ("  <?p i?>  ", "    "),
        ("  &lt; ", "  < "),
        (" &#32;&#10; ", "  \n "),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-le", "utf-8-sig"])
def test_blanks_in_texts_stay(inside: str, text: str, encoding: str) -> None:
    named = encoding.removesuffix("-sig")
    body = f"{HEAD}\n<e:VersionUpLogs>{inside}</e:VersionUpLogs>\n</r:RtsProfile>"
    document = f'<?xml version="1.0" encoding="{named}"?>\n{body}'
    assert read_rts(document.encode(encoding)).profile.version_up_logs == (text,)


def test_blanks_in_foreign_content_stay() -> None:
    inside = "<f:a> <f:b/> t <f:c>  </f:c></f:a>"
    profile = read_rts(f'{HEAD.replace(">", " xmlns:f=")}"urn:f">{inside}</r:RtsProfile>').profile
    (element,) = profile.foreign.elements
    assert (element.text, element.children[0].tail, element.children[1].text) == (None, " t ", "  ")


def test_a_large_system_costs_what_was_promised() -> None:
    """Told by the bench; here only a blunder would show."""
    data = write_profile(system(1000, 5000))
    schema = etree.XMLSchema(file=resource("schemas", "RtsProfile.xsd"))
    begin = time.perf_counter()
    assert schema.validate(etree.fromstring(data))
    middle = time.perf_counter()
    reading = read_profile(data)
    end = time.perf_counter()
    assert reading.notes == ()
    ratio = (end - middle) / (middle - begin)
    print(f"{len(data) / 1e6:.1f} MB read in {end - middle:.3f} s, {ratio:.1f} x lxml")
    assert ratio < PROMISED_RATIO * FORGIVEN
    assert end - middle < PROMISED_S * FORGIVEN
