"""Orders of a profile: read, and refused where they make no sense."""

from dataclasses import replace

import pytest

from rtkit.deployment.conditions import OrderTarget, StartCondition, start_orders, stop_orders
from rtkit.errors import InvalidDocument
from rtkit.profile import rts_model as rts

A, B, C = (OrderTarget(f"Sink{n}", 0) for n in range(3))


def test_nothing_said_is_nothing_ordered(make):
    assert start_orders(make.sinks(2)) == {}
    assert stop_orders(replace(make.sinks(2), activation=rts.Order())) == {}


def test_each_kind_of_entry(make):
    profile = make.ordered(
        make.sinks(3),
        make.entry("Sink0", 3),
        make.entry("Sink1", 4, wait=5000),
        make.entry("Sink1", 5, after="Sink0 Sink2", timing="SYNC", timeout=20),
        make.entry("Sink2", 6, after="Sink0", timing="ASYNC"),
    )
    assert start_orders(profile) == {
        A: (StartCondition(3),),
        B: (
            StartCondition(4, 5000),
            StartCondition(5, 0, A, True, 20),
            StartCondition(5, 0, C, True, 20),
        ),
        C: (StartCondition(6, 0, A, False),),
    }
    assert stop_orders(profile) == {}


@pytest.mark.parametrize(
    ("timing", "is_sync"), [(None, True), ("SYNC", True), ("ASYNC", False), ("NO_SYNC", False)]
)
def test_sync_is_what_silence_means(make, timing, is_sync):
    entry = make.entry("Sink1", after="Sink0", timing=timing)
    (condition,) = stop_orders(make.ordered(make.sinks(2), entry, stop=True))[B]
    assert condition.is_sync is is_sync


def test_an_entry_without_anything_to_wait_for_is_a_place(make):
    bare = rts.OrderStep(7, make.entry("Sink0").target_component)
    nobody = replace(bare, preceding=rts.Preceding(timeout=5))
    for entry in (bare, nobody, replace(bare, wait_time=rts.WaitTime(0))):
        (condition,) = start_orders(make.ordered(make.sinks(1), entry))[A]
        assert (condition.sequence, condition.is_delaying) == (7, False)


def test_contexts_are_found_by_id_else_by_number(make):
    contexts = (("Ec1", "PERIODIC", 10.0), ("0", "PERIODIC", 10.0))
    profile = make.profile(make.component("Sink0", contexts=contexts))
    entries = [make.entry("Sink0", n, context=id) for n, id in enumerate(("Ec1", "0", "1"))]
    assert {
        target: [c.sequence for c in conditions]
        for target, conditions in start_orders(make.ordered(profile, *entries)).items()
    } == {A: [0], OrderTarget("Sink0", 1): [1, 2]}


@pytest.mark.parametrize(
    ("entry", "why"),
    [
        ({"instance": "Sink7"}, "Activation: unknown target: component Sink7 is not listed"),
        (
            {"instance": "Sink0", "after": "Sink7"},
            "Activation: unknown target: component Sink7 is not listed",
        ),
        (
            {"instance": "Sink0", "context": "Ec9"},
            "Activation: unknown target: execution context Ec9 of component Sink0 (it has 0)",
        ),
        (
            {"instance": "Sink0", "after": "Sink1/4"},
            "Activation: unknown target: execution context 4 of component Sink1 (it has 0)",
        ),
        ({"instance": "Sink0", "wait": -1}, "Activation: waitTime of component Sink0 is"),
        (
            {"instance": "Sink0", "after": "Sink1", "timeout": -5},
            "Activation: timeout of component Sink0 is negative: -5",
        ),
        (
            {"instance": "Sink0", "after": "Sink0"},
            "Activation: conditions in a circle: Sink0 waits for Sink0",
        ),
    ],
)
def test_what_makes_no_sense(make, entry, why):
    with pytest.raises(InvalidDocument) as caught:
        start_orders(make.ordered(make.sinks(2), make.entry(**entry)))
    assert str(caught.value).startswith(why)


def test_a_component_without_contexts_is_no_target(make):
    profile = make.profile(make.component("Sink0", contexts=()))
    with pytest.raises(InvalidDocument, match=r"context 0 of component Sink0 \(it has none\)"):
        start_orders(make.ordered(profile, make.entry("Sink0")))


def test_a_circle_is_named_and_nothing_else(make):
    after = {"Sink0": "Sink1", "Sink1": "Sink2", "Sink2": "Sink3 Sink4", "Sink4": "Sink2"}
    entries = [make.entry(name, after=other) for name, other in after.items()]
    with pytest.raises(InvalidDocument) as caught:
        stop_orders(make.ordered(make.sinks(5), *entries, stop=True))
    assert str(caught.value) == (
        "Deactivation: conditions in a circle: Sink2 waits for Sink4 waits for Sink2"
    )


def test_contexts_are_named_where_there_are_several(make):
    two = (("a", "PERIODIC", 10.0), ("b", "PERIODIC", 10.0))
    profile = make.profile(make.component("Sink0", contexts=two))
    first = make.entry("Sink0", context="a", after="Sink0/b")
    orders = start_orders(make.ordered(profile, first))
    assert [c.preceding for c in orders[A]] == [OrderTarget("Sink0", 1)]
    second = make.entry("Sink0", context="b", after="Sink0/a")
    with pytest.raises(InvalidDocument, match="Sink0 in a waits for Sink0 in b waits for Sink0 in"):
        start_orders(make.ordered(profile, first, second))


def test_long_chains_and_diamonds_are_no_circles(make):
    entries = [make.entry(f"Sink{n}", after=f"Sink{n - 1}") for n in range(1, 2000)]
    entries += [make.entry("Sink1999", after="Sink0 Sink1 Sink2")]
    assert len(start_orders(make.ordered(make.sinks(2000), *reversed(entries)))) == 1999
