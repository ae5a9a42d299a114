"""Documents written anew: strict, complete, the same when done twice; what is lost is told."""

from __future__ import annotations

import os.path
from pathlib import Path

import pytest
from corpus import TYPED, everything, needs_corpus

from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.write import write_profile
from rtkit.profile_tools.rewriting import rewritten
from rtkit.profile_tools.uncarried import uncarried
from rtkit.profile_tools.validation import RULES
from rtkit.report.finding import ERROR, NOTE, WARNING

FRAGMENT = "a fragment"


def content(file: str | Path) -> bytes:
    with open(file, "rb") as stream:
        return stream.read()


def sensor() -> bytes:
    return content(TYPED / "sensor.xml")


@needs_corpus
@pytest.mark.parametrize("file", everything(), ids=os.path.basename)
def test_what_was_brought_to_the_strict_form_is_in_it(file: str) -> None:
    made = rewritten(content(file), file)
    assert made.data is not None
    again = rewritten(made.data, file)
    assert again.data == made.data
    left = [f for f in again.findings if f.rule not in ("foreign-kept", "shared-name", "fragment")]
    assert left == []


@needs_corpus
@pytest.mark.parametrize("file", everything(), ids=os.path.basename)
def test_every_form_holds_everything(file: str) -> None:
    profile = read_profile(content(file), file).profile
    data = content(file)
    for form in (*FORMS, "xml"):
        made = rewritten(data, "a", to=form)
        assert made.data is not None
        data = made.data
        assert read_profile(data, form=form).profile == profile


def test_errors_leave_nothing_to_write() -> None:
    made = rewritten(b"<a/>", "a.xml")
    assert made.data is None
    assert [(finding.severity, finding.rule) for finding in made.findings] == [
        (ERROR, "wrong-root")
    ]


def test_comments_are_lost_and_told() -> None:
    data = sensor().replace(b"<rtc:Actions>", b"<!-- mine\n& yours --><rtc:Actions>")
    data = data.replace(b"<rtc:RtcProfile", b'<?xml-model href="a.xsd"?>\n<rtc:RtcProfile')
    data += b"<!---->"
    made = rewritten(data, "a.xml")
    assert [(f.line, f.severity, f.rule, f.text) for f in made.findings] == [
        (
            2,
            WARNING,
            "comment-dropped",
            "processing instruction xml-model is no part of the profile and left out",
        ),
        (
            8,
            WARNING,
            "comment-dropped",
            "comment 'mine & yours' is no part of the profile and left out",
        ),
        (
            48,
            WARNING,
            "comment-dropped",
            "comment is no part of the profile and left out",
        ),
    ]
    assert made.data == write_profile(read_profile(sensor()).profile)


def test_comments_of_yaml_are_told_too() -> None:
    data = b"""# of mine
rtcProfile:
  id: 'a # b'   # first
  version: "0.3"
  basicInfo:  # second

    name: a#b
    description: |
      # text
"""
    assert [(note.line, note.text.partition(" is ")[0]) for note in uncarried(data, "yaml")] == [
        (1, "comment 'of mine'"),
        (3, "comment 'first'"),
        (5, "comment 'second'"),
    ]


def test_a_cdata_section_is_no_comment() -> None:
    data = b"<a><![CDATA[<!-- no comment -->]]></a>"
    assert uncarried(data, "xml") == []


def test_what_a_form_cannot_hold_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    def forget(profile: object, form: str) -> bytes:
        return write_profile(profile, form).replace(b"50.0", b"51.0")  # type: ignore[arg-type]

    monkeypatch.setattr("rtkit.profile_tools.rewriting.write_profile", forget)
    made = rewritten(sensor(), "a.xml", to="json")
    assert made.data is None
    (finding,) = made.findings
    assert (finding.severity, finding.rule) == (ERROR, "not-carried")
    assert finding.text == (
        "cannot be carried as JSON: ~ component: basic_info.execution_rate 50 -> 51"
    )


def test_rules_have_a_line_each() -> None:
    told = {"comment-dropped", "not-carried", "unreadable"}
    assert set(RULES) == told
    assert NOTE != WARNING
