"""What may have been meant."""

from __future__ import annotations

from rtkit.rtc.nearest import did_you_mean, nearest

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
