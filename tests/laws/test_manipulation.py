"""Laws of the supervised manipulator: memory never lies, kills change nothing, words come back."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from manipulation import store, take
from manipulation.dialogue import Dialogue
from manipulation.knowledge import UNIT
from manipulation.language import Go, PickUp, Take, Target, parse
from manipulation.legs import Legs, Question, passed
from manipulation.table import table_of
from manipulationkit import DOORWAY, SWITCH, Bench

from rtkit.errors import RtkitError

WIDTH, HEIGHT = 6, 5
places = st.tuples(st.integers(1, WIDTH), st.integers(1, HEIGHT))
cells = st.frozensets(places, max_size=12)
names = st.sampled_from(["A", "red block", "B2", "light switch"])
turns = st.sampled_from(["", "lengthwise", "crosswise"])
targets = st.one_of(
    st.builds(Target, st.just("at"), places, st.just(""), turns),
    st.builds(
        Target,
        st.sampled_from(["in", "was", "near", "beside", "left of", "right of", "above", "below"]),
        st.none(),
        names,
        turns,
    ),
)
goals = st.one_of(
    st.builds(Go, targets),
    st.builds(PickUp, names),
    st.builds(Take, names, targets, st.sampled_from(["", "aside"])),
)


@given(goals)
def test_what_is_meant_is_written_so_that_it_means_the_same(goal: Go | PickUp | Take) -> None:
    assert parse(str(goal), {}) == goal


@given(
    st.lists(cells, min_size=2, max_size=5),
    places,
    places,
    st.sampled_from([UNIT, ((0, 0), (1, 0)), ((0, 0), (0, 1))]),
    st.sampled_from([0.0, 1.0, 3.0]),
    st.dictionaries(places, st.integers(1, 4), max_size=4),
)
def test_memory_answers_as_a_fresh_search_would(
    grounds: list[frozenset[tuple[int, int]]],
    start: tuple[int, int],
    goal: tuple[int, int],
    shape: tuple[tuple[int, int], ...],
    turn: float,
    risks: dict[tuple[int, int], int],
) -> None:
    told = tuple(sorted(risks.items()))
    question = Question(shape, 1.0, turn, told, (*start, 0), (*goal, None))
    legs = Legs(WIDTH, HEIGHT)
    for blocked in grounds:
        found = legs.find(question, blocked)
        assert found.cost == Legs(WIDTH, HEIGHT).find(question, blocked).cost
        assert passed(question, found).isdisjoint(blocked)


@settings(max_examples=25)
@given(
    st.integers(0, 500),
    st.dictionaries(st.integers(1, 60), st.booleans(), max_size=3),
    st.sampled_from("abcdefghi"),
)
def test_kills_at_any_step_change_nothing_of_the_end(
    seed: int, kills: dict[int, bool], choice: str
) -> None:
    bench = Bench("doorway", *DOORWAY, "take A to (9 3) clearing into aside", seed=seed)
    bench.answer(choice)
    cost = next(e.way.cost for e in bench.dialogue.shown if e.letter == choice)
    number = 1
    while bench.step(is_seen=kills.get(number, True)):
        if number in kills:  # perhaps without a word of what became of its last order
            bench.restart()
        number += 1
    assert bench.dialogue.results[-1][1] == "done"
    assert bench.dialogue.results[-1][2] == cost
    assert bench.lies("thing1") == (9, 3)


@settings(max_examples=25)
@given(st.integers(0, 500), st.sampled_from("abcdef"))
def test_the_switch_comes_to_its_end_wherever_the_objects_lie(seed: int, choice: str) -> None:
    bench = Bench("switch", *SWITCH, "switch A B X Y", seed=seed)
    bench.answer(choice)
    assert "done" in bench.run()
    assert (bench.lies("thing1"), bench.lies("thing2")) == ((7, 4), (3, 4))
    assert bench.dialogue.legs.evaluations <= 19


@settings(max_examples=60)
@given(
    st.frozensets(places, max_size=9),
    st.lists(places, min_size=4, max_size=4, unique=True),
    st.integers(0, 99),
)
def test_a_take_costs_what_another_planner_says_and_is_done_by_touch(
    walls: frozenset[tuple[int, int]], at: list[tuple[int, int]], seed: int
) -> None:
    hand, a, b, goal = at
    assume(walls.isdisjoint(at))
    site = {"width": WIDTH, "height": HEIGHT, "walls": walls, "hand": hand}
    site["things"] = [{"at": a}, {"at": b}]
    bench = Bench("switch")
    bench.table = table_of(site, seed=seed)
    bench.table.speed = 2.0
    bench.dialogue = Dialogue(store.site_of(site))
    bench.say(f"designate object at ({a[0]} {a[1]}) A", f"designate object at ({b[0]} {b[1]}) B")
    bench.dialogue.see(bench.table.report)
    other = take.Site(WIDTH, HEIGHT, walls, {take.HAND: hand, "A": a, "B": b})
    expected = other.take("A", goal)(other.state)
    bench.say(f"take A to ({goal[0]} {goal[1]})")
    if expected is None:
        assert "B" in bench.dialogue.said or "impossible" in bench.dialogue.said
        return
    assert bench.run() == f"take A to ({goal[0]} {goal[1]}): done, cost {expected.cost:g}"
    assert bench.lies("thing1") == goal


sentences = st.sampled_from(
    [
        "take red block to (9 2)",
        "take the red block near light switch",
        "take cup to door",
        "take rod to (8 6)",
        "take rod beside cup",
        "pick up red block",
        "pick up ghost",
        "leave it near the light switch",
        "leave it at (2 2)",
        "go to (9 6)",
        "go to (1 1)",
        "go to door",
        "swap red block cup",
        "cancel",
        "designate wall at (5 6)",
        "designate object at (7 3)",
        "designate object at (4 4) ghost",
        "forget ghost",
        "forget box1",
        "designate region at (9 1) (10 1) (10 2) corner",
    ]
)
events = st.one_of(
    st.tuples(st.just("say"), sentences),
    st.tuples(st.just("answer"), st.integers(0, 9)),
    st.tuples(st.just("price"), st.sampled_from(["move", "carry", "turn", "door"])),
    st.tuples(st.just("steps"), st.integers(1, 25)),
    st.tuples(st.just("kill"), st.booleans()),
)


@settings(max_examples=40)
@given(st.integers(0, 50), st.lists(events, min_size=4, max_size=20))
def test_whatever_the_operator_says_the_model_is_what_is(
    seed: int, happened: list[tuple[str, Any]]
) -> None:
    bench = Bench(
        "room",
        "designate object at (3 3) red block",
        "designate object at (8 5) cup",
        "designate bar at (2 6) (3 6) rod",
        "designate region at (5 3) (5 6) door",
        "designate place at (10 7) light switch",
        "define swap A B = take A beside B; go to where A was; take B to where A was",
        seed=seed,
    )
    for kind, told in happened:
        _happen(bench, kind, told)
    for _ in range(1000):
        if not bench.step():
            break
    else:
        raise AssertionError("it never ends")
    site, report = bench.dialogue.site, bench.table.report
    assert site.hand[:2] == (round(report.x * 10), round(report.y * 10))
    assert bool(site.holding) == report.is_gripping
    for name, thing in (("red block", "thing1"), ("cup", "thing2"), ("rod", "thing3")):
        known, true = site.things[name].pose, bench.lies(thing)
        assert max(abs(known[0] - true[0]), abs(known[1] - true[1])) <= 0.5


def _happen(bench: Bench, kind: str, told: Any) -> None:
    dialogue = bench.dialogue
    if kind == "say":
        with suppress(RtkitError):
            bench.say(told)
    elif kind == "price":
        dialogue.set_price(told, 5.0 if seed_of(dialogue) else 1.0)
    elif kind == "kill":
        bench.step(is_seen=told)
        bench.restart()
    elif kind == "steps":
        for _ in range(told):
            bench.step()
    elif dialogue.asked:
        question = list(dialogue.asked.values())[told % len(dialogue.asked)]
        choices = question.choices or (f"box{len(dialogue.site.things)}",)
        with suppress(RtkitError):
            bench.answer(choices[told % len(choices)], question.id)


def seed_of(dialogue: Dialogue) -> int:
    return dialogue.revision % 2
