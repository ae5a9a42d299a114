"""The core of a start or stop, second by second."""

import pytest

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.conditions import OrderTarget, start_orders, stop_orders
from rtkit.deployment.execution import StartExecution
from rtkit.deployment.running import start_plan, stop_plan
from rtkit.rtc.enums import ReturnCode

NO = Result(ReturnCode.ERROR, "refused", "no luck")


class Clockwork:
    """An execution with a clock that jumps, and components that obey at once or when told."""

    def __init__(self, plan, timeout_s=None):
        self.now = 100.0
        self.states = {turn.target: "Inactive" for turn in plan.turns}
        self.execution = StartExecution(plan, self.now, timeout_s)
        self.turns = {turn.target.instance[-1]: turn for turn in plan.turns}
        self.goal = "Active" if plan.transition == "activate" else "Inactive"
        self.reports = []

    def go(self, seconds=0.0):
        """Let time pass and return which actions are begun, as the digits of their names."""
        self.now += seconds
        watched = self.execution.watched
        self.execution.saw({turn.target: self.states[turn.target] for turn in watched})
        begun = self.execution.ready(self.now)
        self.reports += self.execution.reports()
        return "".join(turn.target.instance[-1] for turn in begun)

    def put(self, name, state):
        """Have a component be in a state."""
        self.states[self.turns[name].target] = state

    def reply(self, name, result=None):
        """Answer an action; a good answer means that the state is reached."""
        if result is None:
            self.put(name, self.goal)
        self.execution.answered(self.turns[name], result or Result(), self.now)
        self.reports += self.execution.reports()

    @property
    def alarm(self):
        """In how many seconds it wants to be asked again."""
        moment = self.execution.next_moment()
        return None if moment is None else round(moment - self.now, 6)


@pytest.fixture
def begin(make, world):
    """Return what begins a start (or stop) of Sink0 … of which the rest is there."""

    def begun(count, *entries, stop=False, optional="", missing="", timeout_s=None):
        for number in range(count):
            if f"Sink{number}" not in missing.split():
                world.perform(act.Create(f"Sink?instance_name=Sink{number}"))
        profile = make.ordered(make.sinks(count, optional), *entries, stop=stop)
        orders = (stop_orders if stop else start_orders)(profile)
        plan_for = stop_plan if stop else start_plan
        clockwork = Clockwork(plan_for(*make.live(profile, world), orders), timeout_s)
        if stop:
            clockwork.states = dict.fromkeys(clockwork.states, "Active")
        return clockwork

    return begun


def test_one_after_the_other_each_answered_first(begin, make):
    clock = begin(3, make.entry("Sink0", 5), make.entry("Sink1", 2))
    assert (clock.go(), clock.go(50), clock.alarm) == ("2", "", None)
    clock.reply("2")
    assert (clock.go(), clock.go()) == ("1", "")
    clock.reply("1")
    assert clock.go() == "0"
    assert not clock.execution.is_over
    assert [turn.id for turn in clock.execution.running] == [3]
    clock.reply("0")
    assert clock.execution.is_over
    assert not clock.execution.failure


def test_a_wait_counts_from_the_beginning_of_the_delayed_part(begin, make):
    clock = begin(3, make.entry("Sink0", wait=1500), make.entry("Sink1", 2, wait=700))
    assert clock.go() == "2"
    clock.now += 30
    clock.reply("2")
    assert (clock.go(), clock.alarm) == ("", 0.7)
    assert (clock.go(0.69), clock.go(0.02), clock.alarm) == ("", "1", 0.79)
    assert clock.go(0.79) == "0"
    clock.reply("0")
    assert not clock.execution.is_over
    clock.reply("1")
    assert clock.execution.is_over


def test_nothing_immediate_begins_the_delayed_part_at_once(begin, make):
    clock = begin(1, make.entry("Sink0", wait=20))
    assert (clock.go(), clock.alarm, clock.go(0.02)) == ("", 0.02, "0")


def test_delayed_actions_do_not_wait_for_each_other(begin, make):
    clock = begin(2, make.entry("Sink0", wait=10), make.entry("Sink1", wait=20))
    clock.go()
    assert (clock.go(0.01), clock.go(0.01)) == ("0", "1")
    clock.reply("1")
    clock.reply("0")
    assert clock.execution.is_over


def test_those_that_are_ready_together_go_by_sequence(begin, make):
    clock = begin(
        4,
        make.entry("Sink0", 9, wait=10),
        make.entry("Sink1", 7, wait=5),
        make.entry("Sink2", 8, wait=7),
        make.entry("Sink3", 6, after="Sink0", timing="ASYNC"),
    )
    assert (clock.go(), clock.go(1)) == ("", "1203")


def test_async_waits_until_it_was_sent_not_for_the_state(begin, make):
    clock = begin(
        2, make.entry("Sink0", wait=100), make.entry("Sink1", after="Sink0", timing="ASYNC")
    )
    assert (clock.go(), clock.execution.watched) == ("", ())
    assert clock.go(0.1) == "01"


def test_sync_waits_for_the_state_whoever_brought_it_about(begin, make):
    clock = begin(2, make.entry("Sink0", wait=60_000), make.entry("Sink1", 2, after="Sink0"))
    clock.go()
    assert [turn.target.instance for turn in clock.execution.watched] == ["Sink0"]
    clock.put("0", "Active")
    assert clock.go(5) == "1"
    assert clock.execution.watched == ()


def test_sync_does_not_take_an_answer_for_the_state(begin, make):
    clock = begin(2, make.entry("Sink1", after="Sink0"))
    assert clock.go() == "0"
    assert clock.execution.watched == ()
    clock.reply("0")
    clock.put("0", "Inactive")
    assert clock.go() == ""
    assert [turn.target.instance for turn in clock.execution.watched] == ["Sink0"]
    clock.put("0", "Active")
    assert clock.go() == "1"


@pytest.mark.parametrize("state", ["Error", "Active (stopped)", "zombie (signal 9)", "missing"])
def test_who_died_meanwhile_is_waited_for_again(begin, make, state):
    entries = [make.entry("Sink1", 1, after="Sink0"), make.entry("Sink1", 1, wait=1000)]
    clock = begin(2, *entries)
    clock.go()
    clock.reply("0")
    clock.go(0.5)
    clock.put("0", state)
    assert clock.go(0.5) == ""
    clock.put("0", "Active")
    assert clock.go(3) == "1"


def test_several_conditions_must_all_hold(begin, make):
    clock = begin(
        4,
        make.entry("Sink3", 1, wait=50),
        make.entry("Sink3", 2, after="Sink0 Sink1"),
        make.entry("Sink3", 3, after="Sink2", timing="ASYNC"),
        make.entry("Sink2", 3, wait=200),
    )
    clock.go()
    clock.reply("0")
    clock.go()
    clock.reply("1")
    clock.put("1", "Inactive")
    assert (clock.go(), clock.go(0.1), clock.go(0.125)) == ("", "", "2")
    clock.put("1", "Active")
    assert clock.go() == "3"


# time-outs


def test_a_preceding_condition_that_is_not_met_in_time_ends_the_plan(begin, make):
    clock = begin(
        3,
        make.entry("Sink0", wait=5000),
        make.entry("Sink1", 2, after="Sink0", timeout=300),
        make.entry("Sink2", 3, wait=100),
    )
    assert (clock.go(), clock.alarm, clock.go(0.1), clock.alarm) == ("", 0.1, "2", 0.2)
    assert clock.go(0.2) == ""
    assert clock.execution.failure == (
        "Error executing plan: Preceding condition timed out: action {2} waited 300ms"
        " for: Sync to /localhost/Sink0.rtc (it is Inactive)"
    )
    assert [turn.id for turn in clock.execution.waiting] == [1, 2]
    assert clock.alarm is None
    assert not clock.execution.is_over
    clock.reply("2")
    assert clock.execution.is_over
    assert clock.go(60) == ""


def test_an_action_that_is_not_sent_in_time(begin, make):
    clock = begin(
        2,
        make.entry("Sink0", wait=5000),
        make.entry("Sink1", after="Sink0", timing="ASYNC", timeout=40),
    )
    clock.go()
    clock.go(0.04)
    assert clock.execution.failure.endswith(
        "action {2} waited 40ms for: After /localhost/Sink0.rtc's action (not sent)"
    )


def test_time_counts_anew_when_a_state_was_lost(begin, make):
    entries = [make.entry("Sink1", after="Sink0", timeout=100), make.entry("Sink1", wait=9000)]
    clock = begin(2, *entries)
    clock.go()
    clock.reply("0")
    clock.go()
    clock.go(5)
    clock.put("0", "Error")
    assert (clock.go(), clock.execution.failure, clock.alarm) == ("", "", 0.1)
    clock.go(0.1)
    assert "waited 100ms for: Sync to /localhost/Sink0.rtc (it is Error)" in clock.execution.failure


def test_a_bound_on_the_whole(begin, make):
    clock = begin(
        3,
        make.entry("Sink1", wait=60_000),
        make.entry("Sink2", 2, after="Sink1"),
        timeout_s=2.0,
    )
    assert (clock.go(), clock.alarm) == ("0", 2.0)
    clock.go(0.5)
    clock.reply("0")
    assert (clock.go(), clock.alarm) == ("", 1.5)
    clock.go(1.5)
    assert clock.execution.failure == (
        "Error executing plan: not finished within 2 s;"
        " action {3} waits for: Sync to /localhost/Sink1.rtc (it is Inactive)"
    )
    assert clock.execution.is_over


def test_the_bound_holds_for_what_is_under_way(begin, make):
    clock = begin(1, make.entry("Sink0"), timeout_s=2.0)
    clock.go()
    clock.go(2)
    assert clock.execution.failure == (
        "Error executing plan: not finished within 2 s; action {1} is under way"
    )
    assert not clock.execution.is_over


def test_only_some_of_many_are_told(begin, make):
    entries = [make.entry(f"Sink{n}", n, after="Sink0") for n in range(1, 6)]
    clock = begin(6, make.entry("Sink0", wait=60_000), *entries, timeout_s=1.0)
    clock.go()
    clock.go(1)
    assert clock.execution.failure.count("waits for") == 3
    assert clock.execution.failure.endswith("and 2 more")


def test_without_a_bound_patience_ends_when_nothing_happens(begin, make):
    clock = begin(
        3,
        make.entry("Sink0", wait=30_000),
        make.entry("Sink1", 2, after="Sink0"),
        make.entry("Sink2", 3, after="Sink1"),
    )
    clock.go()
    assert clock.go(30) == "0"
    assert clock.go(100) == ""
    clock.reply("0")
    assert (clock.go(), clock.alarm) == ("1", None)
    clock.go(7)
    clock.reply("1")
    clock.put("1", "Error")
    assert (clock.go(), clock.alarm) == ("", 10.0)
    assert (clock.go(9.9), clock.execution.failure) == ("", "")
    clock.go(0.1)
    assert clock.execution.failure == (
        "Error executing plan: nothing has happened for 10 s;"
        " action {3} waits for: Sync to /localhost/Sink1.rtc (it is Error)"
    )


# failures


def test_a_required_failure_ends_the_plan(begin, make):
    clock = begin(3, make.entry("Sink0"), make.entry("Sink1", wait=10), make.entry("Sink2", wait=5))
    clock.go()
    clock.reply("0")
    clock.go()
    assert clock.go(0.005) == "2"
    clock.reply("2", NO)
    assert clock.execution.failure == "Required action failed: /localhost/Sink2.rtc: no luck"
    assert (clock.go(1), clock.reports) == ("", [])
    assert clock.execution.is_over


def test_an_optional_failure_is_told_and_the_plan_goes_on(begin, make):
    clock = begin(3, make.entry("Sink2", after="Sink0", timing="ASYNC"), optional="Sink0")
    clock.go()
    clock.reply("0", NO)
    assert clock.reports == ["Action failed: /localhost/Sink0.rtc: no luck"]
    assert clock.go() == "1"
    clock.reply("1")
    assert clock.go() == "2"
    clock.reply("2")
    assert clock.execution.is_over
    assert not clock.execution.failure


def test_what_is_known_to_fail_is_not_begun(begin, make):
    clock = begin(2, make.entry("Sink0", 1), optional="Sink0", missing="Sink0")
    assert (clock.go(), clock.reports) == ("1", [])
    clock.reply("1")
    assert clock.go() == ""
    assert clock.reports == ["Action failed: Component missing: /localhost/Sink0.rtc"]
    assert clock.execution.is_over
    clock = begin(2, make.entry("Sink0", 1), missing="Sink0")
    clock.go()
    clock.reply("1")
    clock.go()
    assert clock.execution.failure == (
        "Required action failed: Component missing: /localhost/Sink0.rtc"
    )


def test_after_an_action_that_cannot_be_sent(begin, make):
    entries = [
        make.entry("Sink1", 1, after="Sink0", timing="ASYNC"),
        make.entry("Sink2", 2, after="Sink1", timing="ASYNC"),
    ]
    clock = begin(3, *entries, optional="Sink0 Sink1 Sink2", missing="Sink0")
    assert clock.go() == ""
    assert clock.alarm == 0.0
    assert clock.go() == ""
    assert clock.reports == [
        "Action failed: Component missing: /localhost/Sink0.rtc",
        "Action failed: Preceding condition cannot be met:"
        " After /localhost/Sink0.rtc's action, of /localhost/Sink1.rtc",
        "Action failed: Preceding condition cannot be met:"
        " After /localhost/Sink1.rtc's action, of /localhost/Sink2.rtc",
    ]
    assert clock.execution.is_over
    assert not clock.execution.failure
    clock = begin(3, *entries, optional="Sink0 Sink1", missing="Sink0")
    clock.go()
    clock.go()
    assert clock.execution.failure.startswith("Required action failed: Preceding condition cannot")


def test_an_interruption_begins_nothing_more(begin, make):
    clock = begin(2, make.entry("Sink1", wait=10))
    clock.go()
    clock.execution.cancel("interrupted")
    assert (clock.go(5), clock.alarm, clock.execution.is_over) == ("", None, False)
    clock.reply("0")
    assert clock.execution.is_over
    assert [turn.id for turn in clock.execution.waiting] == [2]


# a stop


@pytest.mark.parametrize(
    ("state", "begun"),
    [
        ("Inactive", "1"),
        ("Error", "1"),
        ("zombie (signal 9)", "1"),
        ("missing", "1"),
        ("Active", ""),
        ("Active (stopped)", ""),
    ],
)
def test_a_stop_waits_for_nobody_who_is_at_rest(begin, make, state, begun):
    clock = begin(2, make.entry("Sink1", after="Sink0"), stop=True)
    assert clock.go() == "0"
    clock.reply("0", NO)
    clock.put("0", state)
    assert clock.go() == begun


def test_a_stop_goes_on_after_what_cannot_be_sent(begin, make):
    entry = make.entry("Sink1", after="Sink0", timing="ASYNC")
    clock = begin(2, entry, stop=True, missing="Sink0")
    assert (clock.go(), clock.go()) == ("", "1")
    assert clock.reports == ["Action failed: Component missing: /localhost/Sink0.rtc"]


def test_a_state_that_was_not_seen_is_no_state(begin, make):
    clock = begin(2, make.entry("Sink1", after="Sink0"), stop=True)
    clock.go()
    clock.reply("0")
    assert clock.execution.ready(clock.now) == []
    clock.execution.saw({OrderTarget("Sink0", 0): "Inactive"})
    assert [turn.id for turn in clock.execution.ready(clock.now)] == [2]


def test_a_moment_that_passes_while_nobody_looks_is_not_forgotten(begin, make):
    clock = begin(1, make.entry("Sink0", wait=20), timeout_s=60.0)
    clock.go()
    clock.now += 5
    assert clock.alarm == -4.98
    assert clock.go() == "0"
