"""The core makes and deletes components: placing, names, failures, time-outs."""

from __future__ import annotations

import signal

import pytest
from fake_shell import OWN, facts, module_of, wire

from rtkit.deployment.actions import (
    ChangeState,
    Connect,
    Create,
    Delete,
    Load,
    SetParameters,
    Unload,
    strict,
)
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core.modules import TRIAL
from rtkit.rtc.enums import ReturnCode, Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ModuleProfile, TypeProfile
from rtkit.rtc.serde import encode


def create(text="Thing?instance_name=A", *names, pattern=None):
    return Create(text, names, pattern)


# modules


def load(shell, path, *types):
    """Have a module loaded that offers these types."""
    asked = shell.ask(Load(path, "init"))
    shell.fork(TRIAL)
    call = shell.next("load")
    shell.reply(call, module_of(call, *types))
    shell.end(call.key, "exit status 0")
    assert asked.result.value == path


def test_a_module_is_tried_by_a_process_of_its_own_that_is_not_shown_and_ends(shell):
    asked = shell.ask(Load("a.py", "aInit"))
    key = shell.fork(TRIAL)
    call = shell.next("load")
    assert (call.key, call.message["path"], call.message["init"]) == (key, "a.py", "aInit")
    assert [p.name for p in shell.state.snapshot().processes] == ["manager"]
    shell.reply(call, module_of(call, "Thing"))
    assert asked.result.value == "a.py"
    assert shell.state.modules["a.py"].types == (TypeProfile("Thing"),)
    assert shell.signals == [(key, signal.SIGTERM)]
    for present, note in ((1, ""), (0, ""), (2, "a.py has changed since it was loaded")):
        again = shell.ask(Load("a.py", "aInit"))
        shell.reply(shell.next("fingerprint"), present)
        assert again.result.value == "a.py"
        assert again.result.note.partition(" (")[0] == note


def test_slaves_are_handed_the_modules_of_what_they_make(shell):
    for path, types in (("a.py", ["Thing"]), ("b.py", ["Other"]), ("c.py", [])):
        load(shell, path, *types)
    shell.ask(create("Thing?manager_name=s"))
    shell.fork("s")
    assert shell.next("create").message["modules"] == [["a.py", "init"], ["c.py", "init"]]


def test_the_manager_imports_only_what_others_have_tried(shell):
    asked = shell.ask(create())
    first = shell.next("create")
    assert first.message["tried"] == {}
    shell.reply(first, {"untried": "Thing.py", "init": ""})
    key = shell.fork(TRIAL)
    tried = shell.next("load")
    assert (tried.key, tried.message["path"]) == (key, "Thing.py")
    shell.reply(tried, module_of(tried, "Thing"))
    again = shell.next("create")
    assert (again.key, again.message["tried"]) == (OWN, {"Thing.py": 1})
    shell.say(OWN, facts=facts("A"))
    shell.reply(again, "A")
    assert asked.result.value == "A"
    assert not shell.state.modules


def test_a_module_is_tried_once_for_all_that_want_it(shell):
    asked = [shell.ask(create(f"Thing?instance_name={name}")) for name in "ABC"]
    for _ in asked:
        shell.reply(shell.next("create"), {"untried": "Thing.py", "init": ""})
    key = shell.fork(TRIAL)
    tried = shell.next("load")
    shell.reply(tried, module_of(tried, "Thing"))
    shell.end(key)
    for name in "ABC":
        call = shell.next("create")
        assert call.message["tried"] == {"Thing.py": 1}
        shell.say(OWN, facts=facts(name))
        shell.reply(call, name)
    assert [each.result.value for each in asked] == ["A", "B", "C"]
    assert not shell.calls


def test_who_waited_for_a_trial_hears_why_it_failed(shell):
    asked = [shell.ask(create(f"Thing?instance_name={name}")) for name in "AB"]
    for _ in asked:
        shell.reply(shell.next("create"), {"untried": "Thing.py", "init": ""})
    key = shell.fork(TRIAL)
    shell.refuse(shell.next("load"), Refused("module does not import"))
    shell.end(key)
    assert {each.result.why for each in asked} == {"module does not import"}
    assert not shell.calls


def test_a_module_that_ends_who_tries_it_is_told_and_never_imported_here(shell):
    asked = shell.ask(create())
    shell.reply(shell.next("create"), {"untried": "Thing.py", "init": ""})
    shell.end(shell.fork(TRIAL), "signal 11 at Thing.py:3 in <module>")
    assert asked.result.why == (
        "module Thing.py ended the process that imported it: signal 11 at Thing.py:3 in <module>"
    )
    assert not shell.calls
    assert not shell.state.tried


def test_a_module_that_hangs_is_given_up_in_time_with_its_line(shell):
    asked = shell.ask(Load("a.py"), timeout_s=2.0)
    key = shell.fork(TRIAL)
    shell.feed(ev.CallbackStuck(key, "a.py", "stuck in import since 12:00:00 (a.py:3 in <module>)"))
    shell.wait(2.0)
    assert asked.result.kind == "unreachable"
    assert asked.result.why == (
        "module a.py was not imported in time:"
        " it is stuck in import since 12:00:00 (a.py:3 in <module>)"
    )
    assert shell.killed() == [key]


def test_slaves_have_imported_what_a_module_asks_for(shell):
    shell.ask(Load("a.py"))
    key = shell.fork(TRIAL)
    assert shell.ahead == ()
    call = shell.next("load")
    shell.reply(call, module_of(call, "T") | {"ahead": "some.module"})
    shell.end(key, "exit status 0")
    shell.ask(Create("T?instance_name=A&manager_name=s"))
    assert ([*shell.spawned], shell.ahead) == (["s"], ("some.module",))


def test_what_does_not_load_is_not_kept(shell):
    asked = shell.ask(Load("a.py"))
    key = shell.fork(TRIAL)
    shell.refuse(shell.next("load"), Refused("module does not import"))
    assert (asked.result.kind, asked.result.why) == ("refused", "module does not import")
    assert not shell.state.modules
    assert shell.killed() == [key]


# answers that do not come


def test_what_holds_up_an_answer_is_found_out_before_it_is_given_up(shell):
    key = shell.make("A", "s")
    asked = shell.ask(SetParameters("A", "default", {}), timeout_s=1.0)
    shell.now += 1.0
    (wanted,) = [
        i
        for i in shell.core.handle(ev.TimerExpired(), shell.now)
        if isinstance(i, ev.InspectProcess)
    ]
    assert wanted == ev.InspectProcess(key, 0.5)
    assert not asked.is_answered
    shell.feed(ev.CallbackStuck(key, "A", "stuck in on_execute since 12:00:00"))
    shell.feed(ev.ProcessInspected(key))
    why = "no answer from s in time: A is stuck in on_execute since 12:00:00"
    assert asked.result.why == why


def test_an_answer_that_comes_while_it_is_looked_for_counts(shell):
    shell.make("A", "s")
    asked = shell.ask(SetParameters("A", "default", {}), timeout_s=1.0)
    shell.now += 1.0
    shell.core.handle(ev.TimerExpired(), shell.now)
    shell.serve()
    assert asked.result.ok


def test_nobody_waits_long_for_what_holds_up_an_answer(shell):
    shell.make("A", "s")
    asked = shell.ask(SetParameters("A", "default", {}), timeout_s=1.0)
    shell.now += 1.0
    shell.core.handle(ev.TimerExpired(), shell.now)
    shell.now += 0.2
    shell.feed(ev.TimerExpired())
    assert asked.result.why == "no answer from s in time"


def test_all_that_an_action_waits_for_takes_its_time_only_once(shell):
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s"), timeout_s=2.0)
    shell.wait(1.5)
    shell.fork("s")
    shell.wait(0.6)
    assert asked.result.kind == "unreachable"


def test_unloading_reaches_every_slave_also_a_stopped_one(shell):
    s, t = shell.make("A", "s"), shell.make("B", "t")
    load(shell, "a.py")
    shell.feed(ev.SlaveStopped(t, True))
    asked = shell.ask(Unload("a.py"))
    shell.reply(shell.next("unload"))
    assert asked.result.ok
    assert not shell.state.modules
    assert shell.told == [(key, {"op": "unload", "path": "a.py"}) for key in (s, t)]
    again = shell.ask(Unload("a.py"))
    shell.reply(shell.next("unload"))
    assert again.result.kind == "not-found"


# where components are made


def test_in_the_manager_itself(shell):
    for place in (
        "",
        "&manager_name=manager",
        "&manager=localhost:2810",
        "&manager_address=127.0.0.1:2810",
    ):
        instance = f"A{len(shell.state.components)}"
        asked = shell.ask(create(f"Thing?instance_name={instance}{place}"))
        shell.serve()
        assert asked.result.value == instance
        made = shell.state.components[instance]
        assert (made.process, made.names) == ("manager", (f"localhost/{instance}.rtc",))
    assert not shell.spawned


def test_in_a_named_slave_that_is_started_once(shell):
    one = shell.ask(create("Thing?instance_name=A&manager_name=s"))
    other = shell.ask(create("Thing?manager_name=s&instance_name=B"))
    assert list(shell.spawned) == ["s"]
    assert not shell.calls
    key = shell.fork("s", 777)
    assert [call.key for call in shell.calls] == [key, key]
    shell.serve()
    assert (one.result.value, other.result.value) == ("A", "B")
    (process,) = [p for p in shell.state.snapshot().processes if p.is_slave]
    assert (process.name, process.pid, process.state) == ("s", 777, "up")


def test_each_fresh_slave_is_another_and_named_after_its_pid(shell):
    text = "Thing?manager_name=manager_%p"
    asked = shell.ask(create(text), create(text), ordered=False)
    keys = [each.key for each in shell.state.processes.values() if each.is_slave]
    assert len(keys) == 2
    for key in keys:
        shell.feed(ev.SlaveForked(key, 50 + key))
        shell.feed(ev.SlaveReady(key))
    shell.serve()
    assert [result.value for result in asked.results] == ["Thing0", "Thing1"]
    made = list(shell.state.components.values())
    assert [each.process for each in made] == [f"manager_{50 + key}" for key in keys]
    again = f"Thing?manager_name=manager_{50 + keys[0]}&instance_name=Thing0"
    assert made[0].create == again


def test_by_the_address_of_a_local_slave(shell):
    shell.ask(create("Thing?instance_name=A&manager_address=localhost:2811"))
    shell.ask(create("Thing?instance_name=B&manager=host:2811"))
    assert list(shell.spawned) == ["manager_2811"]


@pytest.mark.parametrize(
    "address", ["localhost:", "localhost:x", "2811x", "localhost:²", "h:999999"]
)
def test_an_address_that_is_none(shell, address):
    result = shell.ask(create(f"Thing?manager={address}")).result
    assert (result.kind, result.code) == ("malformed", ReturnCode.BAD_PARAMETER)
    assert not shell.state.claims


def test_an_address_elsewhere(shell):
    assert shell.ask(create("Thing?manager=other:2811")).result.kind == "unreachable"


@pytest.mark.parametrize("name", ["a/b", "a b ", "..", "x" * 256])
def test_a_slave_or_component_of_a_name_that_cannot_be(shell, name):
    assert shell.ask(create(f"Thing?manager_name={name}")).result.kind == "malformed"
    assert shell.ask(create(f"Thing?instance_name={name}")).result.kind == "malformed"
    assert not shell.spawned
    assert not shell.calls


def test_a_pattern_travels_and_names_the_component(shell):
    asked = shell.ask(create("X", pattern=ComponentPattern(TypeProfile("Robot"))))
    assert shell.calls[0].message["pattern"] == {"type": {"type_name": "Robot"}}
    shell.serve()
    assert asked.result.value == "Robot0"


# names


def test_one_that_lives_is_returned_and_nothing_is_made(shell):
    shell.make("A", "s")
    assert shell.ask(create("Thing?instance_name=A&manager_name=t")).result.value == "A"
    assert not shell.calls
    assert not shell.spawned


def test_concurrent_creations_never_share_a_name(shell):
    asked = shell.ask(create("Thing"), create("Thing"), ordered=False)
    same = shell.ask(create("Thing?instance_name=Thing1"))
    assert not same.is_answered
    shell.serve()
    assert [result.value for result in asked.results] == ["Thing0", "Thing1"]
    assert same.result.value == "Thing1"


def test_creations_of_one_name_wait_for_the_first(shell):
    first, *others = [shell.ask(create(), timeout_s=float(n)) for n in (9, 8, 7)]
    late = shell.ask(create(), timeout_s=1.0)
    shell.wait(1.0)
    assert (late.result.kind, late.result.why) == ("unreachable", "A is just being made")
    shell.refuse(shell.next("create"))
    assert first.result.kind == "not-found"
    shell.serve()  # the first of those who wait makes it
    assert [asked.result.value for asked in others] == ["A", "A"]
    assert not shell.state.claims


def test_a_deletion_waits_for_the_creation(shell):
    made, deleted = shell.ask(create()), shell.ask(Delete("A"))
    shell.serve()
    assert (made.result.value, deleted.result.ok, shell.state.components) == ("A", True, {})


def test_a_name_is_taken_also_while_its_owner_is_being_made(shell):
    asked = shell.ask(create("Thing?instance_name=A", "localhost/dir/x.rtc"))
    late = shell.ask(create("Thing?instance_name=B", "localhost/dir/x.rtc"))
    assert late.result.why == "name /localhost/dir/x.rtc is taken by A"
    shell.serve()
    assert asked.result.ok
    assert shell.state.components["A"].names == ("localhost/dir/x.rtc",)
    late = shell.ask(create("Thing?instance_name=C", "localhost/c.rtc", "localhost/dir/x.rtc"))
    assert late.result.kind == "refused"
    assert not shell.state.claims


def test_a_default_name_that_another_took_is_refused_or_passed_over(shell):
    shell.ask(create("Thing?instance_name=A", "localhost/Thing0.rtc"))
    shell.serve()
    assert "is taken by A" in shell.ask(create("Thing?instance_name=Thing0")).result.why
    asked = shell.ask(create("Thing"))
    shell.serve()
    assert asked.result.value == "Thing1"


def test_a_name_given_twice_is_one(shell):
    shell.ask(create("Thing?instance_name=A", "localhost/a.rtc", "localhost/a.rtc"))
    shell.serve()
    assert shell.state.components["A"].names == ("localhost/a.rtc",)


# failures leave nothing


def test_a_failed_creation_leaves_nothing_and_retires_the_slave(shell):
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s"))
    key = shell.fork("s")
    shell.refuse(shell.next("create"), Refused("on_initialize failed"), "PRECONDITION_NOT_MET")
    assert asked.result.why == "on_initialize failed"
    assert asked.result.code is ReturnCode.PRECONDITION_NOT_MET
    assert shell.told == [(key, {"op": "delete", "instance": "A"})]
    assert shell.signals == [(key, signal.SIGTERM)]
    shell.end(key, "exit status 0")
    assert list(shell.state.processes) == [OWN]
    assert not shell.state.components
    assert not shell.state.claims


def test_a_failed_creation_ends_no_slave_in_which_another_is_being_made(shell):
    asked = shell.ask(
        create("Bad?instance_name=A&manager_name=s"),
        create("Good?instance_name=B&manager_name=s"),
        ordered=False,
    )
    key = shell.fork("s")
    shell.refuse(shell.next("create"))
    assert shell.signals == []
    shell.serve()
    assert [result.ok for result in asked.results] == [False, True]
    assert shell.state.held_by(key) == ["B"]


def test_deleting_the_last_one_ends_no_slave_in_which_another_is_being_made(shell):
    key = shell.make("A", "s")
    shell.ask(create("Thing?instance_name=B&manager_name=s"))
    making = shell.next("create")
    deleted = shell.ask(Delete("A"))
    shell.serve()
    assert deleted.result.ok
    assert shell.signals == []
    shell.say(key, facts=facts("B"))
    shell.reply(making)
    assert shell.state.held_by(key) == ["B"]


def test_facts_that_come_before_a_failure_are_taken_back(shell):
    asked = shell.ask(create())
    call = shell.next("create")
    shell.say(OWN, facts=facts("A"))
    shell.refuse(call)
    assert not asked.result.ok
    assert not shell.state.components
    assert shell.told == [(OWN, {"op": "delete", "instance": "A"})]


def test_what_was_connected_to_it_meanwhile_is_parted(shell):
    key = shell.make("Other", "s")
    asked = shell.ask(create())
    call = shell.next("create")
    shell.say(OWN, facts=facts("A"))
    connected = shell.ask(Connect(wire("w", "A.out", "Other.in")))
    shell.serve()
    assert connected.result.ok
    shell.refuse(call)
    assert not asked.result.ok
    assert not shell.state.connectors
    unlink = {"op": "unlink", "connector_id": "w"}
    assert [told for told in shell.told if told[1] == unlink] == [(OWN, unlink), (key, unlink)]


def test_a_good_answer_without_facts_is_not_believed(shell):
    asked = shell.ask(create())
    shell.reply(shell.next("create"))
    assert asked.result.why == "A ended while it was made"


@pytest.mark.parametrize("stage", ["asked", "forked", "making", "made"])
def test_a_slave_that_dies_at_each_stage_of_a_creation(shell, stage):
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s"))
    key = shell.spawned["s"]
    if stage != "asked":
        shell.feed(ev.SlaveForked(key, 9))
    if stage in ("making", "made"):
        shell.feed(ev.SlaveReady(key))
    if stage == "made":
        shell.say(key, facts=facts("A"))
    if stage == "asked":
        shell.feed(ev.SlaveFailed(key, "cannot fork: no memory"))
        assert asked.result.why == "slave s could not be started: cannot fork: no memory"
    else:
        shell.feed(ev.SlaveEnded(key, "signal 11 at a.py:7 in f", "no licence"))
        why = "slave s ended: signal 11 at a.py:7 in f; its last words: no licence"
        assert (asked.result.kind, asked.result.why) == ("unreachable", why)
    assert list(shell.state.processes) == [OWN]
    assert not shell.state.components


def test_a_slave_that_is_stopped_at_its_birth_is_given_up_at_once(shell):
    asked = [shell.ask(create(f"Thing?instance_name={each}&manager_name=s")) for each in "AB"]
    key = shell.spawned["s"]
    shell.feed(ev.SlaveForked(key, 9))
    shell.feed(ev.SlaveStopped(key, False))
    assert not any(each.is_answered for each in asked)
    shell.feed(ev.SlaveStopped(key, True))
    why = "slave s was stopped before it was ready, and is ended"
    assert [each.result.why for each in asked] == [why, why]
    assert shell.signals == [(key, signal.SIGKILL)]
    shell.feed(ev.SlaveEnded(key, "signal 9"))
    assert list(shell.state.processes) == [OWN]


def test_where_no_slave_can_be_made_each_creation_says_why_at_once(shell):
    known = shell.make("A", "s")
    shell.feed(ev.SpawnDisabled("the zygote is stopped"))
    why = "no slave can be started: the zygote is stopped"
    assert shell.ask(create("Thing?manager_name=t")).result.why == why
    assert shell.state.snapshot().processes[0].reason == why
    asked = shell.ask(create("Thing?instance_name=B&manager_name=s"))
    shell.serve()
    assert asked.result.ok
    assert known in shell.state.processes
    shell.feed(ev.SpawnDisabled(""))
    assert shell.state.snapshot().processes[0].reason == ""
    assert not shell.ask(create("Thing?manager_name=t")).is_answered


def test_who_was_asked_for_when_births_were_barred_says_so_when_time_is_up(shell):
    asked = shell.ask(create("Thing?manager_name=s"), timeout_s=3.0)
    shell.feed(ev.SpawnDisabled("the zygote is stopped"))
    assert not asked.is_answered
    shell.wait(3.1)
    assert asked.result.why == "slave s did not start in time: the zygote is stopped"


def test_a_slave_that_does_not_start_in_time_is_killed_whenever_it_comes(shell):
    asked = shell.ask(create("Thing?manager_name=s"), timeout_s=3.0)
    key = shell.spawned["s"]
    shell.wait(2.9)
    assert not asked.is_answered
    shell.wait(0.2)
    assert asked.result.why == "slave s did not start in time"
    shell.signals.clear()
    shell.feed(ev.SlaveForked(key, 9))
    shell.feed(ev.SlaveReady(key))
    assert shell.killed() == [key, key]
    again = shell.ask(create("Thing?manager_name=s"))
    assert shell.spawned["s"] != key
    shell.end(key)
    shell.fork("s")
    shell.serve()
    assert again.result.ok


def test_a_slave_is_not_killed_while_somebody_still_waits_for_it(shell):
    short = shell.ask(create("Thing?manager_name=s"), timeout_s=1.0)
    patient = shell.ask(create("Thing?manager_name=s"), timeout_s=5.0)
    shell.wait(1.5)
    assert not short.result.ok
    assert shell.signals == []
    shell.fork("s")
    shell.serve()
    assert patient.result.ok


def test_a_creation_that_takes_too_long_is_undone_and_its_late_facts_are_ignored(shell):
    key = shell.make("Other", "s")
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s"), timeout_s=2.0)
    slow = shell.next("create")
    shell.wait(2.0)
    assert asked.result.why == "no answer from s in time"
    assert shell.told == [(key, {"op": "delete", "instance": "A"})]
    with pytest.raises(Malformed, match="does not hold"):
        shell.say(key, facts=facts("A"))
    shell.reply(slow)
    shell.say(key, gone="A")
    assert list(shell.state.components) == ["Other"]


def test_late_facts_do_not_displace_one_that_is_made_elsewhere(shell):
    slow = shell.make("Other", "slow")
    shell.ask(create("Thing?instance_name=A&manager_name=slow"), timeout_s=1.0)
    shell.calls.clear()
    shell.wait(1.0)
    again = shell.ask(create("Thing?instance_name=A&manager_name=quick"))
    quick = shell.fork("quick")
    with pytest.raises(Malformed):
        shell.say(slow, facts=facts("A"))
    shell.serve()
    shell.say(slow, gone="A")
    assert again.result.ok
    assert shell.state.containers["A"] == quick
    assert shell.state.components["A"].process == "quick"


# zombies


def test_a_dead_slave_leaves_zombies_with_the_reason(shell):
    key = shell.make("A", "s")
    shell.make("B")
    shell.end(key, "signal 9")
    listed = shell.state.components
    assert (listed["A"].zombie, listed["B"].zombie) == ("signal 9", "")
    for action in (
        ChangeState("A", "0", Transition.ACTIVATE),
        SetParameters("A", "default", {}),
    ):
        assert shell.ask(action).result.why == "zombie (signal 9): A"


def test_a_creation_over_a_zombie_takes_its_place_and_names(shell):
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s", "localhost/dir/a.rtc"))
    dead = shell.fork("s")
    shell.serve()
    shell.end(dead)
    asked = shell.ask(create("Thing?instance_name=A&manager_name=s"))
    key = shell.fork("s")
    assert shell.state.components["A"].zombie
    shell.serve()
    assert asked.result.ok
    made = shell.state.components["A"]
    assert (made.zombie, made.names) == ("", ("localhost/dir/a.rtc",))
    assert list(shell.state.processes) == [OWN, key]


def test_what_takes_the_place_of_a_zombie_says_what_it_lacks(shell):
    key = shell.make("A", "s")
    shell.make("B")
    shell.ask(Connect(wire("w")), SetParameters("A", "default", {"p": "1"}))
    shell.serve()
    shell.end(key)
    again = shell.ask(create("Thing?instance_name=A"))
    shell.serve()
    lost = "connections w; values that were set"
    assert f"A is new, and without what the one that died had: {lost} (" in again.result.left_out
    shell.ask(Delete("B"))
    shell.serve()
    shell.make("C", "s")
    shell.end(shell.state.containers["C"])
    bare = shell.ask(create("Thing?instance_name=C"))
    shell.serve()
    assert (bare.result.ok, bare.result.note) == (True, "")


def test_a_zombie_stays_when_its_successor_fails(shell):
    dead = shell.make("A", "s")
    shell.end(dead, "signal 11")
    shell.ask(create())
    shell.refuse(shell.next("create"))
    assert shell.state.components["A"].zombie == "signal 11"
    assert dead in shell.state.processes


def test_a_zombie_is_deleted_without_asking_anybody(shell):
    dead = shell.make("A", "s")
    shell.end(dead)
    assert shell.ask(Delete("A")).result.ok
    assert not shell.calls
    assert list(shell.state.processes) == [OWN]


# deletion


def test_a_deletion_ends_the_slave_that_is_left_empty(shell):
    key = shell.make("A", "s")
    asked = shell.ask(Delete("A"))
    shell.serve()
    assert shell.signals == [(key, signal.SIGTERM)]
    assert not asked.is_answered
    shell.end(key, "exit status 0")
    assert asked.result.ok
    assert list(shell.state.processes) == [OWN]


def test_an_empty_slave_that_does_not_go_is_killed(shell):
    key = shell.make("A", "s")
    asked = shell.ask(Delete("A"))
    shell.serve()
    shell.wait(1.9)
    assert shell.killed() == []
    shell.wait(0.2)
    assert shell.killed() == [key]
    shell.end(key)
    assert asked.result.ok


def test_a_slave_that_holds_another_stays(shell):
    shell.make("A", "s")
    shell.make("B", "s")
    asked = shell.ask(Delete("A"))
    shell.serve()
    assert asked.result.ok
    assert shell.signals == []


def test_a_deletion_that_takes_too_long_keeps_the_entry_until_it_is_true(shell):
    shell.make("A")
    asked = shell.ask(Delete("A"), timeout_s=1.0)
    shell.next("delete")
    shell.wait(1.0)
    assert asked.result.kind == "unreachable"
    assert "A" in shell.state.components
    again = shell.ask(Delete("A"))
    assert shell.next("delete").message["instance"] == "A"
    shell.wait(10.0)
    assert again.result.kind == "unreachable"
    shell.say(OWN, gone="A")
    assert "A" not in shell.state.components
    assert shell.ask(Delete("A")).result.kind == "not-found"


def test_a_deletion_of_what_its_process_no_longer_has_is_done(shell):
    shell.make("A")
    asked = shell.ask(Delete("A"))
    shell.refuse(shell.next("delete"), NotFound("no component named A"))
    assert asked.result.ok
    assert not shell.state.components


def test_while_one_is_being_deleted_nothing_else_is_done_with_it(shell):
    shell.make("A")
    asked = shell.ask(Delete("A"))
    for action in (Delete("A"), ChangeState("A", "0", Transition.ACTIVATE)):
        result = shell.ask(action).result
        assert (result.kind, result.why) == ("refused", "A is just being deleted")
    again = shell.ask(create())
    shell.serve()
    assert asked.result.ok
    assert (again.result.value, list(shell.state.components)) == ("A", ["A"])


def test_one_in_a_stopped_slave_is_not_touched(shell):
    key = shell.make("A", "s")
    shell.feed(ev.SlaveStopped(key, True))
    why = "slave s does not answer: it is stopped; rtexit --force ends its slave s"
    assert shell.ask(Delete("A")).result.why == why
    shell.feed(ev.SlaveStopped(key, False))
    asked = shell.ask(Delete("A"))
    shell.serve()
    shell.end(key)
    assert asked.result.ok


# what slaves say is not trusted


@pytest.mark.parametrize(
    "message",
    [
        {},
        {"hello": 1},
        {"facts": None},
        {"facts": []},
        {"facts": {"instance": 5}},
        {"facts": {"instance": "A"}},
        {"facts": {**facts("A"), "ports": [{"name": "p"}]}},
        {"facts": {**facts("A"), "unknown": 1}},
        {"facts": facts("Stranger")},
        {"facts": facts("Own")},
    ],
)
def test_a_report_that_is_wrong_changes_nothing(shell, message):
    key = shell.make("A", "s")
    shell.make("Own")
    before = shell.state.snapshot()
    with pytest.raises(Malformed):
        shell.say(key, **message)
    assert shell.state.snapshot() == before


@pytest.mark.parametrize(
    "message",
    [
        {"gone": None},
        {"gone": []},
        {"gone": "Own"},
        {"gone": "Nobody"},
        {"reply": None},
        {"reply": []},
        {"reply": {}},
        {"reply": -1},
        {"reply": 1.5},
        {"reply": 10**30, "value": {}},
    ],
)
def test_a_message_that_nobody_waits_for_changes_nothing(shell, message):
    key = shell.make("A", "s")
    shell.make("Own")
    before = shell.state.snapshot()
    shell.say(key, **message)
    assert shell.state.snapshot() == before


def test_a_slave_cannot_answer_for_another(shell):
    rogue = shell.make("Rogue", "r")
    shell.make("A", "s")
    asked = shell.ask(ChangeState("A", "0", Transition.ACTIVATE))
    call = shell.next("change_state")
    shell.say(rogue, reply=call.number, value="")
    assert not asked.is_answered
    shell.reply(call)
    assert asked.result.ok


@pytest.mark.parametrize("answer", [{"code": "nonsense"}, {"code": []}, {"code": 7, "why": None}])
def test_an_answer_with_an_unknown_code_is_an_error(shell, answer):
    shell.make("A")
    asked = shell.ask(ChangeState("A", "0", Transition.ACTIVATE))
    shell.say(OWN, reply=shell.next("change_state").number, **answer)
    assert asked.result.code is ReturnCode.ERROR


def test_a_value_that_is_no_text_does_not_reach_the_client(shell):
    shell.make("A")
    asked = shell.ask(ChangeState("A", "0", Transition.ACTIVATE))
    shell.reply(shell.next("change_state"), {"a": [1]})
    assert asked.result.value == ""


def test_a_slave_cannot_name_or_place_its_component(shell):
    key = shell.make("A", "s")
    claimed = {
        "names": ["localhost/Own.rtc"],
        "create": "Evil",
        "zombie": "x",
        "process": "manager",
    }
    before = shell.state.components["A"]
    shell.say(key, facts={**facts("A"), **claimed, "trouble": "x"})
    assert shell.state.components["A"] == before


def test_what_was_said_before_a_death_and_is_heard_after_it_raises_nobody(shell):
    key = shell.make("A", "s")
    shell.end(key)
    shell.say(key, facts=facts("A"))
    shell.say(key, gone="A")
    assert shell.state.components["A"].zombie == "signal 9"
    shell.feed(ev.SlaveReady(key))
    shell.feed(ev.SlaveStopped(key, False))
    shell.feed(ev.SlaveEnded(key, "signal 15"))
    assert shell.state.components["A"].zombie == "signal 9"


def test_reports_of_unknown_processes_are_ignored(shell):
    shell.say(99, facts=facts("A"))
    for event in (
        ev.SlaveForked(99, 5),
        ev.SlaveReady(99),
        ev.SlaveEnded(99, "x"),
        ev.SlaveFailed(99, "x"),
        ev.SlaveStopped(99, True),
    ):
        assert shell.feed(event) == []


# what is there already


def test_what_is_there_as_it_was_asked_for_is_returned_without_a_word(shell):
    shell.make("A", "s")
    for text in ("Thing?instance_name=A", "Thing?instance_name=A&manager_name=s"):
        result = shell.ask(create(text)).result
        assert (result.ok, result.value, result.note) == (True, "A", "")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Thing?instance_name=A&manager_name=t", "in s"),
        ("Thing?instance_name=A&manager=localhost:2811", "in s"),
    ],
)
def test_what_is_there_otherwise_is_returned_with_a_note(shell, text, told):
    shell.make("A", "s")
    result = shell.ask(create(text)).result
    note = f"A exists already, {told}: nothing was made"
    assert (result.ok, result.value, result.note) == (True, "A", note)


def test_one_of_another_type_that_is_there_is_not_what_was_asked_for(shell):
    shell.make("A", "s")
    for text in ("Other?instance_name=A", "Other?instance_name=A&manager_name=t"):
        result = shell.ask(create(text)).result
        assert (result.kind, result.why) == ("refused", "A exists already, as Thing")
    assert not shell.calls


def loaded(shell, path, init, file, *types):
    asked = shell.ask(Load(path, init))
    shell.fork(TRIAL)
    call = shell.next("load")
    module = ModuleProfile(path, init, tuple(map(TypeProfile, types)), file)
    shell.reply(call, {"module": encode(module), "fingerprint": 1})
    shell.end(call.key, "exit status 0")
    assert asked.result.value == path


def listed(shell):
    return [(each.path, each.init, each.aliases) for each in shell.state.snapshot().modules]


def test_each_init_function_of_a_module_is_called(shell):
    loaded(shell, "Two.py", "AInit", "/m/Two.py", "A")
    loaded(shell, "Two.py", "BInit", "/m/Two.py", "B")
    assert listed(shell) == [("Two.py", "AInit", ()), ("Two.py", "BInit", ())]
    shell.ask(create("B?instance_name=B1"))
    assert shell.next("create").message["modules"] == [["Two.py", "BInit"]]
    asked = shell.ask(Load("Two.py", "CInit"))
    shell.fork(TRIAL)
    shell.refuse(shell.next("load"), NotFound("no init function CInit in module Two.py"))
    assert asked.result.kind == "not-found"
    assert dict(shell.state.kept.modules) == {"Two.py:AInit": "AInit", "Two.py:BInit": "BInit"}


def test_a_module_is_the_same_by_whatever_path_it_is_named(shell):
    loaded(shell, "Two.py", "AInit", "/m/Two.py", "A")
    loaded(shell, "/l/Two.py", "AInit", "/m/Two.py", "A")  # by a link
    assert listed(shell) == [("Two.py", "AInit", ("/l/Two.py",))]
    for path in ("Two.py", "/l/Two.py", "/m/Two.py"):
        asked = shell.ask(Load(path, "AInit"))
        shell.reply(shell.next("fingerprint"), 1)
        assert asked.result.ok
    asked = shell.ask(Unload("./Two.py"))
    shell.reply(shell.next("unload"), "/m/Two.py")
    assert asked.result.ok
    assert (listed(shell), dict(shell.state.kept.modules)) == ([], {})


def test_a_module_that_a_process_found_by_itself_is_listed_and_can_be_forgotten(shell):
    key = shell.make("A", "s")
    made = ModuleProfile("Thing.py", "ThingInit", (TypeProfile("Thing"),), "/m/Thing.py")
    module = {"module": encode(made), "fingerprint": 1}
    shell.say(key, loaded=[module])
    shell.say(OWN, loaded=[module])
    assert listed(shell) == [("Thing.py", "ThingInit", ())]
    assert not shell.state.kept.modules  # who needs it finds it again
    asked = shell.ask(Unload("Thing.py"))
    shell.reply(shell.next("unload"), "/m/Thing.py")
    assert asked.result.ok
    assert shell.told[-1] == (key, {"op": "unload", "path": "Thing.py"})


def test_what_is_odd_in_a_module_or_in_options_is_a_note(shell):
    asked = shell.ask(Load("a.py", "aInit"))
    shell.fork(TRIAL)
    call = shell.next("load")
    shell.reply(call, {**module_of(call, "Thing"), "remarks": ["A.on_exectue is no callback"]})
    assert asked.result.note == "A.on_exectue is no callback"
    asked = shell.ask(create("Thing?instance_name=B"))
    call = shell.next("create")
    shell.say(call.key, facts=facts("B"))
    shell.reply(call, {"changed": "", "remarks": ["one", "two"]})
    assert asked.result.note == "one; two"


def test_what_is_odd_is_refused_where_it_is_strict_and_nothing_stays(shell):
    asked = shell.ask(strict(Load("a.py", "aInit")))
    shell.fork(TRIAL)
    call = shell.next("load")
    shell.reply(call, {**module_of(call, "Thing"), "remarks": ["A.on_exectue is no callback"]})
    assert (asked.result.kind, asked.result.why) == ("refused", "A.on_exectue is no callback")
    assert shell.state.modules == {}
    asked = shell.ask(strict(create("Thing?instance_name=B&manager_name=s")))
    key = shell.fork("s")
    call = shell.next("create")
    shell.say(call.key, facts=facts("B"))
    shell.reply(call, {"changed": "", "remarks": ["unknown option: manager_nme"]})
    assert (asked.result.kind, asked.result.why) == ("refused", "unknown option: manager_nme")
    assert (shell.state.components, shell.state.kept.components) == ({}, {})
    assert shell.told[-1] == (key, {"op": "delete", "instance": "B"})
    assert (key, signal.SIGTERM) in shell.signals  # it was started for nothing else


def test_what_is_there_elsewhere_is_refused_where_it_is_strict(shell):
    shell.make("A", "s")
    again = create("Thing?instance_name=A&manager_name=t")
    assert shell.ask(again).result.note == "A exists already, in s: nothing was made"
    refused = shell.ask(strict(again)).result
    assert (refused.ok, refused.why) == (False, "A exists already, in s: nothing was made")
    assert shell.ask(strict(create("Thing?instance_name=A&manager_name=s"))).result.ok


def test_a_component_of_code_that_was_edited_since_is_made_with_a_note(shell):
    shell.make("A", "s")
    asked = shell.ask(create("Thing?instance_name=B&manager_name=s"))
    call = shell.next("create")
    shell.say(call.key, facts=facts("B"))
    shell.reply(call, {"changed": "Thing.py"})
    assert asked.result.value == "B"
    assert asked.result.note.startswith("B is made of Thing.py as s had loaded it, which has chang")


@pytest.mark.parametrize(
    "address", ["localhost:99999", "localhost:0", ":2811", "localhost", "localhost:x"]
)
def test_an_address_that_nobody_can_have(shell, address):
    result = shell.ask(create(f"Thing?manager={address}")).result
    assert (result.kind, result.why) == (
        "malformed",
        f"manager address is not host:port: {address}",
    )


def test_languages(shell):
    result = shell.ask(create("Thing?language=Klingon")).result
    why = "language Klingon is not supported (supported: Python)"
    assert (result.kind, result.why) == ("refused", why)
    shell.ask(create("Thing?instance_name=A&language=python"))
    made = shell.next("create").message["create"]
    assert made == "RTC:::Thing:Python:?instance_name=A&language=python"


# names that are new


def test_names_of_neighbours_are_asked_for_and_left_out(shell):
    shell.state.settings.take("manager.components.naming_policy", "node_unique")
    asked = shell.ask(create("Thing"))
    call = shell.next("neighbours")
    assert (call.key, call.message["manager"]) == (OWN, "manager")
    shell.reply(call, ["Thing0", "Thing2", "Other"])
    assert "instance_name=Thing1" in shell.next("create").message["create"]
    assert not asked.is_answered
    shell.ask(create("Thing"))
    shell.reply(shell.next("neighbours"), ["Thing0", "Thing2"])
    assert "instance_name=Thing3" in shell.next("create").message["create"]


def test_neighbours_that_do_not_answer_hold_up_nothing(shell):
    shell.state.settings.take("manager.components.naming_policy", "ns_unique")
    shell.ask(create("Thing"))
    shell.refuse(shell.next("neighbours"), Refused("no"))
    assert "instance_name=Thing0" in shell.next("create").message["create"]
    shell.ask(create("Thing"))
    shell.next("neighbours")
    shell.wait(5)
    assert "instance_name=Thing1" in shell.next("create").message["create"]


def test_who_is_named_needs_no_neighbours(shell):
    shell.state.settings.take("manager.components.naming_policy", "node_unique")
    shell.ask(create("Thing?instance_name=A"))
    assert "instance_name=A" in shell.next("create").message["create"]
