"""Calls that cross are noticed, all others are not, whatever their order."""

from __future__ import annotations

import itertools
import threading

from hypothesis import given
from hypothesis import strategies as st

from rtkit.component.services.reentrancy import Reentrancy


def circles(crossings, *calls):
    """Begin calls, written ``AB``; return the circle that each closes, likewise."""
    return ["".join(crossings.enter(*call)[1]) for call in calls]


def test_calls_one_way_are_no_circle():
    assert circles(Reentrancy(), "AB", "AB", "BC", "DA") == [""] * 4


def test_the_call_that_closes_the_circle_is_told_it():
    assert circles(Reentrancy(), "AB", "BC", "CA") == ["", "", "CABC"]


def test_who_calls_itself_goes_the_shortest_way():
    assert circles(Reentrancy(), "AA") == ["AA"]
    assert circles(Reentrancy(), "AB", "AA") == ["", "AA"]


def test_a_call_that_came_back_is_forgotten():
    crossings = Reentrancy()
    first, _ = crossings.enter("A", "B")
    second, _ = crossings.enter("A", "B")
    crossings.leave(first)
    back, circle = crossings.enter("B", "A")
    assert circle == ("B", "A", "B")
    crossings.leave(back)
    crossings.leave(second)
    assert circles(crossings, "BA") == [""]


names = st.sampled_from("ABCD")


@given(st.lists(st.tuples(names, names), max_size=12))
def test_a_circle_is_told_exactly_when_there_is_a_way_back(calls):
    crossings = Reentrancy()
    begun = []
    edges = set()
    for caller, provider in calls:
        edges.add((caller, provider))
        call, circle = crossings.enter(caller, provider)
        begun.append(call)
        reached = {provider}
        for _ in range(4):
            reached |= {b for a, b in edges if a in reached}
        assert bool(circle) == (caller in reached)
        if circle:
            assert (circle[0], circle[1], circle[-1]) == (caller, provider, caller)
            assert all(pair in edges for pair in itertools.pairwise(circle))
    for call in begun:
        crossings.leave(call)
    assert circles(crossings, "AB", "BC") == ["", ""]


def test_of_calls_that_meet_on_threads_one_at_least_finds_the_circle():
    for _ in range(50):
        crossings = Reentrancy()
        gate = threading.Barrier(2)
        found = []

        def call(pair, crossings=crossings, gate=gate, found=found):
            gate.wait()
            found.append(crossings.enter(*pair)[1])

        threads = [threading.Thread(target=call, args=(pair,)) for pair in ("AB", "BA")]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert any(found)
