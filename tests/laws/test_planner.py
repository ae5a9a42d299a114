"""Plans are as cheap as any, by comparison with looking at everything; and they verify."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_search import deep_a_star

from rtkit.errors import Impossible
from rtkit.planner import (
    Alike,
    Command,
    Condition,
    Evaluator,
    Problem,
    optimal_plans,
    plan,
    plan_within,
    verify,
)

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


@given(problems(), st.sampled_from([Fraction(0), Fraction(1, 2), Fraction(1)]))
@settings(max_examples=150, deadline=None)
def test_any_tie_costs_as_much_for_no_more_states_than_a_plain_search(problem, share):
    heuristic = exact_heuristic(problem, share)
    cost, most = deep_a_star(problem, heuristic)
    if cost is None:
        with pytest.raises(Impossible):
            plan(problem, heuristic, ties="any")
        return
    found = plan(problem, heuristic, ties="any")
    assert verify(problem, found) == ""
    assert found.cost == found.lower_bound == cost
    assert found.statistics.expanded <= min(most, plan(problem, heuristic).statistics.expanded)


SIDE = 8
DIRECTIONS = {"left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}
places = st.tuples(st.integers(0, SIDE - 1), st.integers(0, SIDE - 1))
walls = st.frozensets(places, max_size=SIDE * SIDE // 3)


def grid(walls, goal, costs=None, seen=None) -> Problem:
    """Return ways among walls, by moves that would lead on for ever but for the domains."""

    def move(name, dx, dy):
        def is_free(state):
            if seen is not None:
                seen.add(state)
            return (state[0] + dx, state[1] + dy) not in walls

        free = Condition("is free", is_free)
        return Command(name, lambda s: (s[0] + dx, s[1] + dy), (free,))

    moves = [move(name, *by) for name, by in DIRECTIONS.items()]
    side = range(SIDE)
    return Problem({"x": side, "y": side}, (0, 0), {"x": goal[0], "y": goal[1]}, moves, costs)


def reached(problem: Problem) -> set[tuple[int, int]]:
    """Return all that can be reached, by another way than the planner's."""
    found, todo = set(), [problem.start]
    while todo:
        state = todo.pop()
        if state in found or not all(0 <= value < SIDE for value in state):
            continue
        found.add(state)
        todo += [
            command.effect(state)
            for command in problem.commands
            if all(condition.holds(state) for condition in command.conditions)
        ]
    return found


@given(walls, places, st.integers(1, 3))
@settings(max_examples=100, deadline=None)
def test_among_walls_any_tie_takes_no_more_states_either(walls, goal, along):
    problem = grid(walls - {(0, 0)}, goal, {"left": along, "right": along})
    for heuristic in (
        lambda _: 0,
        lambda s: along * abs(goal[0] - s[0]) + abs(goal[1] - s[1]),
    ):
        cost, most = deep_a_star(problem, heuristic)
        if cost is None:
            continue
        found = plan(problem, heuristic, ties="any")
        assert (found.cost, verify(problem, found)) == (cost, "")
        assert found.statistics.expanded <= most


SEARCHES = [
    plan,
    lambda problem: plan(problem, ties="any"),
    lambda problem: next(iter(optimal_plans(problem))),
    lambda problem: plan_within(problem, 1.5, sum),
]


@pytest.mark.parametrize("search", SEARCHES)
@given(walls, places)
@settings(max_examples=60, deadline=None)
def test_no_search_leaves_the_domains_and_each_ends(search, walls, goal):
    seen: set[tuple[int, int]] = set()
    problem = grid(walls - {(0, 0)}, goal, seen=seen)
    there = reached(problem)
    seen.clear()
    if goal in there:
        found = search(problem)
        assert all(step.after in there for step in found.steps)
    else:
        with pytest.raises(Impossible, match=f"all {len(there)} states"):
            search(problem)
        assert seen == there
    assert seen <= there


@given(walls, st.lists(st.tuples(places, places), min_size=1, max_size=6))
@settings(max_examples=60, deadline=None)
def test_legs_that_are_alike_by_a_mirror_cost_the_same(walls, asked):
    both = walls | {(SIDE - 1 - x, y) for x, y in walls}
    problem = grid(both, (0, 0))

    def flip(way):
        return tuple((SIDE - 1 - x, y) for x, y in way)

    def key_to(goal):
        def key(state):
            here, there = (state, goal), (flip([state])[0], flip([goal])[0])
            if here <= there:
                return Alike(here, tuple, tuple)
            return Alike(there, flip, flip)

        return key

    known = Evaluator()
    for start, goal in [*asked, *(tuple(flip(pair)) for pair in asked)]:
        wish = dict(zip("xy", goal, strict=True))
        path = known.leg(problem, "xy", wish, key=key_to(goal))(start)
        plain = Evaluator(is_caching=False).leg(problem, "xy", wish)(start)
        assert (path is None) == (plain is None)
        if path is not None:
            assert (path.cost, path.end) == (plain.cost, plain.end)
            assert sum(step.cost for step in path.steps) == path.cost
            assert all(step.command.effect(step.before) == step.after for step in path.steps)
    assert known.evaluations == len({min(each, flip(each)) for each in asked})
