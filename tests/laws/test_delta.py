"""News lead from one picture to the next, whatever changes, and say nothing when nothing does."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rtkit.deployment.delta import Delta, applied, delta_between
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.deployment.user_events import KINDS, user_events
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, PortType
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    PortProfile,
    PortRef,
    TypeProfile,
)
from rtkit.rtc.serde import decode_text, encode_text

NAMES = ("A", "B", "C")
STATES = tuple(LifeCycleState)
WORDS = ("", "one", "two")
Draw = Callable[[int], int]
"""Draws a number below another one."""


def context(id: str, draw: Draw) -> ExecutionContextProfile:
    kind = ExecutionKind.PERIODIC
    return ExecutionContextProfile(id, kind, 1.0 + draw(2), "A", bool(draw(2)), STATES[draw(4)])


def component(name: str, draw: Draw) -> ComponentFacts:
    def word() -> str:
        return WORDS[draw(3)]

    return ComponentFacts(
        name,
        TypeProfile("Thing"),
        ("manager", "slave")[draw(2)],
        tuple(PortProfile(each, PortType.IN) for each in WORDS[1:] if draw(2)),
        {each: {word(): word()} for each in WORDS if draw(2)},
        word(),
        tuple(context(id, draw) for id in "01" if draw(2)),
        names=WORDS[draw(3) :],
        cause=word(),
        zombie=word(),
        trouble=word(),
        fsm_state=word(),
        fsm_states={word(): {}} if draw(2) else {},
        fsm_events={word(): word()} if draw(2) else {},
    )


def connector(name: str, draw: Draw) -> ConnectorProfile:
    ends = tuple(PortRef(NAMES[draw(3)], WORDS[draw(3)]) for _ in "ab")
    return ConnectorProfile(name, WORDS[draw(3)], ends)


def process(name: str, draw: Draw) -> ProcessFacts:
    state = ("starting", "up", "stopped", "lost")[draw(4)]
    return ProcessFacts(WORDS[draw(3)], bool(draw(2)), ord(name), state, WORDS[draw(3)])


@st.composite
def snapshots(draw_from: st.DrawFn) -> Snapshot:
    chosen = random.Random(draw_from(st.integers(0, 1 << 32)))
    draw = chosen.randrange
    return Snapshot(
        "host",
        "manager",
        1,
        "0",
        tuple(process(name, draw) for name in NAMES if draw(2)),
        tuple(component(name, draw) for name in NAMES if draw(2)),
        tuple(connector(name, draw) for name in NAMES if draw(2)),
        names=WORDS[: draw(2)],
    )


def known(facts: Snapshot) -> Any:
    return (
        {each.instance: each for each in facts.components},
        {each.connector_id: each for each in facts.connectors},
        {each.pid: each for each in facts.processes},
        facts.names,
    )


@given(snapshots(), snapshots())
def test_news_lead_from_one_picture_to_the_next(before: Snapshot, after: Snapshot) -> None:
    delta = delta_between(before, after, "run", 7)
    assert decode_text(Delta, encode_text(delta)) == delta
    assert known(applied(before, delta)) == known(after)


@given(snapshots(), snapshots())
def test_what_they_mean_can_be_told(before: Snapshot, after: Snapshot) -> None:
    told = list(user_events(before, delta_between(before, after, "run", 7)))
    assert {each.kind for each in told} <= set(KINDS)
    assert all(each.event and isinstance(each.detail, str) for each in told)
    instances = {c.instance for c in (*before.components, *after.components)}
    assert {each.instance for each in told} <= instances | {""}


@given(snapshots())
def test_nothing_is_told_when_nothing_changed(facts: Snapshot) -> None:
    delta = delta_between(facts, facts, "run", 7)
    assert delta == Delta("run", 7)
    assert list(user_events(facts, delta)) == []
