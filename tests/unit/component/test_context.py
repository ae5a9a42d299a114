"""Execution contexts: order of calls, requests, refusals, idleness, rate, configuration."""

from __future__ import annotations

import math

import pytest

from rtkit.component import Component, Parameter
from rtkit.component.contexts.context import ExecutionContext
from rtkit.errors import Malformed, NotFound
from rtkit.rtc.enums import ExecutionKind, LifeCycleState, ReturnCode, Transition


class Worker(Component):
    """Notes what is called."""

    gain = Parameter(1.0)

    def __init__(self, instance, notes=None):
        super().__init__(instance)
        self.notes = notes if notes is not None else []
        self.fail = False

    def on_execute(self, context):
        self.notes.append((self.instance, "execute", self.gain))
        if self.fail:
            raise ValueError("stop")

    def on_state_update(self, context):
        self.notes.append((self.instance, "update", self.gain))


class Quiet(Component):
    """Overrides nothing."""


def alive(component):
    component.initialize()
    (context,) = component.contexts.values()
    return context


def ask(context, component, transition):
    answers = []
    context.request(component, transition, lambda code, why: answers.append((code, why)))
    assert not answers
    context.tick()
    (answer,) = answers
    return answer


def test_all_execute_before_any_updates():
    notes = []
    one, other = Worker("One", notes), Worker("Other", notes)
    context = alive(one)
    alive(other)
    assert context.add_component(other) is ReturnCode.OK
    for each in (one, other):
        context.activate_component(each)
    context.tick()
    assert [note[:2] for note in notes] == [
        ("One", "execute"),
        ("Other", "execute"),
        ("One", "update"),
        ("Other", "update"),
    ]


def test_a_failure_keeps_others_going_and_skips_the_update_of_the_one():
    notes = []
    one, other = Worker("One", notes), Worker("Other", notes)
    one.fail = True
    context = alive(one)
    alive(other)
    context.add_component(other)
    for each in (one, other):
        context.activate_component(each)
    context.tick()
    assert [note[:2] for note in notes] == [
        ("One", "execute"),
        ("Other", "execute"),
        ("Other", "update"),
    ]
    assert context.state_of(one) is LifeCycleState.ERROR
    assert context.state_of(other) is LifeCycleState.ACTIVE


@pytest.mark.parametrize(
    ("before", "transition", "code", "why"),
    [
        ("Inactive", "activate", "RTC_OK", ""),
        ("Active", "activate", "RTC_OK", ""),
        ("Error", "activate", "PRECONDITION_NOT_MET", "precondition not met (state is Error)"),
        ("Inactive", "deactivate", "RTC_OK", ""),
        ("Active", "deactivate", "RTC_OK", ""),
        ("Error", "deactivate", "PRECONDITION_NOT_MET", "precondition not met (state is Error)"),
        ("Inactive", "reset", "RTC_OK", ""),
        ("Active", "reset", "PRECONDITION_NOT_MET", "precondition not met (state is Active)"),
        ("Error", "reset", "RTC_OK", ""),
    ],
)
def test_requests_in_each_state(before, transition, code, why):
    worker = Worker("Worker0")
    context = alive(worker)
    if before != "Inactive":
        context.activate_component(worker)
    if before == "Error":
        worker.fail = True
        context.tick()
        worker.fail = False
    assert context.state_of(worker).value == before
    assert ask(context, worker, Transition(transition)) == (ReturnCode(code), why)


def test_reset_clears_the_cause():
    worker = Worker("Worker0")
    context = alive(worker)
    worker.fail = True
    context.activate_component(worker)
    context.tick()
    assert worker.cause.startswith("ValueError: stop (test_context.py:")
    assert worker.cause.endswith("in on_execute)")
    context.reset_component(worker)
    assert worker.cause == ""


def test_a_failure_is_logged_with_its_exception(caplog):
    worker = Worker("Worker0")
    context = alive(worker)
    worker.fail = True
    context.activate_component(worker)
    for _ in range(3):
        context.tick()
    (record,) = caplog.records
    assert (record.name, record.levelname) == ("Worker0", "ERROR")
    assert record.getMessage() == f"on_execute failed: {worker.cause}"
    assert isinstance(record.exc_info[1], ValueError)
    assert type(worker.cause) is str  # no traceback is kept alive


def test_a_stranger_is_a_bad_parameter():
    worker, stranger = Worker("Worker0"), Worker("Stranger0")
    context = alive(worker)
    code, why = ask(context, stranger, Transition.ACTIVATE)
    assert code is ReturnCode.BAD_PARAMETER
    assert "Stranger0" in why
    assert context.remove_component(stranger) is ReturnCode.BAD_PARAMETER
    with pytest.raises(NotFound):
        context.state_of(stranger)


def test_a_component_that_is_not_alive_or_in_already_is_refused():
    worker, unspawned = Worker("Worker0"), Worker("Unborn0")
    context = alive(worker)
    assert context.add_component(worker) is ReturnCode.PRECONDITION_NOT_MET
    assert context.add_component(unspawned) is ReturnCode.PRECONDITION_NOT_MET


def test_requests_wake_the_pacer_and_keep_their_order():
    worker, woken, answers = Worker("Worker0"), [], []
    context = alive(worker)
    context.wake = lambda: woken.append(True)
    for transition in (Transition.ACTIVATE, Transition.DEACTIVATE, Transition.ACTIVATE):
        context.request(worker, transition, lambda code, why: answers.append(code))
    assert len(woken) == 3
    context.tick()
    assert answers == [ReturnCode.OK] * 3
    assert context.state_of(worker) is LifeCycleState.ACTIVE


def test_a_request_made_by_an_answer_waits_for_the_next_tick():
    worker, answers = Worker("Worker0"), []
    context = alive(worker)

    def again(code, why):
        answers.append(code)
        context.request(worker, Transition.ACTIVATE, again)

    context.request(worker, Transition.ACTIVATE, again)
    context.tick()
    assert len(answers) == 1
    context.tick()
    assert len(answers) == 2


def test_a_stopped_context_refuses_requests_and_does_not_execute():
    worker, answers = Worker("Worker0"), []
    context = alive(worker)
    context.activate_component(worker)
    context.request(worker, Transition.DEACTIVATE, lambda code, why: answers.append((code, why)))
    assert context.stop() is ReturnCode.OK
    expected = (
        ReturnCode.PRECONDITION_NOT_MET,
        "precondition not met (execution context 0 is not running)",
    )
    assert answers == [expected]
    assert context.is_idle
    context.tick()
    assert worker.notes == []
    assert context.stop() is ReturnCode.PRECONDITION_NOT_MET
    assert ask(context, worker, Transition.DEACTIVATE) == expected
    assert context.start() is ReturnCode.OK
    assert context.start() is ReturnCode.PRECONDITION_NOT_MET
    context.tick()
    assert worker.notes


def test_idle_means_that_a_tick_would_do_nothing():
    worker, quiet = Worker("Worker0"), Quiet("Quiet0")
    busy, calm = alive(worker), alive(quiet)
    assert busy.is_idle
    busy.request(worker, Transition.ACTIVATE, lambda code, why: None)
    assert not busy.is_idle
    busy.tick()
    assert not busy.is_idle
    worker.fail = True
    busy.tick()
    assert busy.is_idle
    calm.activate_component(quiet)
    assert calm.is_idle
    quiet.configuration.activate("default")
    assert not calm.is_idle
    calm.tick()
    assert calm.is_idle
    calm.set_rate(5.0)
    assert not calm.is_idle
    calm.tick()
    assert calm.is_idle


def test_error_with_on_error_is_not_idle():
    class Waiting(Component):
        def on_activated(self, context):
            raise ValueError

        def on_error(self, context):
            pass

    waiting = Waiting("Waiting0")
    context = alive(waiting)
    context.activate_component(waiting)
    assert not context.is_idle


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan, math.inf])
def test_a_wrong_rate_changes_nothing(rate):
    context = alive(Worker("Worker0"))
    assert context.set_rate(rate) is ReturnCode.BAD_PARAMETER
    assert context.rate == 1000.0
    with pytest.raises(Malformed, match="rate"):
        ExecutionContext("0", ExecutionKind.PERIODIC, rate, "Worker0")


def test_a_new_rate_is_told_once_by_the_ticking_thread():
    told = []

    class Listener(Component):
        def on_rate_changed(self, context):
            told.append(self.context_rate(context))

    listener = Listener("Listener0")
    context = alive(listener)
    assert context.set_rate(20.0) is ReturnCode.OK
    assert told == []
    context.tick()
    context.tick()
    assert told == [20.0]


def test_settings_change_between_cycles_only():
    worker = Worker("Worker0")
    context = alive(worker)
    context.activate_component(worker)
    worker.configuration.set("default", {"gain": "2.5"})
    context.tick()
    assert {note[2] for note in worker.notes} == {1.0}
    worker.notes.clear()
    worker.configuration.activate("default")
    context.tick()
    assert {note[2] for note in worker.notes} == {1.0}
    worker.notes.clear()
    context.tick()
    assert {note[2] for note in worker.notes} == {2.5}


def test_only_the_first_running_context_takes_settings_over():
    one, other = Worker("One"), Worker("Other")
    own, foreign = alive(one), alive(other)
    foreign.add_component(one)
    one.configuration.set("default", {"gain": "3"})
    one.configuration.activate("default")
    assert foreign.is_idle
    foreign.tick()
    assert one.gain == 1.0
    own.tick()
    assert one.gain == 3.0
    own.stop()
    one.configuration.set("default", {"gain": "4"})
    one.configuration.activate("default")
    foreign.tick()
    assert one.gain == 4.0


def test_changes_are_told():
    worker, told = Worker("Worker0"), []
    context = alive(worker)
    context.changed = lambda component: told.append(context.state_of(component).value)
    context.activate_component(worker)
    context.tick()
    worker.configuration.activate("default")
    context.tick()
    worker.fail = True
    context.tick()
    context.reset_component(worker)
    assert told == ["Active", "Active", "Error", "Inactive"]


def test_the_watch_sees_entry_and_exit_of_each_callback():
    worker, seen = Worker("Worker0"), []
    context = alive(worker)
    context.watch = lambda instance, callback: seen.append((instance, callback))
    context.activate_component(worker)
    context.tick()
    assert seen == [
        ("Worker0", "on_activated"),
        ("", ""),
        ("Worker0", "on_execute"),
        ("", ""),
        ("Worker0", "on_state_update"),
        ("", ""),
    ]


def test_a_deactivation_that_fails_on_the_way_is_done_and_says_so():
    class Leaver(Component):
        def on_deactivated(self, context):
            raise ValueError("not now")

    leaver = Leaver("Leaver0")
    context = alive(leaver)
    context.activate_component(leaver)
    code, why = context.perform(leaver, Transition.DEACTIVATE)
    assert code is ReturnCode.OK
    assert why.startswith("on_deactivated failed: ValueError: not now")
    assert context.state_of(leaver) is LifeCycleState.INACTIVE


def test_removing_an_active_component_deactivates_it():
    class Leaver(Component):
        left = False

        def on_deactivated(self, context):
            self.left = True

    leaver = Leaver("Leaver0")
    context = alive(leaver)
    context.activate_component(leaver)
    assert context.remove_component(leaver) is ReturnCode.OK
    assert leaver.left
    assert context.participants == ()
    assert leaver.participations == ()


def test_the_profile_lists_only_others_as_participants():
    one, other = Worker("One"), Worker("Other")
    context = alive(one)
    alive(other)
    context.add_component(other)
    profile = context.profile_for(other)
    assert profile.owner == "One"
    assert profile.participants == ("Other",)
    assert profile.is_running
    assert profile.rate == 1000.0
    assert profile.state is LifeCycleState.INACTIVE


def test_a_rate_that_is_refused_in_error_is_reported_and_aborts_no_second_time():
    calls, reports = [], []

    class Picky(Component):
        def on_activated(self, context):
            raise ValueError("first")

        def on_rate_changed(self, context):
            raise ValueError("second")

        def on_aborting(self, context):
            calls.append(context)

    picky = Picky("Picky0")
    picky.report = reports.append
    context = alive(picky)
    context.activate_component(picky)
    context.set_rate(3.0)
    context.tick()
    assert calls == ["0"]
    assert picky.cause.startswith("ValueError: first")
    (report,) = reports
    assert report.startswith("on_rate_changed failed: ValueError: second")
