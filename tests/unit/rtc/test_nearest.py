"""What may have been meant."""

from __future__ import annotations

from difflib import SequenceMatcher

from hypothesis import given
from hypothesis import strategies as st

from rtkit.rtc.nearest import CLOSE, did_you_mean, nearest

KNOWN = ("start", "stop", "restart", "status", "run")


def test_the_most_alike_comes_first() -> None:
    assert nearest("strat", KNOWN) == ["start", "status", "restart"]
    assert nearest("strat", KNOWN, 1) == ["start"]


def test_capitals_do_not_matter() -> None:
    assert nearest("consolein", ["ConsoleIn", "Motor"]) == ["ConsoleIn"]
    assert nearest("motor", ["Motor", "motor", "MOTOR"]) == ["Motor", "motor", "MOTOR"]


def test_nothing_alike() -> None:
    assert nearest("frob", KNOWN) == []
    assert did_you_mean("frob", KNOWN) == ""
    assert did_you_mean("", []) == ""


def test_as_part_of_a_message() -> None:
    assert did_you_mean("strat", KNOWN, 2) == " (did you mean start or status?)"


@given(st.text("abAß.", max_size=6), st.lists(st.text("abAß.", max_size=6), unique=True))
def test_no_word_that_is_alike_is_left_out(word: str, known: list[str]) -> None:
    ratio = {each: SequenceMatcher(a=each.casefold(), b=word.casefold()).ratio() for each in known}
    alike = [each for each in known if ratio[each] >= CLOSE]
    best = max((ratio[each] for each in alike), default=0.0)
    expected = [each for each in alike if ratio[each] >= best - 0.15]
    assert set(nearest(word, known, len(known), CLOSE)) == set(expected)
