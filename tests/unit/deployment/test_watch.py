"""A look at states: what is seen, and how it travels."""

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.watch import (
    Watch,
    Watched,
    look,
    seen,
    states_from_text,
    states_to_text,
    watch_from_text,
    watch_to_text,
)
from rtkit.errors import Malformed
from rtkit.rtc.enums import LifeCycleState


def test_what_is_seen(world):
    world.perform(act.Create("Sink?instance_name=A&manager_name=s"))

    def now(context="0", instance="A"):
        return seen(world.components.get(instance), context)

    assert now() == "Inactive"
    world.set_state("A", LifeCycleState.ERROR)
    assert now() == "Error"
    world.set_state("A", LifeCycleState.ACTIVE)
    world.update("A", trouble="stopped")
    assert now() == "Active (stopped)"
    assert now("9") == "without execution context 9"
    world.kill("s", "signal 11")
    assert now() == "zombie (signal 11)"
    assert now(instance="B") == "missing"
    assert look([Watched("B", "0"), Watched("A", "0")], world.components.get) == (
        "missing",
        "zombie (signal 11)",
    )


@pytest.mark.parametrize(
    "watch",
    [
        Watch(()),
        Watch((Watched("A", "0"), Watched("ö b", "Ec1")), ("Active", "missing"), 2.5),
        Watch((Watched("A", "0"),), timeout_s=86_400.0),
    ],
)
def test_there_and_back(watch):
    assert watch_from_text(watch_to_text(watch)) == watch


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"targets": 1}',
        '{"targets": [["A", "0"]]}',
        '{"targets": [], "timeout_s": -1}',
        '{"targets": [], "timeout_s": NaN}',
        '{"targets": [], "timeout_s": 1e9}',
        '{"targets": [], "timeout_s": "long"}',
        '{"targets": [], "known": [1]}',
        "[" * 100_000,
    ],
)
def test_no_watch(text):
    with pytest.raises(Malformed):
        watch_from_text(text)


def test_states_there_and_back():
    assert states_from_text(states_to_text(("Active", "missing"))) == ("Active", "missing")
    for text in ("", "{}", '"Active"'):
        with pytest.raises(Malformed):
            states_from_text(text)
