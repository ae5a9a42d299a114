"""Numbers of chosen names: the lowest that is free, whatever was made, refused and ended before."""

from __future__ import annotations

import itertools

from fake_shell import FakeShell
from hypothesis import given
from hypothesis import strategies as st

from rtkit.deployment.actions import Create, Delete
from rtkit.errors import Refused

GIVEN = st.sampled_from(["Thing0", "Thing2", "Thing02", "Thing10", "Thing1_0", "Thing"])
STEPS = st.lists(
    st.one_of(
        st.just(("make", "")),
        st.just(("refuse", "")),
        st.tuples(st.just("make"), GIVEN),
        st.tuples(st.just("delete"), GIVEN),
        st.tuples(st.just("delete"), st.sampled_from(["Thing1", "Thing3", "Thing4"])),
    ),
    max_size=20,
)


@given(STEPS)
def test_a_chosen_name_has_the_lowest_free_number(steps) -> None:
    shell = FakeShell()
    for step, name in steps:
        there = set(shell.state.components)
        lowest = next(n for n in itertools.count() if f"Thing{n}" not in there)
        if step == "delete":
            shell.ask(Delete(name))
            shell.serve()
            assert set(shell.state.components) == there - {name}
            continue
        made = shell.ask(Create(f"Thing?instance_name={name}" if name else "Thing"))
        if step == "refuse":
            shell.refuse(shell.next("create"), Refused("no"))
            assert set(shell.state.components) == there
        else:
            shell.serve()
            assert made.result.value == (name or f"Thing{lowest}")
