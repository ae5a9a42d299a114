"""Profiles as XML, YAML and JSON: found out, read, written, the same in all of them."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
import yaml
from corpus import corpus, needs_corpus
from lxml import etree
from profile_reading import explain, profile_kind

from rtkit.errors import Malformed, NotFound
from rtkit.profile.common import Note
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import FORMS, form_of, has_parameters
from rtkit.profile.read import read_file, read_profile, read_rtc, read_rts
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.rtc_spec import RTC_PROFILE
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.rts_spec import RTS_PROFILE
from rtkit.profile.spec import ElementSpec
from rtkit.profile.write import write_profile
from rtkit.profile.xmlnames import NAMESPACES
from rtkit.resources import resource

SAMPLES = Path(__file__).parent / "samples"
SHIPPED = sorted(Path(resource("profiles")).rglob("*.xml"))


PROFILES = [*SHIPPED, *corpus("rtc/*", "rts/*", "yaml/*")]


@pytest.mark.parametrize("file", PROFILES, ids=lambda file: f"{file.parent.name}/{file.name[-50:]}")
def test_a_profile_is_the_same_in_every_form(file: Path) -> None:
    profile = read_file(str(file)).profile
    told = []
    for form in FORMS:
        written = write_profile(profile, form)
        reading = read_profile(written, "x")
        assert reading.profile == profile, form
        assert write_profile(read_profile(written.decode()).profile, form) == written
        # Of a repeated name the line is told, which is another one in each form.
        told.append({re.sub("line [0-9]+", "", note.text) for note in reading.notes})
    assert told[0] == told[1] == told[2]


@pytest.mark.parametrize("file", PROFILES, ids=lambda file: f"{file.parent.name}/{file.name[-50:]}")
def test_the_short_way_and_the_long_way_read_alike(file: Path) -> None:
    reading = read_file(str(file))
    written = {form: write_profile(reading.profile, form) for form in FORMS}
    again = {form: read_profile(data, form=form) for form, data in written.items()}
    with patch("rtkit.profile.build.built", return_value=None):
        assert read_file(str(file)) == reading
        assert {form: read_profile(data, form=form) for form, data in written.items()} == again


@pytest.mark.parametrize(
    "file",
    [file for file in SHIPPED if not has_parameters(file.read_bytes())],
    ids=lambda file: file.name,
)
def test_what_is_shipped_goes_the_short_way(file: Path) -> None:
    with patch("rtkit.profile.normalise.normalise", side_effect=AssertionError):
        profile = read_file(str(file)).profile
        assert read_profile(write_profile(profile, "yaml")).profile == profile


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.name)
def test_other_readers_find_plain_data(file: Path) -> None:
    profile = read_file(str(file)).profile
    as_yaml = yaml.safe_load(write_profile(profile, "yaml"))
    assert as_yaml == json.loads(write_profile(profile, "json"))
    root = "rtsProfile" if isinstance(profile, RtsProfile) else "rtcProfile"
    assert list(as_yaml) == [root]
    assert as_yaml[root]["version"] == profile.version


@pytest.mark.parametrize("kind", ["rtc", "rts"])
@pytest.mark.parametrize("form", FORMS)
def test_the_samples_of_each_form(kind: str, form: str) -> None:
    """They hold every element and attribute there is; a form that was published stays."""
    profile = read_file(str(SAMPLES / f"{kind}.xml"), strict=True).profile
    sample = SAMPLES / f"{kind}.{form}"
    reading = read_file(str(sample))
    assert reading.profile == profile
    assert {note.rule for note in reading.notes} == {"foreign-kept"}
    assert write_profile(profile, form) == sample.read_bytes()


@pytest.mark.parametrize(("kind", "spec"), [("rtc", RTC_PROFILE), ("rts", RTS_PROFILE)])
def test_the_samples_are_whole(kind: str, spec: ElementSpec) -> None:
    seen: set[tuple[str, str]] = set()
    for element in etree.parse(SAMPLES / f"{kind}.xml").iter():
        parent = element.getparent()
        seen.add(("" if parent is None else parent.tag, element.tag))
        seen |= {(element.tag, name) for name in element.attrib}
    root = f"{{{NAMESPACES[kind]}}}{kind.capitalize()}Profile"
    assert not set(parts(spec, root, set())) - seen


def parts(spec: ElementSpec, tag: str, done: set[tuple[str, int]]) -> Iterator[tuple[str, str]]:
    if (tag, id(spec)) in done:
        return
    done.add((tag, id(spec)))
    yield from ((tag, item.name) for item in spec.attributes)
    for child in spec.children:
        yield tag, child.name
        if child.spec is not None:
            yield from parts(child.spec, child.name, done)


@needs_corpus
def test_a_system_of_the_command_line_saver() -> None:
    (file,) = corpus("yaml/*rtsystem.yaml")
    reading = read_rts(file.read_bytes(), file.name)
    assert reading.notes == ()
    profile = reading.profile
    assert profile.id == "RTSystem:jp.go.aist:SampleRTS:1.0.0"
    assert profile.comment == "Sample RTSystem"
    assert profile.creation_date == "2008-05-06T13:49:53"
    assert [each.instance_name for each in profile.components] == [
        "SampleComponent_1",
        "SampleComponent2_1",
        "SampleComponent3_1",
    ]
    assert profile.components[0].data_ports[1].visible is False
    assert profile.components[0].execution_contexts[0].rate == 1000.0
    location = profile.components[2].location
    assert location is not None
    assert (location.direction, location.x, location.height) == ("LEFT", 93, -1)
    assert profile.data_port_connectors[0].subscription_type == "Flush"
    assert profile.start_up is not None
    waits = [each.wait_time.wait_time for each in profile.start_up.targets if each.wait_time]
    assert waits == [1000, 500, 750]
    assert profile.shut_down is not None
    preceding = profile.shut_down.targets[2].preceding
    assert preceding is not None
    assert (preceding.timeout, preceding.sending_timing) == (100, "SYNC")
    assert len(preceding.preceding_components) == 2


@needs_corpus
def test_what_is_written_has_the_keys_of_the_existing_tools() -> None:
    """Reading and writing changes neither a key nor a value of the samples."""
    for pattern in ("yaml/*rtsystem.yaml", "yaml/*Ver03Ex.yaml"):
        (file,) = corpus(pattern)
        before = yaml.safe_load(file.read_bytes())
        after = yaml.safe_load(write_profile(read_file(str(file)).profile, "yaml"))
        assert after == without_zeros(before)


def without_zeros(value: Any) -> Any:
    """The sample without fractions of seconds, which are nought, and in our spelling."""
    if isinstance(value, list):
        return [without_zeros(item) for item in value]
    if not isinstance(value, dict):
        return value
    gone = ("fractionalSecond", "millisecond")
    return {
        "occurrence" if key == "occerrence" else key: without_zeros(item)
        for key, item in value.items()
        if key not in gone
    }


@needs_corpus
def test_a_component_of_version_0_1() -> None:
    (file,) = corpus("yaml/*SampleYaml.yaml")
    reading = read_rtc(file.read_bytes(), file.name)
    keys = {note.text for note in reading.notes if note.rule == "key-name"}
    assert {
        "key 'doc' taken as 'rtcDoc::doc'",
        "key 'varname' taken as 'rtcExt::variableName'",
    } < keys
    profile = reading.profile
    assert profile.version == "0.2"
    assert [port.position for port in profile.data_ports] == ["LEFT", "LEFT", "RIGHT", "RIGHT"]
    assert profile.data_ports[0].subscription_type == "Periodic,New,Flush"
    assert profile.data_ports[0].variable_name == "In1Var"
    assert profile.data_ports[0].doc is not None
    assert profile.data_ports[0].doc.occerrence == "In1Occerrence"
    assert profile.service_ports[0].service_interfaces[1].path == "IF2SearchPath"
    assert profile.language is not None
    assert profile.language.kind == "Java"
    assert [each.name for each in profile.language.targets[0].libraries] == ["library1"]
    assert profile.actions is not None
    assert profile.actions.on_reset is not None
    assert (profile.actions.on_shutdown.implemented, profile.actions.on_reset.implemented) == (  # type: ignore[union-attr]
        True,
        False,
    )
    assert profile.basic_info is not None
    assert len(profile.basic_info.version_up_logs) == 2
    assert [each.name for each in profile.parameters] == ["param1", "param2"]


HEAD = "rtsProfile:\n  id: RTSystem:Me:X:1\n  version: '0.2'\n"
DATES = "  creationDate: {year: 2020, month: 1, day: 2}\n  updateDate: 2020-01-02T00:00:00\n"


def test_words_of_other_writers_are_understood() -> None:
    text = HEAD + DATES + "  components: {id: 'RTC:a:b:c:1', instanceName: C0, isRequired: yes}\n"
    profile = read_rts(text).profile
    assert profile.creation_date == "2020-01-02T00:00:00"
    assert [each.is_required for each in profile.components] == [True]


def test_null_is_absent() -> None:
    text = HEAD + DATES + "  abstract: ~\n  startUp: null\n  components:\n  groups: []\n"
    profile = read_rts(text).profile
    assert (profile.abstract, profile.start_up, profile.components) == (None, None, ())


@pytest.mark.parametrize(
    ("parts", "date"),
    [
        ("{year: 2020, month: 1, day: 2}", "2020-01-02T00:00:00"),
        ("{year: 2020, month: 1, day: 2, timezone: 0}", "2020-01-02T00:00:00Z"),
        ("{year: 2020, month: 1, day: 2, timezone: -210}", "2020-01-02T00:00:00-03:30"),
        ("{year: 2020, month: 1, day: 2, fractionalSecond: 0.250}", "2020-01-02T00:00:00.250"),
        ("{year: 2020, month: 1, day: 2, millisecond: 25}", "2020-01-02T00:00:00.025"),
        (
            "{year: 2020, month: 1, day: 2, fractionalSecond: 0.000, millisecond: 0}",
            "2020-01-02T00:00:00",
        ),
    ],
)
def test_dates_as_tables(parts: str, date: str) -> None:
    text = f"{HEAD}  creationDate: {parts}\n  updateDate: {parts}\n"
    assert read_rts(text, strict=True).profile.creation_date == date


@pytest.mark.parametrize(
    ("text", "line", "why"),
    [
        ("rtxProfile: b", 1, "the root is 'rtxProfile'; a profile's is rtcProfile or rtsProfile"),
        ("- rtsProfile", 1, "the root is a table of one key, rtcProfile or rtsProfile"),
        ("rtsProfile: {}\nid: x", 1, "the root is a table of one key"),
        ("", 1, "the root is a table of one key"),
        ("rtsProfile: [a]", 1, "is a table of its parts"),
        (HEAD + "  components:\n    - text", 5, "rts:Components is a table of its parts"),
        (HEAD + "  abstract: [a]", 4, "rts:abstract is one value"),
        (HEAD + "  creationDate: {year: x}", 4, "a date has numbers for: year"),
        (HEAD + "  creationDate: {year: 2020, age: 1}", 4, "a date has numbers for: year"),
        (HEAD + "  creationDate: {year: 2020, month: [1]}", 4, "a date has numbers for: year"),
        (HEAD + "  creationDate: {year: 2020, timezone: x}", 4, "a date has numbers for: year"),
        (HEAD + "  foo::bar: x", 4, "no part of a profile: 'foo::bar'"),
        (HEAD + "  '<<': x", 4, "no part of a profile: '<<'"),
        (HEAD + '  abstract: "\\x01"', 4, "has a name or a character that no profile can hold"),
        (
            HEAD + '  rtsExt::versionUpLogs: ["\\x01"]',
            4,
            "has a character that no profile can hold",
        ),
        (HEAD + "  rtsExt::versionUpLogs: {a: b}", 4, "rtsExt:VersionUpLogs is text"),
        (HEAD + "  foreign::attributes: [a]", 4, "foreign attributes are a table"),
        (HEAD + "  foreign::attributes: {a b: c}", 4, "has a name or a character"),
        (HEAD + "  foreign::attributes: {a: [b]}", 4, "'a' is one value"),
        (HEAD + "  foreign::elements: [a]", 4, "a foreign element is a table of: name, "),
        (HEAD + "  foreign::elements: {name: '<'}", 4, "not the name of an element: '<'"),
        (HEAD + "  foreign::elements: {name: a, b: c}", 4, "a foreign element is a table of"),
        (HEAD + "  foreign::elements: {name: a, text: [c]}", 4, "a is text"),
        (HEAD + "  a: !x b", 4, "tag '!x' is not allowed"),
    ],
)
def test_what_is_no_profile(text: str, line: int, why: str) -> None:
    with pytest.raises(InvalidProfile) as caught:
        read_rts(text, "x.yaml")
    assert any(why in note.text and note.line == line for note in caught.value.problems), caught


def test_unknown_keys_are_dropped_or_kept_as_in_xml() -> None:
    text = (
        HEAD
        + DATES
        + "  what: x\n  rtsExt::flag: y\n  rtsExt::more:\n    - {a: b, c: {d: e}}\n    - f\n"
    )
    reading = read_rts(text)
    assert [(note.line, note.text) for note in reading.notes] == [
        (1, "foreign attribute rtsExt:flag kept"),
        (1, "unknown attribute rts:what dropped"),
        (9, "foreign element rtsExt:more kept"),
    ]
    more, last = reading.profile.foreign.elements
    assert (more.attributes[0][1], more.children[0].attributes[0][1], last.text) == ("b", "e", "f")
    for form in FORMS:
        assert read_profile(write_profile(reading.profile, form)).profile == reading.profile


def test_the_wrong_kind_is_refused() -> None:
    for text, why in (
        ("rtcProfile: {}", "the root is rtcProfile; it must be rtsProfile"),
        ('{"rtcProfile": {}}', "the root is rtcProfile; it must be rtsProfile"),
    ):
        with pytest.raises(InvalidProfile, match=why):
            read_rts(text)
        assert profile_kind(text) == "rtc"


@pytest.mark.parametrize(
    ("data", "name", "form"),
    [
        (b"<a/>", "x.yaml", "xml"),
        (b"\xef\xbb\xbf\n <a/>", "", "xml"),
        ("<a/>".encode("utf-16"), "x.json", "xml"),
        (b"{}", "", "json"),
        (b"{}", "x.xml", "json"),
        (b"{}", "x.yml", "yaml"),
        (b"rtsProfile:", "", "yaml"),
        (b"# x\n---\nrtcProfile: {", "", "yaml"),
        (b"--- 'rtsProfile' : {", "", "yaml"),
        (b"rtsProfile:", "x.xml", "xml"),
        (b"what", "x.YAML", "yaml"),
        (b"what", "", "xml"),
        (b"", "", "xml"),
    ],
)
def test_forms_are_found_out(data: bytes, name: str, form: str) -> None:
    assert form_of(data, name) == form


def test_a_form_that_there_is_not() -> None:
    with pytest.raises(Malformed, match="no such form: toml; there are xml, yaml, json"):
        read_profile(b"", form="toml")
    with pytest.raises(Malformed, match="no such form"):
        write_profile(read_rts(HEAD + DATES).profile, "toml")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-32"])
@pytest.mark.parametrize("form", ["yaml", "json"])
def test_encodings(encoding: str, form: str) -> None:
    profile = read_rts(HEAD + DATES + "  abstract: 日本\n").profile
    data = write_profile(profile, form).decode().encode(encoding)
    assert read_profile(data, form=form).profile == profile


def test_texts_in_place_of_bytes() -> None:
    head = "<?xml version='1.0' encoding='Shift_JIS'?>"
    root = '<RtsProfile xmlns="http://www.openrtp.org/namespaces/rts" id="日本"/>'
    assert read_rts(head + root).profile.id == "日本"
    assert read_rts("\ufeff" + head + root).profile.id == "日本"
    with pytest.raises(InvalidProfile, match="not UTF-8"):
        read_rts("rtsProfile: \ud800")


def test_bytes_that_are_no_text() -> None:
    with pytest.raises(InvalidProfile, match=r"x\.yaml:2: not UTF-8: byte 3"):
        read_rts(b"a\n\xff", "x.yaml")
    with pytest.raises(InvalidProfile, match=r"x\.yaml:1: not UTF-16: byte 3"):
        read_rts(b"\xff\xfea", "x.yaml")
    with pytest.raises(InvalidProfile, match="no profile is so large"):
        read_rts(b" " * (13 * 2**20), "x.yaml")


def test_files(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match=r"cannot read .*none\.xml: No such file"):
        read_file(str(tmp_path / "none.xml"))
    with pytest.raises(NotFound, match="cannot read"):
        read_file("a\0b")
    with pytest.raises(InvalidProfile, match="no profile is so large"):
        read_file("/dev/zero")
    file = tmp_path / "x.yml"
    file.write_text(HEAD + DATES)
    assert isinstance(read_file(str(file)).profile, RtsProfile)
    with pytest.raises(InvalidProfile, match="must be rtcProfile"):
        read_file(str(file), kind="rtc")
    file.write_text("rtcProfile: {id: x, version: '0.3'}")
    assert isinstance(read_file(str(file), kind="rtc").profile, RtcProfile)


def test_problems_are_explained_with_the_lines_of_the_document() -> None:
    text = (
        HEAD
        + DATES
        + "  components:\n    - id: x\n      instanceName: a\n      rtsExt::location: {x: a}\n"
    )
    notes = explain(text, "x.yaml")
    assert (
        Note(
            9,
            "rtsExt:x is 'a'; allowed: a whole number of at most 18 digits",
            "/rts:RtsProfile/rts:Components/rtsExt:Location/@rtsExt:x",
        )
        in notes
    )


def test_no_code_runs(tmp_path: Path) -> None:
    canary = tmp_path / "canary"
    for tag in ("!!python/object/apply:os.system", "!!python/object/new:os.system"):
        text = f"rtsProfile: {tag} ['touch {canary}']"
        with pytest.raises(InvalidProfile, match="is not allowed"):
            read_rts(text)
    assert not canary.exists()


OLDER = """\
rtcProfile:
  id: RTC:a:b:C:1.0
  version: '0.2'
  configurationSet:
    configuration:
    - name: a
      type: int
      defaultValue: '1'
      {properties}: [{{name: __widget__, value: text}}]
      constraint:
        {unit}
  servicePorts:
  - name: s
    rtcExt::position: LEFT
    {methods}: [{{kind: x}}]
"""
ONE = "propertyIsEqualTo: {matchCase: false, literal: '1'}"


@pytest.mark.parametrize(
    "unit",
    [
        f"constraintUnit: {{or: [{{constraintUnit: {{{ONE}}}}}, {{{ONE}}}]}}",
        f"or: [{{constraintUnitType: {{{ONE}}}}}, {{{ONE}}}]",
        f"constraintUnitType: {{or: {{constraint: [{{{ONE}}}, {{{ONE}}}]}}}}",
    ],
)
def test_older_spellings_of_trees_are_understood(unit: str) -> None:
    told = OLDER.format(properties='"rtcExt::property"', unit=unit, methods="transMethod")
    usual = OLDER.format(
        properties='"rtcExt::properties"',
        unit=f"constraintUnitType: {{or: {{constraint: [{{constraintUnitType: {{{ONE}}}}},"
        f" {{constraintUnitType: {{{ONE}}}}}]}}}}",
        methods="transMethods",
    )
    reading = read_rtc(told, form="yaml")
    assert reading.profile == read_rtc(usual, form="yaml").profile
    assert {note.rule for note in reading.notes} >= {"key-name"}


@pytest.mark.parametrize("form", ["json", "yaml"])
def test_a_character_that_cannot_be_is_told_once(form: str) -> None:
    text = '{"rtsProfile": {"id": "a\\u0000b", "version": "0.2"}}'
    with pytest.raises(InvalidProfile) as caught:
        read_rts(text, form=form)
    (problem,) = caught.value.problems
    assert problem.rule == "bad-character"


def test_a_system_with_a_remark_has_the_type_that_allows_for_it() -> None:
    plain = read_rts((SAMPLES / "rts.xml").read_bytes()).profile
    assert b'xsi:type="rtsExt:rts_profile_ext"' in write_profile(plain)
    bare = RtsProfile("a", "0.2", "2020-01-01T00:00:00", "2020-01-01T00:00:00")
    assert b"rts_profile_ext" not in write_profile(bare)
    remarked = write_profile(replace(bare, comment="hm"))
    assert read_rts(remarked, strict=True).profile.comment == "hm"
    loose = remarked.replace(b' xsi:type="rtsExt:rts_profile_ext"', b"")
    assert loose != remarked
    assert read_rts(loose, strict=True).profile.comment == "hm"
