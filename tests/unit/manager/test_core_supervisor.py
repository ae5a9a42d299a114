"""The core and ends: what is made again, when, how often, and what is not."""

from __future__ import annotations

import pytest
from endings import come_back, do, in_error, make, pass_time
from fake_shell import FakeShell, facts, wire

from rtkit.deployment import actions as act
from rtkit.deployment.supervision import HEALTHY_S, RestartRule
from rtkit.errors import Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core.deletion import HANGING_S
from rtkit.manager.core.policies import policy_of
from rtkit.rtc.enums import LifeCycleState, Transition

STUCK = "stuck in on_execute since 12:00:00 (a.py:7)"


@pytest.mark.parametrize(
    ("restart", "reason", "is_back"),
    [
        ("never", "signal 9", False),
        ("on-failure", "signal 9", True),
        ("on-failure", "exit status 3", True),
        ("on-failure", "exit status 0", False),
        ("always", "exit status 0", True),
    ],
)
def test_which_ends_are_answered(
    restart: str, reason: str, is_back: bool, shell: FakeShell
) -> None:
    shell.end(make(shell, "A", restart=restart), reason)
    assert shell.state.components["A"].zombie == reason
    come_back(shell)
    told = shell.state.components["A"]
    assert (not told.zombie) is is_back
    assert told.restart_status.restarts == is_back
    assert told.restart_status.why == reason * is_back


def test_what_is_made_again_is_as_it_was(shell: FakeShell) -> None:
    shell.make("B", "t")
    key = make(shell, "A", restart="on-failure")
    do(
        shell,
        act.SetParameters("A", "default", {"p": "1"}),
        act.Connect(wire("w")),
        act.ChangeState("A", "0", Transition.ACTIVATE),
    )
    rows = dict(shell.rows)
    shell.end(key)
    assert come_back(shell) == ["create", "set", "sink", "source", "change_state"]
    assert list(shell.state.connectors) == ["w"]
    assert shell.rows.pop(("watched", "A"))
    assert shell.rows == rows


def test_only_those_with_a_policy_come_back_and_the_slave_with_them(shell: FakeShell) -> None:
    make(shell, "A")
    key = make(shell, "B", restart="always")
    shell.end(key)
    come_back(shell)
    told = shell.state.components
    assert (told["A"].zombie, told["B"].zombie) == ("signal 9", "")


def test_waits_double_and_after_five_it_is_given_up(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    waits = []
    while not shell.state.watched("A").ledger.is_given_up:
        began = shell.now
        shell.end(shell.state.containers["A"])
        pass_time(shell, 100.0)
        if "s" in shell.spawned:
            waits.append(shell.now - began)
            come_back(shell, 0.0)
    assert waits == [pytest.approx(0.1 * 2**n, rel=0.11) for n in range(5)]
    zombie = shell.state.components["A"].zombie
    assert zombie == "signal 9; given up after 5 restarts within 60 s"
    shell.wait(1000.0)
    assert not shell.spawned
    assert make(shell, "A", restart="on-failure")  # a user makes it, and all is forgiven
    assert not shell.state.watched("A").given_up


def test_after_good_health_it_begins_anew(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    for _ in range(12):
        shell.end(shell.state.containers["A"])
        come_back(shell, 0.12)
        shell.wait(HEALTHY_S + 1.0)
    assert not shell.state.components["A"].zombie
    assert shell.state.components["A"].restart_status.restarts == 12


def test_a_start_that_fails_counts_as_an_end(shell: FakeShell) -> None:
    shell.end(make(shell, "A", restart="on-failure"))
    for _ in range(5):
        pass_time(shell, 20.0)
        shell.fork("s")
        shell.refuse(shell.next("create"))
    shell.wait(100.0)
    assert "given up after 5 restarts" in shell.state.components["A"].zombie
    assert "cannot create A: no such thing" in shell.state.components["A"].zombie


@pytest.mark.parametrize("end", [act.Delete("A"), act.EndSlave("s"), act.EndSlave("s", True)])
def test_what_a_user_ends_stays_ended(end: act.Action, shell: FakeShell) -> None:
    """Also while it waits to be made again."""
    key = make(shell, "A", restart="always")
    if isinstance(end, act.Delete):
        shell.end(key)
        do(shell, end)
    else:
        asked = shell.ask(end)
        come_back(shell, 0.0)
        shell.end(key, "exit status 0")
        assert asked.result.ok
    come_back(shell, 100.0)
    assert "A" not in shell.state.components
    assert not shell.spawned


def test_nothing_comes_back_into_a_manager_that_stops() -> None:
    for event in (ev.StopRequested(), ev.StopRequested(is_kept=True)):
        shell = FakeShell()
        shell.end(make(shell, "A", restart="always"))
        shell.feed(event)
        shell.wait(100.0)
        assert not shell.spawned
        assert shell.is_finished


def test_one_that_waits_can_be_laid_to_rest_and_comes_back_so(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    do(shell, act.ChangeState("A", "0", Transition.ACTIVATE))
    shell.end(shell.state.containers["A"])
    refused = shell.ask(act.ChangeState("A", "0", Transition.ACTIVATE)).result
    assert (refused.kind, refused.why) == ("refused", "zombie (signal 9): A")
    do(shell, act.ChangeState("A", "0", Transition.DEACTIVATE))
    assert come_back(shell) == ["create"]


def test_what_is_told_to_rest_while_it_is_made_is_not_activated(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    do(shell, act.ChangeState("A", "0", Transition.ACTIVATE))
    shell.end(shell.state.containers["A"])
    pass_time(shell, 20.0)
    shell.fork("s")
    do(shell, act.ChangeState("A", "0", Transition.DEACTIVATE))
    assert shell.state.components["A"].zombie == ""
    shell.wait(1.0)
    assert not shell.calls


@pytest.mark.parametrize("ends", [1, 6])
def test_a_reset_makes_one_that_waits_or_is_given_up_again_at_once(
    ends: int, shell: FakeShell
) -> None:
    make(shell, "A", restart="on-failure")
    do(shell, act.ChangeState("A", "0", Transition.ACTIVATE))
    for turn in range(ends):
        shell.end(shell.state.containers["A"])
        if turn < ends - 1:
            come_back(shell)
    began = shell.now
    asked = shell.ask(act.ChangeState("A", "0", Transition.RESET))
    assert come_back(shell) == ["create"]
    assert asked.result.ok
    assert shell.now == pytest.approx(began, abs=0.01)
    facts = shell.state.components["A"]
    assert (facts.zombie, facts.restart_status.given_up, facts.restart_status.restarts) == (
        "",
        "",
        ends,
    )
    shell.end(shell.state.containers["A"])  # as if for the first time
    assert shell.state.components["A"].restart_status.due_s - shell.now == pytest.approx(
        0.1, rel=0.11
    )
    assert come_back(shell) == ["create"]
    shell.wait(60.0)
    assert not shell.spawned


def test_a_reset_that_fails_says_why(shell: FakeShell) -> None:
    make(shell, "A", **{"restart": "on-failure", "restart.delay": "9"})
    shell.end(shell.state.containers["A"])
    asked = shell.ask(act.ChangeState("A", "0", Transition.RESET))
    shell.fork("s")
    shell.refuse(shell.next("create"), Refused("no such type"))
    assert asked.result.why == "no such type"
    assert shell.state.components["A"].zombie == "signal 9"


def test_one_that_is_deleted_while_it_comes_back_does_not_stay(shell: FakeShell) -> None:
    make(shell, "A", restart="on-failure")
    shell.end(shell.state.containers["A"])
    pass_time(shell, 20.0)
    deleted = shell.ask(act.Delete("A"))
    key = shell.fork("s")
    shell.serve()
    shell.end(key, "exit status 0")
    assert deleted.result.ok
    assert not shell.state.components
    assert not shell.state.kept.components


def test_another_one_of_the_name_of_one_that_was_ended_is_made_again_too(shell: FakeShell) -> None:
    for _ in range(3):
        make(shell, "A", **{"restart": "on-failure", "restart.delay": "5"})
        shell.end(shell.state.containers["A"])
        do(shell, act.Delete("A"))
        shell.wait(1.0)
    make(shell, "A", restart="on-failure")
    shell.wait(20.0)
    shell.end(shell.state.containers["A"])
    assert come_back(shell, 1.0) == ["create"]
    assert not shell.state.returning


def test_who_was_made_again_by_hand_is_not_made_twice(shell: FakeShell) -> None:
    shell.end(make(shell, "A", restart="always"))
    make(shell, "A", "t")
    assert come_back(shell) == []
    assert shell.state.components["A"].process == "t"


def test_one_in_error_is_made_again_in_its_place(shell: FakeShell) -> None:
    key = make(shell, "A", restart="on-failure")
    make(shell, "B")
    do(shell, act.ChangeState("A", "0", Transition.ACTIVATE))
    shell.say(key, facts=in_error("A"))
    shell.say(key, facts=in_error("A"))
    assert come_back(shell) == ["delete", "create", "change_state"]
    told = shell.state.components["A"]
    assert (told.restart_status.restarts, told.restart_status.why) == (
        1,
        "in Error: ValueError: no (a.py:1)",
    )
    assert shell.state.containers["A"] == key


def test_one_in_error_that_does_not_end_takes_its_slave_along(shell: FakeShell) -> None:
    key = make(shell, "A", restart="on-failure")
    make(shell, "B", restart="on-failure")
    shell.say(key, facts=in_error("A"))
    shell.wait(0.2)
    shell.next("delete")
    shell.wait(1.5)
    assert (key, 15) in shell.signals
    shell.end(key, "signal 15")
    come_back(shell)
    come_back(shell)
    told = shell.state.components
    assert [told[each].zombie for each in "AB"] == ["", ""]


def test_one_whose_callback_hangs_is_ended_at_once_and_comes_back(shell: FakeShell) -> None:
    key = make(shell, "A", **{"health.stuck": "0.2:restart"})
    make(shell, "B")
    began = shell.now
    shell.feed(ev.CallbackStuck(key, "A", "stuck in on_execute since 12:00:00"))
    assert not shell.signals
    shell.feed(ev.CallbackStuck(key, "A", STUCK, True))
    assert shell.signals == [(key, 15)]
    assert not shell.calls  # it would not answer
    shell.wait(HANGING_S)
    assert shell.killed() == [key]
    shell.end(key)
    told = shell.state.components
    assert [told[each].zombie for each in "AB"] == [f"A was {STUCK}"] * 2
    assert shell.state.processes[key].reason == f"A was {STUCK}"
    assert come_back(shell, 1.0) == ["create"]
    assert shell.now - began < 0.25
    assert [bool(told[each].zombie) for each in "AB"] == [False, True]
    shell.wait(60.0)
    assert told["A"].restart_status.restarts == 1
    again = shell.state.containers["A"]
    shell.feed(ev.CallbackStuck(again, "A", STUCK, True))
    shell.wait(HANGING_S)
    assert shell.killed() == [key, again]


def test_one_of_which_nobody_says_where_it_hangs_is_ended_soon(shell: FakeShell) -> None:
    key = make(shell, "A", **{"health.stuck": "restart"})
    shell.feed(ev.CallbackStuck(key, "A", "stuck in on_execute since 12:00:00"))
    shell.wait(0.15)
    assert shell.signals == [(key, 15)]


def test_one_that_a_debugger_has_stopped_is_let_be(shell: FakeShell) -> None:
    key = make(shell, "A", **{"health.stuck": "restart"})
    shell.feed(ev.CallbackStuck(key, "A", "stuck in on_execute since 12:00:00"))
    shell.feed(ev.CallbackStuck(key, "A", "in a debugger since 12:00:00 (a.py:7)", True))
    shell.wait(5.0)
    assert not shell.signals
    assert not shell.calls


def test_one_that_goes_on_meanwhile_is_let_be(shell: FakeShell) -> None:
    key = make(shell, "A", **{"health.stuck": "restart"})
    shell.feed(ev.CallbackStuck(key, "A", "stuck in on_execute since 12:00:00"))
    shell.feed(ev.CallbackStuck(key, "A", ""))
    shell.wait(0.5)
    assert not shell.signals


def test_one_that_cannot_be_ended_is_not_said_to_be_back(shell: FakeShell) -> None:
    shell.ask(act.Create("Thing?instance_name=A&rtkit.health.stuck=restart"))
    shell.serve()
    shell.feed(ev.CallbackStuck(ev.OWN_PROCESS, "A", STUCK, True))
    pass_time(shell, 1.0)
    assert shell.next("delete").message["instance"] == "A"
    shell.wait(2.0)
    restart_status = shell.state.components["A"].restart_status
    assert (restart_status.restarts, restart_status.returning) == (0, "")
    assert restart_status.given_up.startswith(
        "it cannot be ended: no answer from manager in time: A is "
    )
    assert not shell.state.returning


def test_one_that_is_given_up_in_error_says_so_until_it_is_reset(shell: FakeShell) -> None:
    key = make(shell, "A", **{"restart": "on-failure", "restart.limit": "1"})
    for _ in range(2):
        shell.say(key, facts=in_error("A"))
        come_back(shell, 1.0)
    assert "given up" in shell.state.components["A"].restart_status.trouble
    do(shell, act.ChangeState("A", "0", Transition.RESET))
    shell.say(key, facts=facts("A"))
    assert not shell.state.components["A"].restart_status.trouble


def test_the_loss_of_what_is_critical_stops_the_system_in_reverse_order(shell: FakeShell) -> None:
    for instance in "AB":
        make(shell, instance, "t")
    key = make(shell, "C", critical="yes", restart="on-failure")
    for instance in "ABC":
        do(shell, act.ChangeState(instance, "0", Transition.ACTIVATE))
        active = in_error(instance, LifeCycleState.ACTIVE)
        shell.say(shell.state.containers[instance], facts={**active, "cause": ""})
    shell.end(key)
    rested = []
    while shell.calls:
        call = shell.calls.pop(0)
        rested.append((call.op, call.message["transition"], call.message["instance"]))
        shell.reply(call)
    assert rested == [("change_state", "deactivate", each) for each in "BA"]
    assert come_back(shell) == ["create"]  # and stays at rest
    assert not any(wish.active for wish in shell.state.kept.components.values())


def test_a_policy_that_makes_no_sense_is_refused_before_anything_is_made(shell: FakeShell) -> None:
    asked = shell.ask(act.Create("Thing?instance_name=A&manager_name=s&rtkit.restart=perhaps"))
    assert asked.result.why == "rtkit.restart: not one of never, on-failure, always: perhaps"
    assert not shell.spawned


def test_what_slave_and_manager_say_holds_for_who_says_nothing(shell: FakeShell) -> None:
    shell.state.settings.change("manager.restart", "always")
    shell.state.settings.change("manager.restart.t", "never")
    keys = [make(shell, "A"), make(shell, "B", "t"), make(shell, "C", "u", restart="never")]
    for key in keys:
        shell.end(key)
    come_back(shell)
    assert [bool(each.zombie) for each in shell.state.components.values()] == [True, True, False]


def test_a_rule_that_says_restart_counts_as_a_word_of_the_component() -> None:
    state = FakeShell().state
    state.settings.change("manager.restart.s", "never")
    for own, meant in (
        ("", RestartRule.NEVER),
        ("&rtkit.health.stuck=0.2:log", RestartRule.NEVER),
        ("&rtkit.health.stuck=0.2:restart", RestartRule.ON_FAILURE),
        ("&rtkit.health.stuck=0.2:restart&rtkit.restart=never", RestartRule.NEVER),
    ):
        assert policy_of(state, f"Thing?manager_name=s{own}").restart is meant


def tell_figures(shell: FakeShell, written: int) -> None:
    """Wait until a holder is asked for figures, and tell them."""
    while not (asked := [key for key, message in shell.told if message["op"] == "metrics"]):
        shell.wait(0.1)
    shell.told.clear()
    for key in asked:
        shell.say(key, metrics=[{"instance": "A", "contexts": [], "written": {"out": written}}])
    shell.wait(0.1)


def at_work(rule: str, **options: str) -> FakeShell:
    """A core with a component that has a rule on what it writes, and is active."""
    shell = FakeShell()
    make(shell, "A", **{"health.rate.out": rule, **options})
    active = in_error("A", LifeCycleState.ACTIVE)
    shell.say(shell.state.containers["A"], facts={**active, "cause": ""})
    do(shell, act.ChangeState("A", "0", Transition.ACTIVATE))
    for count in (100, 200):
        tell_figures(shell, count)
    assert not shell.state.components["A"].restart_status.trouble
    return shell


def test_a_component_that_is_not_well_says_so_until_it_is_well_again() -> None:
    shell = at_work("50-200:degrade")
    tell_figures(shell, 201)
    assert "degraded: out carries" in shell.state.components["A"].restart_status.trouble
    tell_figures(shell, 300)
    assert not shell.state.components["A"].restart_status.trouble


def test_one_that_is_not_well_is_made_again() -> None:
    shell = at_work("50-200:restart")
    tell_figures(shell, 201)
    assert come_back(shell, 1.0) == ["delete", "create", "change_state"]
    assert "not well: out carries" in shell.state.components["A"].restart_status.why


def test_one_that_is_not_well_is_rested_and_with_it_all_if_it_is_critical() -> None:
    for critical in ("no", "yes"):
        shell = at_work("50-200:stop", critical=critical)
        tell_figures(shell, 201)
        (call,) = shell.calls
        assert (call.op, call.message["transition"]) == ("change_state", "deactivate")


def test_nobody_is_asked_for_figures_when_there_is_no_rule() -> None:
    shell = at_work("50-200:degrade")
    key = shell.state.containers["A"]
    shell.ask(act.Delete("A"))
    shell.serve()
    shell.end(key, "exit status 0")
    shell.wait(5.0)
    shell.told.clear()
    shell.wait(100.0)
    assert not shell.told


def test_the_policy_of_what_lives_is_changed_without_interrupting_it(shell: FakeShell) -> None:
    key = make(shell, "A")
    policy = {"rtkit.restart": "on-failure", "rtkit.health.stuck": "degrade"}
    asked = shell.ask(act.SetPolicy("A", policy))
    assert asked.result.ok
    assert not shell.calls
    assert shell.state.ruled == {"A"}
    (told,) = (m for k, m in shell.told if k == key and m["op"] == "remember")
    assert "rtkit.restart=on-failure" in told["kept"]["create"]
    assert "rtkit.restart=on-failure" in shell.rows["component", "A"]
    shell.end(key)
    come_back(shell)
    assert not shell.state.components["A"].zombie
    do(shell, act.SetPolicy("A", {}))
    assert shell.state.ruled == set()
    shell.end(shell.state.containers["A"])
    assert not come_back(shell)


def test_a_policy_that_makes_no_sense_changes_nothing(shell: FakeShell) -> None:
    make(shell, "A", restart="always")
    before = shell.state.components["A"].create
    for bad in ({"rtkit.restart": "often"}, {"manager_name": "t"}):
        assert shell.ask(act.SetPolicy("A", bad)).result.kind == "malformed"
    assert shell.ask(act.SetPolicy("B", {})).result.kind == "not-found"
    assert shell.state.components["A"].create == before


def test_what_a_user_makes_again_counts_as_no_restart(shell: FakeShell) -> None:
    shell.end(make(shell, "A", restart="on-failure"))
    come_back(shell)
    do(shell, act.SetPolicy("A", {}))
    shell.end(shell.state.containers["A"])
    make(shell, "A")
    restart_status = shell.state.components["A"].restart_status
    assert (restart_status.restarts, restart_status.why) == (1, "signal 9")
