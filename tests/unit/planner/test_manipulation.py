"""The cases of Whitney's manipulation tasks, each with its known answer."""

from __future__ import annotations

import heapq
import itertools
import pickle
import resource
import subprocess
import sys
from pathlib import Path

import pytest
from plain_search import deep_a_star

EXAMPLES = Path(__file__).parents[3] / "examples"
sys.path.insert(0, str(EXAMPLES))

from manipulation import explore, large, line, spar, take  # noqa: E402

from rtkit.errors import Impossible, LimitReached  # noqa: E402
from rtkit.planner import (  # noqa: E402
    Evaluator,
    Limits,
    execute,
    optimal_plans,
    plan,
    restrict,
    verify,
)

LEFT, RIGHT = "Move left", "Move right"


@pytest.mark.parametrize(
    ("problem", "cost", "plans"),
    [
        (
            line.jaws((4, 1), (1, 1)),
            5,
            [("Open", LEFT, LEFT, LEFT, "Close"), (LEFT, "Open", LEFT, LEFT, "Close")],
        ),
        (
            line.jaws((4, 1), (1, 1), line.OPEN_MOVES_COST_2),
            7,
            [(LEFT, "Open", LEFT, LEFT, "Close")],
        ),
        (line.jaws((4, 1), (2, 1), line.OPEN_MOVES_COST_2), 5, [(LEFT, "Open", LEFT, "Close")]),
        (
            line.jaws((4, 1), (1, 1), line.OPEN_MOVES_COST_2, block=1),
            6,
            [(LEFT, LEFT, "Open", LEFT, "Close")],
        ),
        (
            line.carrying((5, 0, 2), {"y": 4}),
            8,
            [(LEFT, LEFT, LEFT, "Close", "Carry right", "Carry right")],
        ),
        (line.carrying((5, 1, 4), {"y": 2}), 4, [("Push left", "Push left")]),
        (
            line.carrying((5, 1, 4), {"y": 2}, may_push=False),
            7,
            [("Open", LEFT, "Close", "Carry left", "Carry left")],
        ),
        (
            spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=3),
            11,
            [("-x", "+y", "rotate", "+x", "+x"), ("-x", "+y", "+x", "rotate", "+x")],
        ),
        (
            spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=1),
            7,
            [("rotate", "+x", "rotate", "+y", "rotate")],
        ),
    ],
)
def test_every_cheapest_plan_is_found(problem, cost, plans):
    found = optimal_plans(problem)
    assert found.cost == cost
    assert sorted(each.commands for each in found) == sorted(plans)
    assert found.count == len(plans)
    assert [verify(problem, each) for each in found] == [""] * len(plans)
    best = plan(problem)
    assert (best.cost, best.lower_bound) == (cost, cost)
    assert best.commands == next(iter(found)).commands


def test_plans_are_counted_without_being_listed():
    pushed = optimal_plans(line.carrying((5, 1, 3), {"x": 5, "h": 0, "y": 1}))
    assert (pushed.cost, pushed.count) == (9, 4)
    turned = optimal_plans(spar.spar((2, 2, 1), (3, 3, 0), move=1, rotate=1))
    assert (turned.cost, turned.count) == (5, 3)


def test_the_direct_way_of_the_spar_is_dearer():
    problem = spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=3)
    guarded = problem.replaced(
        commands=lambda s: problem.commands if spar.is_direct(s) else (),
    )
    direct = plan(guarded)
    assert (direct.cost, direct.commands.count("rotate")) == (13, 3)
    assert plan(problem).commands.count("rotate") == 1


def spar_by_hand(state):
    """Yield what a hand and a spar can become in one step, and its cost: told once more."""
    (x, y), across, closed, spar_at, spar_across = state
    walls = {frozenset([(2, y), (3, y)]): y == 1 for y in (1, 2, 3)}
    walls |= {frozenset([(x, 2), (x, 3)]): x not in (1, 3) for x in range(1, 6)}
    for to in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
        is_closed_up = walls.get(frozenset([(x, y), to]))
        if to[0] not in range(1, 6) or to[1] not in range(1, 4) or is_closed_up:
            continue
        along_y = to[0] == x
        if not closed:
            yield (to, across, False, spar_at, spar_across), 1
        elif is_closed_up is None or across == spar_across == along_y:
            yield (to, across, True, to, spar_across), 2
    if closed:
        yield ((x, y), not across, True, spar_at, not spar_across), 3
        yield ((x, y), across, False, spar_at, spar_across), 1
    else:
        yield ((x, y), not across, False, spar_at, spar_across), 1
        if spar_at == (x, y):
            yield ((x, y), across, True, spar_at, spar_across), 1


@pytest.mark.parametrize("start", [(2, 2, 1, 1, 2, 2, 0), (5, 1, 0, 0, 2, 2, 1)])
def test_the_spar_that_is_grasped_anywhere_costs_what_a_search_through_everything_says(start):
    x, y, a, h, sx, sy, sa = start
    costs, heap = {}, [(0, 0, ((x, y), a == 1, h == 1, (sx, sy), sa == 1))]
    met = itertools.count(1)
    while heap:
        cost, _, state = heapq.heappop(heap)
        if state not in costs:
            costs[state] = cost
            for after, more in spar_by_hand(state):
                heapq.heappush(heap, (cost + more, next(met), after))
    assert len(costs) == 15 * 2 * 15 * 2 + 15 * 2 * 2  # open anywhere, closed at the spar
    for goal in itertools.product(range(1, 6), range(1, 4), (0, 1)):
        problem = spar.handled(start, dict(zip(("sx", "sy", "sa"), goal, strict=True)))
        here = (goal[:2], goal[2] == 1)
        least = min(cost for state, cost in costs.items() if state[3:] == here)
        found = plan(problem)
        assert (found.cost, verify(problem, found)) == (least, "")
        assert plan(problem, ties="any").cost == least
    for state, cost in list(costs.items())[::7]:
        place, across, closed, spar_at, spar_across = state
        values = (*place, int(across), int(closed), *spar_at, int(spar_across))
        problem = spar.handled(start, dict(zip(problem.variables, values, strict=True)))
        assert plan(problem, ties="any").cost == cost


def test_a_spar_held_across_is_grasped_otherwise_before_a_doorway():
    every = optimal_plans(spar.handled((2, 2, 1, 1, 2, 2, 0), {"sx": 3, "sy": 3, "sa": 0}))
    assert (every.cost, every.count) == (13, 1)
    again, through = ("release", "turn", "grasp"), ("carry +x", "rotate", "carry +y", "rotate")
    assert next(iter(every)).commands == again + through
    closed_far_away = spar.handled((1, 1, 0, 1, 2, 2, 0), {"sx": 3})
    with pytest.raises(Impossible):
        plan(closed_far_away)


def test_switch():
    site = take.switch_site()
    table = [
        [take.switch(site, x, y)(site.state).cost for y in ((4, 4), (6, 4))]
        for x in ((4, 5), (5, 5), (6, 5))
    ]
    assert table == [[31, 31], [33, 31], [35, 31]]


def test_blocked_doorway_by_fewer_and_fewer_evaluations():
    counts = []
    known: dict[object, object] = {}
    for is_caching, bounded in ((False, False), (True, False), (True, True)):
        evaluator = Evaluator(is_caching=is_caching, known=known)
        known.clear()
        assert _through_the_doorway(evaluator, bounded=bounded) == 39
        counts.append(evaluator.evaluations)
    assert counts[0] == 130
    assert counts[1] <= 78
    assert counts[2] <= 63


def test_what_is_known_of_the_doorway_outlives_the_process():
    known: dict[object, object] = {}
    _through_the_doorway(Evaluator(known=known), bounded=True)
    again = Evaluator(known=pickle.loads(pickle.dumps(known)))
    assert _through_the_doorway(again, bounded=True) == 39
    assert again.asked > again.evaluations == 0


def _through_the_doorway(evaluator, *, bounded):
    site = take.doorway_site(evaluator)
    path = take.pass_doorway(site, bounded=bounded)(site.state)
    state = site.state
    for step in path.steps:
        assert step.before == state
        assert all(condition.holds(state) for condition in step.command.conditions)
        state = step.command.effect(state)
        assert state == step.after
    assert state == path.end
    assert state[1] == (9, 3)
    assert path.cost == sum(step.cost for step in path.steps)
    return path.cost


CASES = {
    "jaws": line.jaws((4, 1), (1, 1)),
    "open moves cost 2": line.jaws((4, 1), (1, 1), line.OPEN_MOVES_COST_2),
    "carry": line.carrying((5, 0, 2), {"y": 4}),
    "push": line.carrying((5, 1, 4), {"y": 2}),
    "push and come back": line.carrying((5, 1, 3), {"x": 5, "h": 0, "y": 1}),
    "spar": spar.spar((2, 2, 1), (3, 3, 0), move=2, rotate=3),
    "spar that turns": spar.spar((2, 2, 1), (3, 3, 0), move=1, rotate=1),
    "explore": explore.route((1, 2), ()),
}


@pytest.mark.parametrize("name", CASES)
def test_any_cheapest_plan_takes_no_more_states_than_a_plain_search(name):
    problem = CASES[name]
    found = plan(problem, ties="any")
    cost, most = deep_a_star(problem)
    assert found.cost == cost == plan(problem).cost
    assert found.statistics.expanded <= min(most, plan(problem).statistics.expanded)
    assert verify(problem, found) == ""


def test_any_cheapest_plan_of_a_large_space_is_found_in_half_as_many_states():
    instance = large.Large(2)
    found = plan(instance.problem(), instance.heuristic, Limits(states=42_365), ties="any")
    assert found.cost == 196
    assert verify(instance.problem(), found) == ""


def test_one_blocker_alone_is_never_enough():
    site = take.doorway_site(Evaluator())
    direct = site.take("A", (9, 3))
    for name in ("B1", "B2"):
        assert site.take_all([name], take.REGION, direct)(site.state) is None


def test_two_ways_through_the_doorway_are_the_cheapest():
    site = take.doorway_site(Evaluator())
    direct = site.take("A", (9, 3))
    costs = {}
    for (one, other), places in itertools.product(
        itertools.permutations(["B1", "B2"]), itertools.product(take.REGION, repeat=2)
    ):
        first, then = site.take(one, places[0]), site.take(other, places[1])
        path = first.followed_by(then).followed_by(direct)(site.state)
        if path is not None:
            costs[one, *places] = path.cost
    cheapest = {choice for choice, cost in costs.items() if cost == min(costs.values()) == 39}
    assert cheapest == {("B1", (5, 6), (5, 1)), ("B2", (5, 1), (5, 6))}


def test_an_unknown_object_is_planned_around_and_remembered():
    done = execute(explore.route, explore.TouchWorld([(6, 2)]), plan)
    assert [each.cost for each in done.plans] == [8, 14]
    assert done.cost == 18
    assert done.facts == {(6, 2)}
    again = execute(explore.route, explore.TouchWorld([(6, 2)]), plan, done.facts)
    assert [each.cost for each in again.plans] == [12]
    assert again.cost == 12


def test_a_way_that_turns_out_closed_is_impossible():
    wall = [(8, y) for y in range(1, 6)]
    with pytest.raises(Impossible):
        execute(explore.route, explore.TouchWorld(wall), plan)


def test_a_large_space_is_seen_only_where_it_must_be():
    instance = large.Large(2)
    problem = instance.problem()
    assert instance.weights == [4, 2, 4, 4, 3, 4]
    assert large.Large(1).weights == [1, 5, 3, 4, 2, 3]
    found = plan(problem, instance.heuristic, Limits(states=100_000))
    assert found.cost == 196
    assert found.statistics.expanded < 100_000
    assert verify(problem, found) == ""
    with pytest.raises(LimitReached):
        plan(problem, instance.heuristic, Limits(states=1000))


@pytest.mark.campaign
@pytest.mark.timeout(600)
def test_a_million_states_are_searched_within_two_gibibytes():
    code = (
        "from manipulation.large import Large; from rtkit.planner import plan;"
        "instance = Large(1); print(plan(instance.problem(), instance.heuristic).cost)"
    )
    limit = 2 * 2**30
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=EXAMPLES,
        capture_output=True,
        text=True,
        check=True,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )
    assert done.stdout == "176\n"


def test_a_cross_section_of_a_large_space_is_small():
    instance = large.Large(1)
    problem = restrict(instance.problem(), ["v0", "v1"]).replaced(goal=lambda s: s[0] + s[1] >= 6)
    found = plan(problem)
    assert found.statistics.expanded <= 100
    assert all(step.after[2:] == (0, 0, 0, 0) for step in found.steps)
    with pytest.raises(Impossible):
        plan(problem.replaced(goal={"v5": 1}))


def test_the_example_runs():
    done = subprocess.run(
        [sys.executable, "-m", "manipulation"],
        cwd=EXAMPLES,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "spar, turning is dear: cost 11, plans: 2" in done.stdout
    assert "planned 8, then 14; travelled 18; found {(6, 2)}" in done.stdout
    assert done.stderr == ""
