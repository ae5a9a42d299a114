"""The full explanation, and what it costs those who do not ask for it."""

from __future__ import annotations

import os.path
import subprocess
import sys
from pathlib import Path

import pytest
from profile_reading import explain

from rtkit.profile import rts_spec
from rtkit.profile.examine import examine, objections
from rtkit.profile.read import read_rts
from rtkit.profile.write import write_profile

CHECKOUT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", ".."))
RTS = "http://www.openrtp.org/namespaces/rts"
PLAIN = (
    f'<r:RtsProfile xmlns:r="{RTS}" r:id="i" r:version="0.2" '
    'r:creationDate="2020-01-01T00:00:00" r:updateDate="2020-01-01T00:00:00"/>'
).encode()


def test_nothing_to_explain() -> None:
    assert explain(PLAIN) == ()


def test_faults_are_explained_with_line_and_path() -> None:
    data = PLAIN.replace(b"/>", b">\n<r:Components r:id='a'/></r:RtsProfile>")
    told = [(note.line, note.text) for note in explain(data, kind="rts")]
    assert (2, "rts:Components has no rts:instanceName") in told
    assert (
        2,
        "missing required attribute 'rts:instanceName'",
    ) in told


def test_what_only_the_schema_knows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rts_spec.RTS_PROFILE, "required_count", 0)
    (note,) = explain(PLAIN.replace(b' r:id="i"', b""))
    assert (note.path, note.text) == ("/rts:RtsProfile", "missing required attribute 'rts:id'")


def test_the_schema_objects_to_a_document_as_it_stands() -> None:
    data = PLAIN.replace(b"/>", b">\n<r:Components r:id='a' r:instanceName='b' r:isRequired='?'/>")
    notes = objections(data + b"</r:RtsProfile>")
    assert [(note.line, note.path, note.rule) for note in notes] == [
        (2, "/rts:RtsProfile/rts:Components", "schema")
    ] * len(notes)
    assert "missing required attribute 'rts:pathUri'" in [note.text for note in notes]
    assert objections(PLAIN) == objections(b"<cut") == ()


def test_the_schema_tells_what_it_expects() -> None:
    groups = PLAIN.replace(b"/>", b"><r:Groups r:groupId='g'/></r:RtsProfile>")
    (note,) = objections(groups)
    assert (note.path, note.allowed) == ("/rts:RtsProfile/rts:Groups", "rts:Members")
    preceding = b"<r:StartUp><r:targets r:sequence='1'><r:Preceding r:sendingTiming='X'/>"
    data = PLAIN.replace(b"/>", b">" + preceding + b"</r:targets></r:StartUp></r:RtsProfile>")
    allowed = [note.allowed for note in objections(data) if "sendingTiming" in note.text]
    assert allowed == ["SYNC, ASYNC, NO_SYNC"]


def test_an_examination_keeps_apart_what_it_found() -> None:
    port = b"<r:DataPorts r:name='o'/>"
    head, tail = b"<r:Components r:id='a' r:instanceName='b' r:pathUri='' r:isRequired='", b"'>"
    for flag, kinds in ((b"true", (0, 2, 0)), (b"?", (1, 2, 0))):
        body = b">" + head + flag + tail + port + b"</r:Components></r:RtsProfile>"
        found = examine(PLAIN.replace(b"/>", body), "a.xml")
        assert (len(found.errors), len(found.repairs), len(found.remarks)) == kinds
        assert found.kind == "rts"
        assert (found.profile is None) == bool(found.errors)
    assert examine(b"<a/>").kind == ""


def test_what_is_no_profile_is_told_too() -> None:
    (note,) = explain(PLAIN, kind="rtc")
    assert note.text.startswith("root is rts:RtsProfile; it must be RtcProfile")


def imported_by(code: str) -> set[str]:
    script = f"{code}\nimport sys; print(*sorted(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=CHECKOUT
    )
    return set(done.stdout.split())


def test_importing_the_room_imports_nothing_heavy() -> None:
    modules = imported_by(
        "import rtkit.profile.read, rtkit.profile.write, rtkit.profile.words, rtkit.resources"
    )
    heavy = {"lxml", "xmlschema", "rtkit.profile.rts_model", "rtkit.profile.rtc_model", "difflib"}
    assert not heavy & modules


def test_reading_never_imports_xmlschema() -> None:
    bad = "from rtkit.errors import InvalidDocument"
    modules = imported_by(
        f"{bad}\nfrom rtkit.profile.read import read_rts\nread_rts({PLAIN!r})\n"
        "try:\n    read_rts(b'<a/>')\nexcept InvalidDocument:\n    pass"
    )
    assert "lxml.etree" in modules
    assert not {"xmlschema", "elementpath", "rtkit.profile.rtc_model"} & modules


def test_a_form_costs_only_its_own_reader(tmp_path: Path) -> None:
    (tmp_path / "x.xml").write_bytes(PLAIN)
    for form, heavy in (("xml", {"yaml", "json"}), ("yaml", {"json"}), ("json", {"yaml"})):
        file = tmp_path / f"x.{form}"
        file.write_bytes(write_profile(read_rts(PLAIN).profile, form))
        modules = imported_by(f"import rtkit.profile.read as r; r.read_file({str(file)!r})")
        assert not heavy & modules, form


def test_validating_what_is_valid_never_imports_xmlschema(tmp_path: Path) -> None:
    file = tmp_path / "x.xml"
    file.write_bytes(PLAIN)
    modules = imported_by(
        "from rtkit.cli.profiles.rtprofile import main\n"
        f"assert not main(['validate', {str(file)!r}])"
    )
    assert "lxml.etree" in modules
    assert not {"xmlschema", "elementpath", "yaml"} & modules


def test_reading_is_possible_from_any_folder(
    tmp_path: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(str(tmp_path))
    assert read_rts(PLAIN).notes == ()
