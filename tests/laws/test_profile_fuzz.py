"""Fuzzing of the readers: whatever is read ends in a profile or in `InvalidProfile`, nothing else.

Bounded here; ``RTKIT_FUZZ=100000 pytest tests/laws/test_profile_fuzz.py --timeout 0`` for a night.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from profile_reading import explain, profile_kind

from rtkit.profile.examine import examine
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.rules import RULES
from rtkit.profile.write import write_profile

ROUNDS = int(os.environ.get("RTKIT_FUZZ", "200"))
SAMPLES = Path(__file__).parents[1] / "unit" / "profile" / "samples"
DOCUMENTS = {file.name: file.read_bytes() for file in sorted(SAMPLES.glob("rt[cs].*"))}
LONGEST_LINE = 1100

WORDS = (Path(__file__).parent / "hostile_words.txt").read_bytes().splitlines()
"""Words of the three syntaxes that a reader might stumble over."""

WORDS += [
    b"|",
    b"\0",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\xfe\xff",
    b"\r",
    b"\n",
    b"\x85",
    b"\t",
]
GLUE = (b"rtsProfile", b": ", b"\n  ", b'"id"', b" ")
HOWS = ("insert", "replace", "cut", "repeat", "move")
ENCODINGS = ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-8-sig", "latin-1", "shift_jis")
PIECES = st.one_of(
    st.sampled_from(WORDS),
    st.builds(lambda word, count: word * count, st.sampled_from(WORDS), st.integers(2, 300)),
    st.binary(max_size=6),
)
PLACE = st.integers(0, 10**6)
EDITS = st.lists(
    st.tuples(st.sampled_from(HOWS), PLACE, PLACE, PIECES),
    max_size=5,
)


def edited(data: bytes, how: str, start: int, length: int, piece: bytes) -> bytes:
    """Change a document at some place; `length` counts what is cut, repeated or moved."""
    start %= len(data) + 1
    end = min(len(data), start + length % 200)
    if how == "insert":
        return data[:start] + piece + data[start:]
    if how == "replace":
        return data[:start] + piece + data[end:]
    if how == "cut":
        return data[:start] + data[end:]
    if how == "repeat":
        return data[:end] + data[start:end] * (1 + len(piece) % 50) + data[end:]
    return data[end:] + data[start:end] + data[:start]


def attempt(data: bytes | str, **how: Any) -> tuple[Any, InvalidProfile | None]:
    try:
        return read_profile(data, "<x>", **how), None
    except InvalidProfile as refused:
        return None, refused


def judged(data: bytes | str, **how: Any) -> Any:
    """Read in every way; all refusals are of one kind and tell where and against which rule."""
    reading, refused = attempt(data, **how)
    if refused is not None:
        check_told(refused, data)
    seen = examine(data, "<x>", **how)
    assert (seen.profile is None) == (reading is None) == bool(seen.errors)
    for note in (*seen.errors, *seen.repairs, *seen.remarks):
        assert note.rule in RULES, note
    return reading


def check_told(refused: InvalidProfile, data: bytes | str) -> None:
    """Check that lines are those of the document, and that no message floods the terminal."""
    assert refused.problems
    assert all(1 <= note.line <= len(data) + 1 for note in refused.problems)
    lines = str(refused).split("\n")
    assert all(line.startswith("<x>:") for line in lines), lines
    assert max(map(len, lines)) < LONGEST_LINE, lines
    assert not any(re.search(r"[\x00-\x1f\x7f]", line) for line in lines), lines


def come_back(profile: Any) -> None:
    for form in FORMS:
        assert read_profile(write_profile(profile, form), form=form).profile == profile


FUZZ = settings(
    deadline=None,
    max_examples=ROUNDS,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@given(st.sampled_from(sorted(DOCUMENTS)), EDITS, st.sampled_from((None, *FORMS)))
@FUZZ
@example("rtc.yaml", [("insert", 0, 0, b"!!python/object/apply:os.system ['true']")], "yaml")
def test_documents_with_damage(name: str, edits: list[Any], form: str | None) -> None:
    data = DOCUMENTS[name]
    for edit in edits:
        data = edited(data, *edit)
    reading = judged(data, form=form)
    if reading is not None:
        come_back(reading.profile)


@given(st.sampled_from(sorted(DOCUMENTS)), EDITS, st.sampled_from(ENCODINGS))
@FUZZ
def test_documents_in_wrong_encodings(name: str, edits: list[Any], encoding: str) -> None:
    text = DOCUMENTS[name].decode()
    data = text.encode(encoding, "replace")
    for edit in edits:
        data = edited(data, *edit)
    judged(data)


@given(st.lists(PIECES | st.sampled_from(GLUE)).map(b"".join))
@FUZZ
def test_pieces_of_syntax(data: bytes) -> None:
    for form in FORMS:
        judged(data, form=form)


@given(st.text(max_size=60), st.sampled_from(FORMS), st.sampled_from(("rtc", "rts", None)))
@FUZZ
def test_texts(text: str, form: str, kind: str | None) -> None:
    judged(text, form=form, kind=kind)
    judged(f'rtsProfile: {{id: "{text}", abstract: {text}}}', form="yaml")


@given(st.sampled_from(sorted(DOCUMENTS)), EDITS)
@settings(FUZZ, max_examples=ROUNDS // 4)
def test_explanations(name: str, edits: list[Any]) -> None:
    data = DOCUMENTS[name]
    for edit in edits:
        data = edited(data, *edit)
    for note in explain(data, "<x>"):
        assert note.line >= 0
        assert note.rule in RULES


@given(st.binary(max_size=200))
@FUZZ
def test_bytes_from_nowhere(data: bytes) -> None:
    with pytest.raises(InvalidProfile):
        profile_kind(data, "<x>")
    judged(data)
