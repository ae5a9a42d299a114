"""Slips of the hand: words that one typing error tells apart."""

from __future__ import annotations

import pytest

from rtkit.rtc.nearest import is_slip


@pytest.mark.parametrize(
    ("word", "is_one"),
    [
        ("mangaer", True),
        ("manger", True),
        ("mannager", True),
        ("manager", False),
        ("manager2", False),
        ("managed", False),  # as robot_a and robot_b are
        ("nmanagre", False),
        ("amnagre", False),
    ],
)
def test_a_slip_is_one_typing_error(word: str, is_one: bool) -> None:
    assert is_slip(word, "manager") is is_one
    assert is_slip("manager", word) is is_one


@pytest.mark.parametrize(
    ("one", "other"), [("arm", "amr"), ("robot12", "robot21"), ("arms", "arm")]
)
def test_short_words_and_numbers_are_not(one: str, other: str) -> None:
    assert not is_slip(one, other)
