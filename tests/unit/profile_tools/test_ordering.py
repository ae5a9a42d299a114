"""Orders of system profiles, as texts of their steps."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, NotFound
from rtkit.profile.rts_model import ComponentInstance, RtsProfile
from rtkit.profile_tools.ordering import steps_in, with_steps

SYSTEM = RtsProfile(
    "RTSystem:Me:Robot:1",
    "0.2",
    "",
    "",
    components=tuple(
        ComponentInstance(f"RTC:Me:test:{name}:1", f"localhost/{name}.rtc", name)
        for name in ("A", "B", "C")
    ),
)


@pytest.mark.parametrize(
    "steps",
    [
        ["A", "B", "C"],
        ["B:wait=500", "A@1"],
        ["A", "B:at=1", "C:after=A,after=B,timeout=100,sent"],
        [],
    ],
)
def test_steps_are_written_and_read(steps: list[str]) -> None:
    assert steps_in(with_steps(SYSTEM, "activation", steps), "activation") == steps


def test_what_an_order_says_besides_is_kept() -> None:
    before = with_steps(SYSTEM, "start-up", ["A", "B:after=A"])
    after = with_steps(before, "start-up", ["B:after=A", "A"])
    assert steps_in(after, "start-up") == ["B:after=A", "A"]
    assert with_steps(after, "start-up", []).start_up is None


@pytest.mark.parametrize(
    ("step", "error", "why"),
    [
        ("D", NotFound, "no component named D"),
        ("A:after=D", NotFound, "no component named D"),
        ("A:soon", Malformed, "soon is none of"),
        ("A:wait=-1", Malformed, "a whole number is wanted, not '-1'"),
        ("A:after=B,wait=1", Malformed, "wait or after, not both"),
        ("A:timeout=1", Malformed, "go with after"),
    ],
)
def test_what_makes_no_sense_is_named(step: str, error: type[Exception], why: str) -> None:
    with pytest.raises(error, match=why):
        with_steps(SYSTEM, "activation", [step])
