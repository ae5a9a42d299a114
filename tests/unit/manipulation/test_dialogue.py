"""Dialogues with the operator: what is asked, planned, done, learnt, kept."""

from __future__ import annotations

from pathlib import Path

import pytest
from manipulation import explore, store, take
from manipulation.execution import SEARCH
from manipulation.orders import Report
from manipulationkit import DOORWAY, SWITCH, Bench

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.planner import Evaluator, execute, plan


def test_one_take_is_walked_gripped_carried_and_released() -> None:
    bench = Bench("switch", "designate object at (3 4) A", "designate object at (7 4) B")
    bench.say("take A to (7 2)")
    assert bench.run() == "take A to (7 2): done, cost 17"
    assert bench.lies("thing1") == (7, 2)
    assert bench.dialogue.site.things["A"].pose == (7, 2, 0)
    assert bench.dialogue.state == "idle"


# the switch


def test_the_switch_offers_its_six_ways_and_names_the_ties() -> None:
    bench = Bench("switch", *SWITCH)
    assert "a and b and c and d tie at 31" in bench.say("switch A B X Y")
    assert bench.costs == [31, 31, 31, 31, 33, 35]
    assert bench.ordered == []


def test_the_switch_costs_what_the_planners_functions_cost() -> None:
    bench = Bench("switch", *SWITCH)
    bench.say("switch A B X Y")
    site = take.switch_site()
    for each in bench.dialogue.shown:
        first, second = each.way.parts[:2]
        way = take.switch(site, first.goal.target.place, second.goal.target.place)(site.state)
        assert way is not None
        assert way.cost == each.way.cost


def test_the_chosen_way_is_taken_and_the_objects_change_places() -> None:
    bench = Bench("switch", *SWITCH)
    bench.say("switch A B X Y")
    bench.answer("e")
    assert bench.run() == "switch A B X Y: done, cost 33"
    assert bench.lies("thing1") == (7, 4)
    assert bench.lies("thing2") == (3, 4)


# the doorway


def test_what_blocks_the_doorway_is_asked_about_and_put_away() -> None:
    bench = Bench("doorway", *DOORWAY)
    assert bench.say("take A to (9 3)").startswith("q1: in the way to take A to (9 3): B1 and B2;")
    assert "a and b tie at 39" in bench.answer("aside")
    bench.answer("b")
    assert bench.run() == "take A to (9 3): done, cost 39"
    assert bench.lies("thing1") == (9, 3)
    site = take.doorway_site(Evaluator())
    way = take.pass_doorway(site)(site.state)
    assert way is not None
    assert way.cost == 39
    assert bench.dialogue.legs.evaluations <= 63


def test_a_blocker_that_is_blocked_has_its_own_blocker_put_away() -> None:
    bench = Bench("corridor", "go to (2 4)", "go to (9 4)")
    bench.run()
    bench.say("designate wall at (2 3)", "designate object at (1 4) A")
    bench.say("designate object at (2 2) B", "designate object at (6 2) C")
    bench.say("designate region at (8 5) (9 5) far")
    asked = bench.say("take A to (4 2)")
    assert "in the way to take A to (4 2): B, or C;" in asked
    bench.answer("far")
    ways = [[part.goal.name for part in each.way.parts] for each in bench.dialogue.shown]
    assert ["C", "B", "A"] in ways  # C has to go, so that B can
    assert ["C", "A"] in ways


def test_a_blocked_task_may_be_dropped() -> None:
    bench = Bench("doorway", *DOORWAY)
    bench.say("take A to (9 3)")
    assert bench.answer("none") == "take A to (9 3): dropped"
    assert bench.dialogue.asked == {}


# fuzzy and relational goals


@pytest.mark.parametrize(
    ("goal", "places"),
    [
        (
            "near B",
            {(7, 5), (6, 4), (8, 4), (7, 3), (6, 5), (8, 5), (6, 3), (8, 3), (5, 4), (7, 2)},
        ),
        ("beside B", {(7, 5), (6, 4), (8, 4), (7, 3)}),
        ("left of B", {(5, 4), (6, 4)}),
        ("right of B", {(8, 4)}),
        ("above B", {(7, 5)}),
        ("below B", {(7, 2), (7, 3)}),
        ("to X", {(4, 5), (5, 5), (6, 5)}),
    ],
)
def test_a_goal_may_be_fuzzy(goal: str, places: set[tuple[int, int]]) -> None:
    bench = Bench("switch", *SWITCH)
    bench.say(f"take A {goal}")
    chosen = {each.way.parts[-1].goal.target.place for each in bench.dialogue.shown}
    assert chosen <= places
    assert len(chosen) == min(9, len(places))
    assert bench.costs == sorted(bench.costs)


def test_what_is_held_is_left_near_something() -> None:
    bench = Bench("switch", *SWITCH, "designate place at (8 1) the light switch")
    bench.say("pick up A")
    bench.run()
    assert bench.dialogue.site.holding == "A"
    bench.say("leave it near the light switch")
    bench.answer("a")
    assert "done" in bench.run()
    x, y = bench.lies("thing1")
    assert abs(x - 8) + abs(y - 1) <= 2


def test_nothing_is_left_where_nothing_is_held() -> None:
    bench = Bench("switch", *SWITCH)
    with pytest.raises(Malformed, match="nothing is held"):
        bench.say("leave it at (1 1)")


def test_a_second_object_is_not_taken_with_full_jaws() -> None:
    bench = Bench("switch", *SWITCH, "pick up A")
    bench.run()
    assert bench.say("take B to (8 1)").endswith("impossible: A is in the jaws: leave it first")


# prices


def test_prices_change_the_plan_in_sight() -> None:
    bench = Bench("room", "designate region at (5 3) gap", "go to (9 3)")
    bench.run()
    assert bench.dialogue.is_stopped
    bench.answer("box")
    bench.run()
    bench.say("go to (1 3)")
    assert len(bench.dialogue.shown) == 1
    before = str(bench.dialogue.way.steps)
    bench.dialogue.set_price("gap", 50)
    bench.step()
    assert str(bench.dialogue.way.steps) != before
    assert all(step.pose[:2] != (5, 3) for step in bench.dialogue.way.steps)


def test_alternatives_are_offered_where_criteria_differ() -> None:
    bench = Bench("room", "designate region at (5 3) gap")
    bench.dialogue.set_price("gap", 2)
    bench.say("go to (7 5)", "cancel", "go to (8 4)")
    told = [str(each) for each in bench.dialogue.shown]
    assert len(told) == 2
    assert "risk" in told[0]
    assert "least risk" in told[1]


def test_what_is_asked_follows_a_price() -> None:
    bench = Bench("switch", *SWITCH, "switch A B X Y")
    assert bench.costs[0] == 31
    bench.dialogue.set_price("carry", 1)
    assert bench.costs[0] == 21
    with pytest.raises(Malformed):
        bench.dialogue.set_price("carry", 0)
    with pytest.raises(Malformed):
        bench.dialogue.set_price("X", -1)
    with pytest.raises(NotFound, match="did you mean carry"):
        bench.dialogue.set_price("cary", 1)


def test_a_bar_is_turned_to_pass_and_that_has_its_price() -> None:
    bench = Bench("room", "designate bar at (2 6) (3 6) rod", "designate wall at (5 3)")
    bench.say("designate object at (7 3) box", "designate object at (8 5) cup")
    bench.say("take rod to (8 6)")
    assert bench.dialogue.way.costs["turn"] == 0
    bench.run()
    assert bench.lies("thing3") == (8, 6)
    bench.say("designate wall at (5 6)")
    assert "impossible" in bench.say("take rod to (2 6)")


def test_how_a_bar_lies_may_be_told_and_is_weighed_against_a_detour() -> None:
    bench = Bench("room", "designate bar at (2 6) (3 6) rod", "designate object at (7 3) box")
    bench.say("designate object at (8 5) cup", "designate object at (3 3) block")
    bench.say("take rod to (7 6) crosswise")
    assert bench.dialogue.way.costs == {"move": 6, "carry": 10, "turn": 3, "risk": 0}
    assert "done" in bench.run()
    assert bench.lies("thing3") == (7, 6)
    assert bench.table.things["thing3"].turned == pytest.approx(1.5707963)
    assert bench.dialogue.site.things["rod"].pose == (7, 6, 1)
    bench.say("take rod to (2 2) lengthwise")  # gripped crosswise, so the jaws turn first
    assert bench.run().startswith("take rod to (2 2) lengthwise: done")
    assert bench.dialogue.site.things["rod"].pose == (2, 2, 0)
    with pytest.raises(Malformed, match="cup is no bar"):
        bench.say("take cup to (9 5) crosswise")
    with pytest.raises(Malformed, match="for bars only"):
        bench.say("go to (1 1) crosswise")


# questions


def test_questions_are_answered_in_any_order_or_never() -> None:
    bench = Bench("switch", *SWITCH)
    bench.say("take A to X", "designate object at (1 3)", "go to Y")
    assert list(bench.dialogue.asked) == ["q1", "q2", "q3"]
    assert bench.dialogue.asked["q2"].kind == "name"
    bench.answer("a", "q3")
    bench.answer("cup", "q2")
    assert bench.dialogue.site.things["cup"].pose == (1, 3, 0)
    assert bench.run() == "go to Y: done, cost 6"
    assert list(bench.dialogue.asked) == ["q1"]
    bench.answer("a", "q1")
    assert "take A to X: done" in bench.run()


def test_a_late_answer_and_a_wrong_one_are_refused() -> None:
    bench = Bench("switch", *SWITCH, "take A to X")
    with pytest.raises(Malformed, match="one of a b c none"):
        bench.answer("z")
    bench.say("cancel")
    with pytest.raises(NotFound, match="no such question is open: q1"):
        bench.answer("a", "q1")


# definitions


def test_a_command_that_cannot_end_is_refused() -> None:
    bench = Bench("switch", *SWITCH)
    with pytest.raises(Refused, match="swing cannot end: swing calls swing"):
        bench.say("define swing = go to (1 1); swing")
    bench.say("define one = go to (1 1)", "define two = one; go to (2 1)")
    with pytest.raises(Refused, match="one calls two calls one"):
        bench.say("define one = two")
    with pytest.raises(Malformed, match="no such command: jump"):
        bench.say("define three = jump")
    with pytest.raises(Malformed, match=r"no such command: pong$"):
        bench.say("define ping A = pong A")
    with pytest.raises(Refused, match="used by two"):
        bench.say("forget one")
    bench.say("two")
    assert bench.run() == "two: done, cost 1"


def test_names_are_looked_after() -> None:
    bench = Bench("switch", *SWITCH)
    for text in ("designate object at (3 4) C", "designate object at (9 9) C"):
        with pytest.raises(Malformed):
            bench.say(text)
    with pytest.raises(Malformed, match="A is a name already"):
        bench.say("designate place at (1 1) A")
    with pytest.raises(NotFound, match="nothing is called D"):
        bench.say("take D to (1 1)")
    bench.say("take A to X")
    with pytest.raises(Refused, match="part of a task"):
        bench.say("forget A")
    bench.say("cancel", "forget A")
    assert "A" not in bench.dialogue.site.things


# touch


def test_an_unknown_object_is_felt_shown_named_and_planned_with() -> None:
    bench = Bench("corridor", "go to (9 2)")
    assert bench.run() == "stopped: something is at (6 2); its name?"
    assert bench.dialogue.state == "stopped"
    assert bench.dialogue.asked["q1"].text == "what is at (6 2)? its name"
    assert bench.dialogue.site.hand == (5, 2, 0)
    assert bench.answer("box")
    assert bench.run() == "go to (9 2): done, cost 18"
    world = explore.TouchWorld([(6, 2)])
    assert execute(explore.route, world, plan).cost == 18
    bench.say("take box to (9 5)")
    assert "done" in bench.run()
    assert bench.lies("thing2") == (9, 5)


def test_a_name_that_never_comes_holds_nothing_up_for_ever() -> None:
    bench = Bench("corridor", "go to (9 2)")
    bench.run()
    bench.say("go to (1 1)")
    assert bench.run() == "a: cost 5 (move 5): go to (1 1)"  # it waits for the name
    bench.say("cancel", "go to (1 1)")
    assert bench.run() == "go to (1 1): done, cost 5"
    assert "q1" in bench.dialogue.asked
    bench.say("forget unknown1")
    assert bench.dialogue.asked == {}


def test_a_thing_without_a_name_stops_nothing() -> None:
    bench = Bench("switch", "designate object at (3 4)", "go to (2 1)")
    assert bench.run() == "go to (2 1): done, cost 1"
    assert bench.dialogue.state == "asking"


def test_a_manipulator_that_begins_anew_is_looked_at_anew() -> None:
    bench = Bench("switch", *SWITCH, "take A to (8 1)")
    while not bench.table.held:
        bench.step()
    bench.table = Bench("switch").table
    bench.dialogue.see(bench.table.report)
    assert (bench.dialogue.site.hand, bench.dialogue.site.holding) == ((1, 1, 0), "")
    assert bench.run() == "take A to (8 1): done, cost 26"
    assert bench.lies("thing1") == (8, 1)


def test_a_thing_that_is_not_in_the_middle_is_searched_in_order() -> None:
    for seed in range(1, 8):
        bench = Bench("switch", *SWITCH, "pick up A", seed=seed)
        true = bench.lies("thing1")
        spots = []
        while bench.dialogue.site.holding == "":
            spots.append(list(bench.dialogue.site.things["A"].empty))
            assert bench.step()
        tried = max(spots, key=len)
        assert tried == list(SEARCH[: len(tried)])
        found = SEARCH[len(tried)]
        assert max(abs(3 + found[0] - true[0]), abs(4 + found[1] - true[1])) <= 0.2


def test_what_is_nowhere_near_is_asked_about() -> None:
    bench = Bench("switch", "designate object at (2 2) ghost", "pick up ghost")
    assert bench.run() == "q1: ghost is not near (2 2)"
    assert len(bench.dialogue.site.things["ghost"].empty) == 9
    bench.answer("none")
    assert bench.dialogue.state == "idle"


# restarts and memory


@pytest.mark.parametrize("steps", range(0, 44, 3))
def test_killed_in_mid_plan_it_plans_anew_from_what_it_sees(steps: int) -> None:
    bench = Bench("doorway", *DOORWAY, "take A to (9 3) clearing into aside", seed=3)
    bench.answer("a")
    for _ in range(steps):
        bench.step()
    bench.restart()
    assert bench.run().startswith("take A to (9 3) clearing into aside: done")
    assert bench.lies("thing1") == (9, 3)
    assert bench.dialogue.site.hand[:2] == (9, 3)


def test_the_choice_survives_and_what_was_done_is_not_done_again() -> None:
    bench = Bench("switch", *SWITCH, "switch A B X Y")
    bench.answer("e")
    for _ in range(14):
        bench.step()
    bench.restart()
    assert bench.run() == "switch A B X Y: done, cost 33"


def test_a_question_is_asked_again_after_a_restart() -> None:
    bench = Bench("switch", *SWITCH, "switch A B X Y")
    bench.restart()
    assert len(bench.dialogue.asked) == 1
    assert bench.costs == [31, 31, 31, 31, 33, 35]
    assert bench.dialogue.definitions.keys() == {"switch"}


def test_a_kill_that_loses_the_last_word_is_put_right_by_the_sensors() -> None:
    bench = Bench("switch", *SWITCH)
    bench.say("take A to (8 1)")
    while not bench.table.held:
        kept = bench.dialogue.site.holding
        bench.step()
    assert kept == ""
    bench.dialogue.site.holding = ""  # as if it had died before it noted that
    bench.restart()
    assert bench.dialogue.site.holding == "A"
    assert "done" in bench.run()
    assert bench.lies("thing1") == (8, 1)


def test_a_task_solved_before_is_answered_from_memory() -> None:
    bench = Bench("switch", *SWITCH, "switch A B X Y")
    first = bench.dialogue.legs.evaluations
    assert first > 0
    bench.say("cancel", "switch A B X Y")
    assert bench.dialogue.legs.evaluations == first
    bench.restart()
    bench.say("cancel", "switch A B X Y")
    assert bench.dialogue.legs.evaluations == first
    bench.say("cancel", "designate wall at (8 1)", "switch A B X Y")
    assert bench.dialogue.legs.evaluations == first  # not on its way
    bench.say("cancel", "designate wall at (5 4)")
    bench.say("switch A B X Y")
    assert bench.dialogue.legs.evaluations > first


def test_what_is_kept_comes_back_as_it_was() -> None:
    bench = Bench("room", "designate bar at (2 6) (3 6) rod", "designate region at (5 3) door")
    bench.say("designate place at (10 7) light switch", "define home = go to (1 1)", "home")
    bench.dialogue.set_price("turn", 7)
    bench.dialogue.set_price("door", 4)
    bench.run()
    before = store.saved(bench.dialogue)
    bench.restart()
    assert store.saved(bench.dialogue) == before


def test_a_file_that_is_no_memory_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "table.json"
    assert store.read(file) is None
    for text in ("", "[]", "{}", '{"form": 9}', '{"form": 1}'):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(Malformed, match="begin anew"):
            store.read(file)
    bench = Bench("switch", *SWITCH)
    store.write(bench.dialogue, file)
    again = store.read(file)
    assert again is not None
    assert store.saved(again) == store.saved(bench.dialogue)


def test_a_report_that_belongs_to_nothing_changes_nothing() -> None:
    bench = Bench("switch", *SWITCH)
    before = bench.dialogue.site.state
    bench.dialogue.see(Report(99, "done", 0.1, 0.1))
    assert bench.dialogue.site.state == before
