"""What the library promises beside finding plans: outcomes, costs, functions, judging, order."""

from __future__ import annotations

import shelve
from dataclasses import replace

import pytest

from rtkit.errors import Impossible, LimitReached, Malformed
from rtkit.planner import (
    Alike,
    Command,
    Condition,
    CostTable,
    Evaluator,
    Limits,
    Observation,
    OneOf,
    Problem,
    Row,
    Step,
    Touch,
    execute,
    layers,
    minimal_conflict,
    minimise,
    optimal_plans,
    plan,
    plan_within,
    predecessors,
    restrict,
    solved_in,
    verify,
)

SIZE = 6


def step(name, axis, by):
    def after(state):
        return (*state[:axis], state[axis] + by, *state[axis + 1 :])

    room = Condition("there is room", lambda s: 0 <= s[axis] + by < SIZE)
    return Command(name, after, (room,))


MOVES = [step("x+", 0, 1), step("x-", 0, -1), step("y+", 1, 1), step("y-", 1, -1)]


def grid(goal, start=(0, 0), **more):
    variables = {"x": range(SIZE), "y": range(SIZE)}
    return Problem(variables, start, goal, MOVES, **more)


def test_a_plan_tells_states_costs_and_what_was_looked_at():
    found = plan(grid({"x": 1, "y": 1}))
    assert [tuple(s)[1:] for s in found.steps] == [((0, 0), (1, 0), 1), ((1, 0), (1, 1), 1)]
    assert found.commands == ("x+", "y+")
    assert found.statistics.expanded >= 2
    assert found.statistics.generated > found.statistics.expanded


def test_what_holds_already_takes_no_step():
    found = plan(grid({"x": 0}))
    assert (found.steps, found.cost, found.lower_bound) == ((), 0, 0)
    assert optimal_plans(grid({"x": 0})).count == 1
    assert [each.steps for each in optimal_plans(grid({"x": 0}))] == [()]


def test_a_goal_may_be_a_choice_or_a_predicate():
    assert plan(grid({"x": OneOf([4, 2]), "y": 0})).cost == 2
    assert plan(grid(lambda s: s[0] + s[1] == 3)).commands == ("x+", "x+", "x+")


def test_impossible_and_given_up_are_told_apart():
    stuck = grid(lambda s: False)
    with pytest.raises(Impossible, match="all 36 states"):
        plan(stuck)
    with pytest.raises(LimitReached, match="first 10 states"):
        plan(stuck, limits=Limits(states=10))
    with pytest.raises(LimitReached, match="within 0 s"):
        plan(stuck, limits=Limits(seconds=0))
    with pytest.raises(Impossible):
        plan(stuck, limits=Limits(states=36))
    for error in (Impossible, LimitReached):
        assert not issubclass(error, Impossible if error is LimitReached else LimitReached)
    assert Impossible.detail != LimitReached.detail


def test_ties_go_to_fewer_steps_and_then_to_the_first_commands():
    jump = Command("jump", lambda s: (s[0] + 2, s[1]), (Condition("", lambda s: s[0] < 4),))
    problem = grid({"x": 2, "y": 1}).replaced(commands=[*MOVES, jump], costs={"jump": 2})
    assert plan(problem).commands == ("y+", "jump")
    assert optimal_plans(problem).count == 3 + 2


def test_costs_may_be_rows_for_states_and_functions():
    table = CostTable({"x+": 1}, (Row("x+", {"y": 0}, 5),))
    assert plan(grid({"x": 5}, costs=table)).commands[0] == "y+"
    by_state = plan(grid({"x": 2}, costs=lambda _c, before, _a: 1 + before[0]))
    assert by_state.cost == 3
    with pytest.raises(Malformed, match="no such variable: z"):
        grid({}, costs=CostTable(rows=(Row("x+", {"z": 0}, 5),)))
    with pytest.raises(Malformed, match="not greater than 0"):
        plan(grid({"x": 2}, costs={"x+": 0}))


def test_any_tie_is_the_same_one_each_time_and_a_misspelt_word_is_refused():
    problem = grid({"x": 3, "y": 3})
    found = plan(problem, ties="any")
    assert plan(problem, ties="any").commands == found.commands
    assert (found.cost, found.lower_bound, verify(problem, found)) == (6, 6, "")
    assert plan(grid({"x": 0}), ties="any").steps == ()
    with pytest.raises(Impossible, match="all 36 states"):
        plan(grid(lambda s: False), ties="any")
    with pytest.raises(Malformed, match=r'ties are "first" or "any", not \'all\''):
        plan(problem, ties="all")


def test_a_bad_heuristic_is_refused_and_never_trusted():
    problem = grid({"x": 3})
    assert plan(problem, lambda s: 3 - s[0] if s[0] < 3 else 0).cost == 3
    with pytest.raises(Malformed, match="not consistent"):
        plan(problem, lambda s: 5 * abs(3 - s[0]))
    with pytest.raises(Malformed, match="goal is not 0"):
        plan(problem, lambda _: 1)
    with pytest.raises(Malformed, match="negative"):
        plan(problem, lambda _: -1)


def test_a_guide_may_mislead_within_a_bound_that_is_told():
    problem = grid({"x": 5, "y": 5}, costs={"x+": 3})
    guided = plan_within(problem, 2, lambda s: 100 * (10 - sum(s)), lambda s: 10 - sum(s))
    assert guided.cost <= 2 * plan(problem).cost
    assert guided.lower_bound <= plan(problem).cost
    assert verify(problem, guided) == ""
    with pytest.raises(Impossible):
        plan_within(grid(lambda s: False), 2, lambda _: 0)
    with pytest.raises(LimitReached):
        plan_within(grid(lambda s: False), 2, lambda _: 0, limits=Limits(states=3))
    with pytest.raises(Malformed):
        plan_within(problem, 0.5, lambda _: 0)


def test_states_and_goals_outside_of_the_domains_are_refused():
    with pytest.raises(Malformed, match="x cannot be 9"):
        grid({"x": 9})
    with pytest.raises(Malformed, match="no such variable: z"):
        grid({"z": 0})
    with pytest.raises(Malformed, match="differ in: y"):
        grid({}, start={"x": 0})


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda p: replace(p, steps=p.steps[1:]), "begins at"),
        (lambda p: replace(p, steps=p.steps[:1]), "desired does not hold"),
        (lambda p: replace(p, cost=9), "cost 2, not 9"),
        (lambda p: replaced(p, cost=3), "costs 1, not 3"),
        (lambda p: replaced(p, after=(1, 1)), "leads to"),
        (lambda p: replaced(p, command=MOVES[1]), "does not hold: there is room"),
        (lambda p: replaced(p, command=step("fly", 0, 1)), "no such command"),
    ],
)
def test_what_is_wrong_with_a_plan_is_found(change, why):
    problem = grid({"x": 2})
    assert why in verify(problem, change(plan(problem)))


def replaced(found, **changes):
    return replace(found, steps=(found.steps[0]._replace(**changes), *found.steps[1:]))


def test_a_plan_that_leaves_its_cross_section_or_domains_is_found():
    found = plan(grid({"x": 1}))
    frozen = restrict(grid({"x": 1}), ["y"])
    assert "x is frozen" in verify(frozen, found)
    wild = [Command("out", lambda s: (99, s[1]))]
    problem = grid(lambda s: s[0] == 99).replaced(commands=wild)
    out = Step(wild[0], (0, 0), (99, 0), 1)
    assert "x cannot be 99" in verify(problem, replace(found, steps=(out,)))


def endless(goal):
    """Return a problem whose only command leads on for ever, but for the domain."""
    onward = Command("inc", lambda s: (s[0] + 1,))
    return Problem({"x": (0, 1, 2, 5)}, (0,), goal, [onward])


@pytest.mark.parametrize("search", [plan, optimal_plans, lambda p: plan_within(p, 2, lambda _: 0)])
def test_no_plan_leaves_the_domains_and_without_one_the_search_ends(search):
    assert search(endless({"x": 2})).cost == 2
    with pytest.raises(Impossible, match="all 3 states"):
        search(endless({"x": 5}))


def test_where_there_is_no_state_a_price_need_not_be_one():
    onward = Command("inc", lambda s: (s[0] + 1,))
    for price in (lambda _c, _b, after: {1: 1, 2: 1}[after[0]], lambda _c, _b, after: 3 - after[0]):
        problem = Problem({"x": range(3)}, (0,), {"x": 2}, [onward], price)
        assert plan(problem).commands == ("inc", "inc")
        with pytest.raises(Impossible):
            plan(problem.replaced(goal=lambda _: False))
    with pytest.raises(KeyError):
        plan(problem.replaced(costs=lambda _c, _b, after: {}[after[0]]))


def test_ties_are_told_among_costs_that_are_no_whole_numbers():
    costs = {"x+": 0.1, "y+": 0.2, "jump": 0.3}
    jump = Command("jump", lambda s: (s[0] + 1, s[1] + 1))
    problem = grid({"x": 1, "y": 1}, costs=costs).replaced(commands=[*MOVES, jump])
    for heuristic in (None, lambda s: 0.1 * (1 - s[0]) + 0.2 * (1 - s[1]) if max(s) < 2 else 0.3):
        every = optimal_plans(problem, heuristic)
        assert (every.count, every.cost) == (3, 0.3)
        assert len(list(every)) == 3
        assert plan(problem, heuristic).commands == ("jump",)


def test_a_misspelt_command_in_a_table_of_costs_is_refused():
    for costs in ({"y++": 2}, CostTable(rows=(Row("y++", {"x": 0}, 2),))):
        with pytest.raises(Malformed, match=r"y\+\+: no such command \(did you mean y\+\?\)"):
            grid({}, costs=costs)
    for known in ("Move left", "Open", "Grasp block1"):
        command = Command(known, lambda s: (1,))
        for slip in ("Move lft", "move left", "Opne", "Openn", "Garsp block1"):
            is_meant = slip[0].lower() == known[0].lower()
            table = {known: 2, slip: 3}
            if is_meant:
                with pytest.raises(Malformed, match=f"cost of {slip}: .*did you mean {known}"):
                    Problem({"x": range(2)}, (0,), {"x": 1}, [command], table)
            else:
                assert Problem({"x": range(2)}, (0,), {"x": 1}, [command], table)
    # A table may serve problems that lack some of its commands.
    siblings = {"Move right": 1, "Grasp block2": 1, "Grasp block12": 1, "Grasp block": 1, "Op": 1}
    assert grid({}, costs={**dict.fromkeys(["x+", "x-", "y+", "y-"], 2), **siblings})
    assert plan(grid({"x": 1}, costs={**dict.fromkeys(["x+", "x-", "y+", "y-"], 2), "y++": 1}))


def test_a_misspelt_command_is_told_when_a_function_offers_it():
    offered = [Command("Move left", lambda s: (s[0] + 1,))]

    def solved(**costs):
        costs = {name.replace("_", " "): cost for name, cost in costs.items()}
        return plan(Problem({"x": range(3)}, (0,), {"x": 2}, lambda _: offered, costs)).cost

    with pytest.raises(Malformed, match=r"cost of Mvoe left: .*\(did you mean Move left\?\)"):
        solved(Mvoe_left=2)
    assert solved(Move_right=2) == 2
    assert solved(Move_left=2, Mvoe_left=3) == 4


def test_a_plan_in_a_cross_section_is_one_step_a_level_up():
    section = restrict(grid({}), ["x"])
    across, plan_from = solved_in("across", section, {"x": 5}, plan)
    whole = grid({"x": 5, "y": 1}).replaced(
        commands=[across, *MOVES[2:]],
        costs=lambda command, before, _: plan_from(before).cost if command is across else 1,
    )
    found = plan(whole)
    assert (found.cost, found.commands) == (6, ("across", "y+"))
    assert plan_from(found.steps[0].before).commands == ("x+",) * 5
    assert verify(whole, found) == ""


def test_functions_follow_one_another_and_are_minimised_over_a_region():
    evaluator = Evaluator()
    problem = grid({})

    def go(axis, to):
        return evaluator.leg(problem, [axis], {axis: to})

    both = go("x", 3).followed_by(go("y", 2))
    assert (both((0, 0)).cost, both((0, 0)).end) == (5, (3, 2))
    assert (evaluator.asked, evaluator.evaluations) == (4, 2)
    best = minimise([5, 1, 3], lambda x: go("x", x))
    assert best((2, 0)).end == (1, 0)
    bounded = minimise([5, 1, 3], lambda x: go("x", x), lambda s, x: abs(s[0] - x))
    before = evaluator.asked
    assert bounded((4, 0)).cost == 1
    assert evaluator.asked == before + 1
    # What does not stand in the way of another problem does of this one.
    blocked = problem.replaced(commands=[])
    assert evaluator.leg(blocked, ["x"], {"x": 3})((0, 0)) is None
    assert go("x", 3).followed_by(evaluator.leg(blocked, ["x"], {"x": 0}))((0, 0)) is None


def mirrored(goal):
    """Return the key of a leg along x on which left and right are alike."""

    def key(state):
        if state[0] <= goal:
            return Alike(("along", state[0], goal), tuple, tuple)
        size = SIZE - 1

        def flip(way):
            return tuple((size - x,) for (x,) in way)

        return Alike(("along", size - state[0], size - goal), flip, flip)

    return key


def test_a_caller_s_key_may_mirror_a_leg():
    evaluator = Evaluator()
    problem = grid({})

    def go(to):
        return evaluator.leg(problem, ["x"], {"x": to}, key=mirrored(to))

    assert go(3)((1, 0)).cost == 2
    there = go(2)((4, 5))
    assert (there.cost, there.end) == (2, (2, 5))
    assert [(str(step.command), step.before) for step in there.steps] == [
        ("x-", (4, 5)),
        ("x-", (3, 5)),
    ]
    assert (evaluator.asked, evaluator.evaluations) == (2, 1)


def test_what_a_caller_keeps_is_walked_again_and_planned_anew_where_that_fails(tmp_path):
    def going(costs, problem=None):
        with shelve.open(tmp_path / "known") as known:
            evaluator = Evaluator(known=known)
            whole = problem or grid({}, costs=costs)
            leg = evaluator.leg(whole, ["x"], {"x": 3}, key=lambda s: f"from {s[0]}")
            path = leg((0, 2))
        return path and (path.cost, path.end), evaluator.evaluations

    assert going(None) == ((3, (3, 2)), 1)
    assert going(None) == ((3, (3, 2)), 0)
    assert going({"x-": 7}) == ((3, (3, 2)), 0)
    assert going({"x+": 2}) == ((6, (3, 2)), 1)
    assert going({"x+": 2}) == ((6, (3, 2)), 0)
    assert going(None, grid({}).replaced(commands=[])) == (None, 1)
    assert going(None) == (None, 0), "a caller's key that says too little is believed"


def test_keys_of_the_caller_are_not_those_of_the_evaluator():
    known = {}
    evaluator = Evaluator(known=known)
    assert evaluator.leg(grid({}), ["x"], {"x": 3})((0, 0)).cost == 3
    assert known == {}
    assert evaluator.leg(grid({}), ["x"], {"x": 2}, key=hash)((0, 0)).cost == 2
    assert len(known) == 1
    bare = Evaluator(is_caching=False, known=known)
    assert bare.leg(grid({}), ["x"], {"x": 2}, key=hash)((0, 0)).cost == 2
    assert bare.evaluations == 1


def test_a_cache_that_is_none_is_told(tmp_path):
    with pytest.raises(Malformed, match="known answers are kept in a mapping, not in 7"):
        Evaluator(known=7)
    with shelve.open(tmp_path / "known") as shelf:
        for known, key in ((shelf, lambda s: s), ({}, lambda s: [s]), ({1: 0}, lambda _: 1)):
            leg = Evaluator(known=known).leg(grid({}), ["x"], {"x": 3}, key=key)
            with pytest.raises(Malformed, match="the cache has no answers for keys like"):
                leg((0, 0))


def test_a_world_that_never_behaves_is_given_up():
    class Slippery:
        def look(self):
            return Observation((0, 0))

        def perform(self, step):
            return Observation((0, 0))

    with pytest.raises(LimitReached, match="differed from 3 plans"):
        execute(lambda state, _: grid({"x": 1}, state), Slippery(), plan, most_plans=3)


def test_order_is_kept_only_where_steps_touch_the_same():
    touches = [
        Touch(frozenset(), frozenset("a")),
        Touch(frozenset("a"), frozenset("b")),
        Touch(frozenset("a"), frozenset("c")),
        Touch(frozenset("bc"), frozenset("d")),
        Touch(frozenset(), frozenset("a")),
        Touch(frozenset(), frozenset("z")),
    ]
    before = predecessors(touches)
    assert before == [set(), {0}, {0}, {1, 2}, {0, 1, 2}, set()]
    assert layers(before) == [[0, 5], [1, 2], [3, 4]]


def test_of_a_conflict_nothing_can_be_left_out():
    asked = []

    def is_possible(wishes):
        asked.append(wishes)
        return not {3, 40, 41} <= set(wishes)

    assert set(minimal_conflict(range(100), is_possible)) == {3, 40, 41}
    assert len(asked) < 60
    assert minimal_conflict(range(10), is_possible) == ()
    assert minimal_conflict([1], lambda _: False) == ()


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"variables": {"lamp": 3}}, "the domain of lamp is no collection of values: 3"),
        ({"variables": ["lamp"]}, "variables are a mapping of names to domains, not list"),
        ({"start": None}, "the start is a mapping or a tuple of values, not None"),
        ({"start": ("off", 1)}, "the start has 2 values, but there are 1 variables"),
        ({"goal": None}, "the goal is a mapping or a function of a state, not None"),
        ({"goal": {"lmap": "on"}}, "no such variable: lmap (did you mean lamp?)"),
        ({"commands": None}, "commands are a sequence or a function of a state, not None"),
        ({"commands": "push"}, "commands are a sequence or a function of a state, not str"),
        ({"commands": ["push"]}, "no command: 'push'"),
        ({"costs": {"push": "3"}}, "cost of push is no number: '3'"),
        (
            {"commands": [Command("push", lambda _state: ("on",), lambda _state: True)]},
            "conditions of push are a tuple of Condition, not function",
        ),
        (
            {"commands": [Command("push", lambda _state: ("on", 1))]},
            "an effect returned ('on', 1), which is not a tuple of 1 values that can be hashed",
        ),
        (
            {"commands": [Command("push", lambda _state: ["on"])]},
            "an effect returned ['on'], which is not a tuple of 1 values that can be hashed",
        ),
        (
            {"commands": [Command("push", lambda _state: None)]},
            "an effect returned None, which is not a tuple of 1 values that can be hashed",
        ),
    ],
)
def test_bad_input_is_told(changed, told):
    given = {
        "variables": {"lamp": ("off", "on")},
        "start": {"lamp": "off"},
        "goal": {"lamp": "on"},
        "commands": [Command("push", lambda _state: ("on",))],
    }
    assert plan(Problem(**given)).cost == 1
    with pytest.raises(Malformed) as refused:
        plan(Problem(**given | changed))
    assert str(refused.value) == told
