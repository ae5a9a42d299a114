"""Documents made to harm are refused at once, and nothing else is opened."""

from __future__ import annotations

import os
import os.path
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from profile_reading import explain

from rtkit.errors import InvalidDocument
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.parse import MAX_BYTES, MAX_DEPTH
from rtkit.profile.read import read_rtc, read_rts

RTS = "http://www.openrtp.org/namespaces/rts"
ROOT = (
    f'<r:RtsProfile xmlns:r="{RTS}" r:id="RTSystem:a:b:1" r:version="0.2" '
    'r:creationDate="2020-01-01T00:00:00" r:updateDate="2020-01-01T00:00:00"'
)
PLAIN = f"{ROOT}/>"
CHECKOUT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", ".."))
BOMB = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 12))


def refused(data: bytes, match: str) -> InvalidProfile:
    with pytest.raises(InvalidDocument, match=match) as caught:
        read_rts(data, "evil.xml")
    assert isinstance(caught.value, InvalidProfile)
    assert str(caught.value).startswith("evil.xml:")
    return caught.value


def test_the_plain_document_is_accepted() -> None:
    assert read_rts(PLAIN.encode(), strict=True).profile.id == "RTSystem:a:b:1"


@pytest.mark.parametrize(
    "declaration",
    [
        "<!DOCTYPE bad>",
        "<!DOCTYPE\nbad [<!ENTITY x 'y'>]>",
        "<!DOCTYPE bad SYSTEM 'http://127.0.0.1:9/x.dtd'>",
        "<!DOCTYPE bad PUBLIC '-//X' 'x.dtd'>",
        f'<!DOCTYPE bad [<!ENTITY e0 "ha">{BOMB}]>',
        '<!DOCTYPE bad [<!ENTITY % p SYSTEM "file:///etc/passwd"> %p;]>',
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-be", "utf-16-le"])
def test_any_doctype_is_refused_by_name(declaration: str, encoding: str) -> None:
    head = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?>\n<!-- <!-x -->\n'
    data = f"{head}{declaration}{PLAIN}".encode(encoding)
    refused(data, "^evil.xml:3: DOCTYPE bad is not allowed")


def test_doctype_hidden_by_a_strange_encoding() -> None:
    head = b'<?xml version="1.0" encoding="UTF-7"?>'
    refused(head + b"+ADwAIQ-DOCTYPE bad+AD4-" + PLAIN.encode(), "DOCTYPE|not well-formed")


def test_doctype_in_a_comment_or_text_is_harmless() -> None:
    data = f"<!-- <!DOCTYPE bad> -->{PLAIN}".encode()
    assert read_rts(data).notes == ()


@pytest.fixture
def trap(tmp_path: Path) -> Iterator[Path]:
    """A pipe that would lose its content, and hold up its reader, if anybody opened it."""
    path = tmp_path / "trap.xsd"
    os.mkfifo(path)
    own = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    os.write(own, b"untouched")
    yield path
    try:
        assert os.read(own, 100) == b"untouched"
    finally:
        os.close(own)


def test_no_external_entity_is_opened(trap: Path) -> None:
    data = f'<!DOCTYPE d [<!ENTITY x SYSTEM "file://{trap}">]>{ROOT}>&x;</r:RtsProfile>'
    assert "untouched" not in str(refused(data.encode(), "DOCTYPE d is not allowed"))


def test_schema_hints_of_the_document_open_nothing(trap: Path) -> None:
    xsi = "http://www.w3.org/2001/XMLSchema-instance"
    hint = f'xsi:schemaLocation="{RTS} {trap} urn:x {trap}" xsi:noNamespaceSchemaLocation="{trap}"'
    data = f'{ROOT} xmlns:xsi="{xsi}" {hint}><f:x xmlns:f="urn:x" {hint}/></r:RtsProfile>'
    reading = read_rts(data.encode())
    assert explain(data.encode(), kind="rts") == ()
    assert reading.profile.foreign.elements[0].attributes == ()


@pytest.mark.parametrize("depth", [MAX_DEPTH + 1, 250, 1_000, 100_000, 1_000_000])
def test_deep_nesting(depth: int) -> None:
    data = f'{ROOT}><f:a xmlns:f="urn:f">'.encode() + b"<a>" * depth + b"</a>" * depth
    refused(
        data + b"</f:a></r:RtsProfile>",
        "nested deeper|not well-formed: Excessive depth in document: 256$|more tags",
    )


def test_nesting_up_to_the_limit_is_read() -> None:
    inner = MAX_DEPTH - 1
    opened, closed = '<f:a xmlns:f="urn:f">' * inner, "</f:a>" * inner
    data = f"{ROOT}>{opened}{closed}</r:RtsProfile>"
    reading = read_rts(data.encode())
    depth, element = 0, reading.profile.foreign.elements
    while element:
        depth, element = depth + 1, element[0].children
    assert depth == inner


def test_nested_constraints_are_bounded() -> None:
    rtc = "http://www.openrtp.org/namespaces/rtc"
    opened = "<Constraint><ConstraintUnitType><Not>" * 25
    closed = "</Not></ConstraintUnitType></Constraint>" * 25
    data = f'<RtcProfile xmlns="{rtc}"><ConstraintSet/><ConfigurationSet><Configuration>{opened}'
    data += f"{closed}</Configuration></ConfigurationSet></RtcProfile>"
    with pytest.raises(InvalidProfile, match="nested deeper than 64"):
        read_rtc(data.encode(), "evil.xml")


def test_too_large() -> None:
    refused(b" " * (MAX_BYTES + 1), f"more than {MAX_BYTES} bytes")


def test_too_many_tags() -> None:
    refused(f"{ROOT}>".encode() + b"<a/>" * 200_000 + b"</r:RtsProfile>", "more tags")


@pytest.mark.parametrize("end", [0, 1, 5, 40, 100, len(PLAIN) - 1])
def test_truncated(end: int) -> None:
    refused(PLAIN[:end].encode(), "evil.xml:1: not well-formed: .")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\0" * 100,
        PLAIN.replace("RTSystem", "RT\0System").encode(),
        PLAIN.replace("RTSystem", "RT&#0;System").encode(),
        PLAIN.replace("RTSystem", "RT\x1bSystem").encode(),
        PLAIN.replace("RTSystem", "&nbsp;").encode(),
        b"\xff\xfe" + PLAIN.encode(),
        PLAIN.replace("RTSystem", "日本").encode("shift_jis"),
        b'<?xml version="1.0" encoding="no-such"?>' + PLAIN.encode(),
        b'<?xml version="1.0" encoding="UTF-16"?>' + PLAIN.encode(),
        PLAIN.encode() + PLAIN.encode(),
        PLAIN.encode() + b"trailing",
        b"rtsProfile: {id: x}",
        b"\x80\x04\x95pickle",
    ],
)
def test_not_well_formed(data: bytes) -> None:
    problem = refused(data, "not well-formed")
    assert len(str(problem).splitlines()) == 1


def test_the_line_of_a_fault_is_told() -> None:
    refused(f"{ROOT}>\n<a>\n</b>\n</r:RtsProfile>".encode(), "^evil.xml:3: not well-formed")


@pytest.mark.parametrize("namespace", ["", ' xmlns="urn:other"', f' xmlns="{RTS}_ext"'])
def test_root_of_another_namespace(namespace: str) -> None:
    refused(f"\n<RtsProfile{namespace}/>".encode(), f"evil.xml:2: root is .*RtsProfile.*{RTS}")


def test_the_wrong_kind_of_profile() -> None:
    refused(
        b'<RtcProfile xmlns="http://www.openrtp.org/namespaces/rtc"/>',
        "root is rtc:RtcProfile; it must be RtsProfile",
    )


def test_a_flood_of_problems_is_cut_short() -> None:
    lines = "\n<r:Components/>" * 140_000
    problem = refused(f"{ROOT}>{lines}</r:RtsProfile>".encode(), "and 951 more problems$")
    assert len(problem.problems) == 1001
    assert len(str(problem).splitlines()) == 51


@pytest.mark.parametrize(
    "inside",
    [
        "<r:Components r:instanceName='a' r:id='b' r:pathUri='' r:isRequired='?'/>",
        "<r:DataPortConnectors r:connectorId='a' r:name='b'/>",
        "x<r:Groups r:groupId='a'/>",
        "<f:a xmlns:f='urn:f' {many}/>",
        "<r:Systems {many}/>",
    ],
)
def test_floods_of_one_fault_end_before_the_schema_sees_them(inside: str) -> None:
    many = " ".join(f"a{number}=''" for number in range(300))
    data = f"{ROOT}>{inside.format(many=many) * 1200}</r:RtsProfile>"
    with pytest.raises(InvalidProfile) as caught:
        read_rts(data.encode())
    assert 1 <= len(caught.value.problems) <= 1001


CHILD = """
import sys
from rtkit.errors import InvalidDocument
from rtkit.profile.read import read_rts
refused = 0
for line in sys.stdin:
    head, unit, count, tail = line.rstrip("\\n").split("|")
    try:
        read_rts((head + unit * int(count) + tail).encode())
    except InvalidDocument:
        refused += 1
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(refused, int(peak.split()[1]) // 1024)
"""


@pytest.mark.skipif(not os.path.exists("/proc/self/status"), reason="needs /proc")
def test_memory_stays_bounded() -> None:
    end = "</r:RtsProfile>"
    documents = [
        f'{ROOT} r:abstract="|a|{11 * 2**20}|"/>',
        f"{ROOT}>|x|{11 * 2**20}|{end}",
        f"{ROOT}>|<a/>|149000|{end}",
        f"{ROOT}>|<r:Components/>|149000|{end}",
        f'{ROOT} xmlns:f="urn:f">|<f:a b="1" c="2"/>|145000|{end}',
        f"{ROOT}>|<a>|1000000|{end}",
        '<!DOCTYPE d [<!ENTITY a "|a|10000000|">]><d>&a;</d>',
    ]
    done = subprocess.run(
        [sys.executable, "-c", CHILD],
        input="\n".join(documents),
        capture_output=True,
        text=True,
        check=True,
        cwd=CHECKOUT,
    )
    refused_count, megabytes = map(int, done.stdout.split())
    assert refused_count == 5
    assert megabytes < 200
