"""Plans are as cheap as any, by comparison with looking at everything; and they verify."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.errors import Impossible
from rtkit.planner import Command, Condition, Problem, optimal_plans, plan, plan_within, verify

STATES = 7


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """Return a random graph: each edge a command of its own, some with equal cost."""
    ends = st.integers(0, STATES - 1)
    edges = draw(st.lists(st.tuples(ends, ends, st.integers(1, 4)), max_size=22))
    commands = [
        Command(
            f"e{number}", lambda s, b=b: (b,), (Condition("is there", lambda s, a=a: s == (a,)),)
        )
        for number, (a, b, _) in enumerate(edges)
    ]
    goals = draw(st.sets(ends, min_size=1, max_size=2))
    costs = {f"e{number}": Fraction(cost) for number, (_, _, cost) in enumerate(edges)}
    return Problem({"v": range(STATES)}, (0,), lambda s: s[0] in goals, commands, costs)


def brute_force(problem: Problem) -> list[tuple[Fraction, int, tuple[int, ...]]]:
    """Return cost, length and commands of all cheapest plans, by trying everything."""
    found: list[tuple[Fraction, int, tuple[int, ...]]] = []
    bound = 4 * STATES

    def go(state, cost, way, seen):
        if cost > bound:
            return
        if problem.is_goal(state):
            found.append((cost, len(way), way))
            return
        for number, command in enumerate(problem.commands):
            if all(condition.holds(state) for condition in command.conditions):
                after = command.effect(state)
                if after not in seen:  # what comes back to a state is never cheapest
                    price = problem.costs[command.name]
                    go(after, cost + price, (*way, number), seen | {after})

    go(problem.start, Fraction(0), (), frozenset([problem.start]))
    least = min((cost for cost, _, _ in found), default=None)
    return sorted(each for each in found if each[0] == least)


def numbers(found) -> tuple[int, ...]:
    return tuple(int(name[1:]) for name in found.commands)


def exact_heuristic(problem: Problem, share: Fraction):
    """Return a share of what is really left: consistent, as the shares of all states are alike."""
    left = {}
    for value in range(STATES):
        ways = brute_force(problem.replaced(start=(value,)))
        left[(value,)] = ways[0][0] * share if ways else Fraction(4 * STATES)
    return left.__getitem__


@given(problems(), st.sampled_from([Fraction(0), Fraction(1, 2), Fraction(1)]))
@settings(max_examples=150, deadline=None)
def test_a_plan_is_the_first_of_the_shortest_of_the_cheapest(problem, share):
    expected = brute_force(problem)
    heuristic = exact_heuristic(problem, share)
    if not expected:
        with pytest.raises(Impossible):
            plan(problem, heuristic)
        return
    found = plan(problem, heuristic)
    assert verify(problem, found) == ""
    assert (found.cost, len(found.steps), numbers(found)) == expected[0]
    every = optimal_plans(problem, heuristic)
    assert every.count == len(expected)
    assert sorted(map(numbers, every)) == sorted(way for _, _, way in expected)


@given(
    problems(),
    st.lists(st.integers(0, 50), min_size=STATES, max_size=STATES),
    st.sampled_from([1, 1.5, 3]),
)
@settings(max_examples=150, deadline=None)
def test_a_misled_plan_stays_within_its_bound(problem, guide, factor):
    expected = brute_force(problem)
    if not expected:
        with pytest.raises(Impossible):
            plan_within(problem, factor, lambda s: guide[s[0]])
        return
    heuristic = exact_heuristic(problem, Fraction(1, 2))
    found = plan_within(problem, factor, lambda s: guide[s[0]], heuristic)
    assert verify(problem, found) == ""
    assert found.lower_bound <= expected[0][0] <= found.cost <= factor * expected[0][0]
