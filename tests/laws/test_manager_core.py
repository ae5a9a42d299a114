"""Laws of the manager's core: whatever clients, slaves and the kernel do, in whatever order.

A machine plays the shell: clients ask, holders answer well, badly, late, twice or wrongly, slaves
die and stop at any moment, and the clock jumps. Any stream, replayed from a dump, ends in an equal
state; it is replayed in another process, whose hashes of texts are others.
"""

from __future__ import annotations

import itertools
import math
import os
import subprocess
import sys
from contextlib import suppress
from itertools import count, cycle
from pathlib import Path

import pytest
from fake_shell import OWN, FakeShell, facts, module_of, wire
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from rtkit.deployment import actions as act
from rtkit.deployment.delta import TREE, Delta, FullSnapshot, applied
from rtkit.deployment.limits import NO_LIMITS, limits_in
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core.deletion import FINALISE_S, TERM_S
from rtkit.manager.core.dump import Dump, to_lines
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import Transition
from rtkit.rtc.serde import decode, decode_text

INSTANCES = ("A", "B", "C")
PLACES = ("", "", "&manager_name=s", "&manager_name=t", "&manager_name=manager_%p")
POLICIES = (
    "",
    "",
    "&rtkit.restart=on-failure",
    "&rtkit.restart=always&rtkit.critical=yes",
    "&rtkit.limit.memory=1G&rtkit.restart=on-failure",
    "&rtkit.limit.memory=2G&rtkit.limit.processes=3",
)
NAMES = ((), (), ("localhost/x.rtc",), ("localhost/A.rtc",))
WIRES = [
    wire(connector_id, f"{out}.out", f"{into}.in", dataport__dataflow_type=flow)
    for connector_id in ("v", "w")
    for out, into in (("A", "B"), ("B", "C"), ("A", "A"))
    for flow in ("push", "pull")
]

creates = st.builds(
    lambda instance, place, policy, names: act.Create(
        f"Thing?{f'instance_name={instance}' if instance else 'x=1'}{place}{policy}", names
    ),
    st.sampled_from((*INSTANCES, "")),
    st.sampled_from(PLACES),
    st.sampled_from(POLICIES),
    st.sampled_from(NAMES),
)
instances = st.sampled_from((*INSTANCES, "Thing0"))
actions = st.one_of(
    creates,
    creates,
    st.builds(act.Delete, instances, st.booleans()),
    st.builds(act.EndSlave, st.sampled_from(["s", "t", "manager", "no"]), st.booleans()),
    st.sampled_from(WIRES).map(act.Connect),
    st.sampled_from(["v", "w"]).map(act.Disconnect),
    instances.map(lambda instance: act.ChangeState(instance, "0", Transition.ACTIVATE)),
    st.sampled_from(["m", "n"]).map(act.Load),
    st.sampled_from(["m", "n"]).map(act.Unload),
)
indexes = st.integers(0, 1000)
WRONG = (
    {},
    {"facts": None},
    {"facts": {"instance": "A"}},
    {"facts": facts("Stranger")},
    {"gone": "Stranger"},
    {"gone": 7},
    {"reply": []},
    {"reply": 10**9, "value": {}},
)


class CoreMachine(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        self.shell = FakeShell(ring_size=self.ring_size())
        self.known = None
        self.heard = []
        carry_out = self.shell._carry_out

        def hear(instruction):
            if isinstance(instruction, ev.Publish):
                self.heard.append(decode(Delta, instruction.message))
            carry_out(instruction)

        self.shell._carry_out = hear
        self.asked = []
        self.old_calls = []
        self.held = {OWN: set()}
        self.is_stopping = False

    @initialize(
        places=st.lists(st.sampled_from(["", "s", "t"]), max_size=3),
        wires=st.lists(st.sampled_from(WIRES), max_size=3),
    )
    def begin(self, places, wires):
        for instance, place in zip(INSTANCES, places, strict=False):
            key = self.shell.make(instance, place)
            self.held.setdefault(key, set()).add(instance)
            if place:
                self.shell.ask(act.SetPolicy(instance, {"rtkit.limit.memory": "1G"}))
        self.asked.append(self.shell.ask(*map(act.Connect, wires), ordered=False))

    def ring_size(self):
        return 0

    @rule()
    def subscribe(self):
        replies = []
        self.shell.feed(ev.SnapshotRequested(self.shell.requests.add(replies.append)))
        whole = decode_text(FullSnapshot, replies[0].value())
        self.heard = [delta for delta in self.heard if delta.number > whole.number]
        self.known = whole.facts

    @rule()
    def unsubscribe(self):
        self.known = None
        self.shell.feed(ev.ListenersChanged(TREE, False))

    # clients

    @rule(
        batch=st.lists(actions, max_size=4), ordered=st.booleans(), timeout=st.sampled_from([1, 5])
    )
    def ask(self, batch, ordered, timeout):
        self.asked.append(self.shell.ask(*batch, ordered=ordered, timeout_s=timeout))

    @rule(action=actions)
    def ask_one(self, action):
        self.asked.append(self.shell.ask(action))

    @precondition(lambda self: not self.is_stopping)
    @rule(really=st.integers(0, 9))
    def stop(self, really):
        if not really:
            self.is_stopping = True
            self.shell.stop()
            assert all(asked.is_answered for asked in self.asked)

    @precondition(lambda self: self.is_stopping)
    @rule(really=st.integers(0, 4))
    def hurry(self, really):
        if not really:
            self.shell.feed(ev.StopRequested(is_urgent=True))

    # time

    @rule(seconds=st.sampled_from([0.1, 0.1, 1.0, 3.0, 60.0]))
    def wait(self, seconds):
        self.shell.wait(seconds)

    @rule(seconds=st.sampled_from([2.0, 1000.0]))
    def jump(self, seconds):
        """The loop was held up: time has passed, and no tick came."""
        self.shell.now += seconds

    # the zygote and the kernel

    def slaves(self, *states):
        processes = self.shell.state.processes.values()
        return [p for p in processes if p.is_slave and p.state in states]

    @precondition(lambda self: self.shell.spawned)
    @rule(index=indexes, does_fork=st.booleans())
    def fork(self, index, does_fork):
        names = sorted(self.shell.spawned)
        key = self.shell.spawned.pop(names[index % len(names)])
        if does_fork:
            self.shell.feed(ev.SlaveForked(key, 200 + key))
        else:
            self.shell.feed(ev.SlaveFailed(key, "cannot fork"))

    @precondition(lambda self: any(p.pid for p in self.slaves("starting")))
    @rule(index=indexes)
    def greet(self, index):
        born = [p for p in self.slaves("starting") if p.pid]
        process = born[index % len(born)]
        self.held[process.key] = set()
        self.shell.feed(ev.SlaveReady(process.key))

    @precondition(lambda self: self.slaves("starting", "up", "stopped"))
    @rule(index=indexes)
    def die(self, index):
        living = self.slaves("starting", "up", "stopped")
        key = living[index % len(living)].key
        self.shell.spawned = {n: k for n, k in self.shell.spawned.items() if k != key}
        self.held.pop(key, None)
        self.shell.end(key, "signal 9")

    @precondition(lambda self: self.slaves("up", "stopped"))
    @rule(index=indexes)
    def reach_a_limit(self, index):
        living = self.slaves("up", "stopped")
        self.shell.feed(ev.SlaveOverLimit(living[index % len(living)].key, "memory limit reached"))

    @rule(why=st.sampled_from(["", "", "the disk is full"]))
    def fill(self, why):
        self.shell.disk = why

    @rule(why=st.sampled_from(["", "the zygote ended"]))
    def bar(self, why):
        self.shell.feed(ev.SpawnDisabled(why))

    @precondition(lambda self: self.slaves("starting", "up", "stopped"))
    @rule(index=indexes, is_halted=st.booleans())
    def halt(self, index, is_halted):
        living = self.slaves("starting", "up", "stopped")
        self.shell.feed(ev.SlaveStopped(living[index % len(living)].key, is_halted))

    # holders

    @precondition(lambda self: self.shell.calls)
    @rule(choices=st.lists(indexes, min_size=1, max_size=4))
    def answer(self, choices):
        for index in choices[: len(self.shell.calls)]:
            if self.shell.calls:
                self.perform(self.take(index))

    @rule()
    def answer_all(self):
        while self.shell.calls:
            self.perform(self.take(0))

    @precondition(lambda self: self.shell.calls)
    @rule(index=indexes, error=st.sampled_from([Refused("no"), NotFound("no")]))
    def refuse(self, index, error):
        self.shell.refuse(self.take(index), error)

    @precondition(lambda self: self.shell.calls)
    @rule(index=indexes)
    def say_good_but_do_nothing(self, index):
        call = self.take(index)
        self.shell.reply(call, self.value(call))

    @precondition(lambda self: any(c.op == "create" and c.key == OWN for c in self.shell.calls))
    @rule(path=st.sampled_from(["m", "n"]))
    def want_a_trial(self, path):
        call = next(c for c in self.shell.calls if c.op == "create" and c.key == OWN)
        self.shell.calls.remove(call)
        self.old_calls.append(call)
        self.shell.reply(call, {"untried": path, "init": ""})

    @precondition(lambda self: self.old_calls)
    @rule(index=indexes)
    def answer_again(self, index):
        call = self.old_calls[index % len(self.old_calls)]
        self.shell.reply(call, self.value(call))

    @rule(index=indexes, message=st.sampled_from(WRONG))
    def say_what_is_wrong(self, index, message):
        self.shell.feed(ev.TimerExpired())
        before = self.shell.state.snapshot()
        keys = sorted(self.shell.state.processes)
        with suppress(Malformed):
            self.shell.say(keys[index % len(keys)], **message)
        self.shell.wait(0.0)
        assert self.shell.state.snapshot().components == before.components

    @rule(
        instances=st.lists(st.sampled_from(INSTANCES), max_size=3),
        wires=st.lists(st.sampled_from(WIRES), max_size=2),
        pid=st.sampled_from([900, 901, 902]),
        name=st.sampled_from(["s", "t", "u"]),
    )
    def find(self, instances, wires, pid, name):
        """A slave of an earlier manager comes back, or one whose line broke."""
        self.held[self.shell.find(pid, name, instances, wires)] = set(instances)

    @rule(components=st.sampled_from([None, [1], [{}], [facts("a/b")]]))
    def find_nonsense(self, components):
        self.shell.feed(ev.TimerExpired())
        before = self.shell.state.snapshot()
        with suppress(Malformed):
            self.shell.feed(ev.SlaveFound(999, "s", components, []))
        assert self.shell.state.snapshot() == before

    @rule(instance=st.sampled_from(INSTANCES), key=st.integers(1, 5))
    def the_dead_are_heard(self, instance, key):
        process = self.shell.state.processes.get(key)
        if process is None or not process.is_alive:
            self.shell.feed(ev.TimerExpired())  # what is due is done by any event
            before = self.shell.state.snapshot()
            self.shell.say(key, facts=facts(instance))
            self.shell.say(key, gone=instance)
            self.shell.feed(ev.SlaveReady(key))
            assert self.shell.state.snapshot() == before

    @precondition(lambda self: any(self.held.values()))
    @rule(index=indexes)
    def one_ends_by_itself(self, index):
        pairs = [(key, instance) for key, held in self.held.items() for instance in sorted(held)]
        key, instance = pairs[index % len(pairs)]
        self.held[key].discard(instance)
        self.shell.say(key, gone=instance)

    def take(self, index):
        """Take the oldest call of some process: holders do one thing after the other."""
        first = list({call.key: call for call in reversed(self.shell.calls)}.values())
        call = first[index % len(first)]
        self.shell.calls.remove(call)
        self.old_calls.append(call)
        return call

    def perform(self, call):
        held = self.held.get(call.key, set())
        if call.op == "create":
            instance = parse_create(call.message["create"]).instance_name
            held.add(instance)
            try:
                self.shell.say(call.key, facts=facts(instance))
            except Malformed:
                held.discard(instance)  # it was given up long ago, and has been deleted since
        elif call.op == "delete":
            if call.message["instance"] not in held:
                self.shell.refuse(call, NotFound("no such component"))
                return
            held.discard(call.message["instance"])
            self.shell.say(call.key, gone=call.message["instance"])
        self.shell.reply(call, self.value(call))

    @staticmethod
    def value(call):
        if call.op == "load":
            return module_of(call)
        return "unix/x" if call.op in ("sink", "serve") else ""

    # the laws; that the facts agree, and that the lost get no message, the shell checks each time

    @invariant()
    def each_batch_is_answered_at_most_once(self):
        assert all(len(asked.replies) <= 1 for asked in self.asked)

    @invariant()
    def subscribers_know_all_that_has_been_made(self):
        if self.known is None:
            self.heard.clear()
            return
        for delta in self.heard:
            self.known = applied(self.known, delta)
        self.heard.clear()
        state, known = self.shell.state, self.known
        facts = state.snapshot()
        made = {c.instance: c for c in facts.components if c.instance not in state.claims}
        assert {each.instance: each for each in known.components} == made
        wires = {each.connector_id: each for each in facts.connectors}
        assert {each.connector_id: each for each in known.connectors} == wires
        living = {each.pid: each for each in facts.processes if each.pid}  # of two, the later one
        assert {each.pid: each for each in known.processes} == living
        assert (known.names, known.systems) == (facts.names, facts.systems)

    @invariant()
    def nothing_is_held_when_nothing_is_under_way(self):
        state = self.shell.state
        if self.shell.core.is_idle:
            assert all(asked.is_answered for asked in self.asked)
            assert not state.claims
            assert not state.ending
            assert not state.openings

    @invariant()
    def slaves_are_limited_as_what_they_hold_says(self):
        state = self.shell.state
        for process in self.slaves("up", "stopped") if self.shell.core.is_idle else ():
            said = [limits_in(state.components[each].create) for each in state.held_by(process.key)]
            told = self.shell.limits.get(process.key, NO_LIMITS)
            assert told == sum(said, start=NO_LIMITS)

    @invariant()
    def a_core_that_waits_wants_to_be_woken(self):
        if not self.shell.core.is_idle:
            assert self.shell.wake_at is not None
            assert math.isfinite(self.shell.wake_at)

    @invariant()
    def what_is_on_the_disk_is_what_is_wished(self):
        state = self.shell.state
        if self.shell.core.is_idle and not state.unkept and not self.is_stopping:
            kept = {name for kind, name in self.shell.rows if kind == "component"}
            assert kept == state.kept.components.keys()

    @invariant()
    def it_finishes_only_when_asked_to(self):
        assert self.is_stopping or not self.shell.is_finished

    def teardown(self):
        """After a stop everything ends in bounded time, though nobody answers any more."""
        self.shell.stop()
        assert all(asked.is_answered for asked in self.asked)
        self.shell.wait(FINALISE_S + 2 * TERM_S + 1.0)
        assert self.shell.is_finished
        for process in self.slaves("starting", "up", "stopped"):
            self.shell.end(process.key, "signal 9")
        self.shell.wait(100.0)
        assert self.shell.core.is_idle
        assert all(len(asked.replies) == 1 for asked in self.asked)
        assert not [p for p in self.shell.state.processes.values() if p.is_slave and p.is_alive]
        numbers = [call.number for call in itertools.chain(self.shell.calls, self.old_calls)]
        assert len(numbers) == len(set(numbers))


CoreMachine.TestCase.settings = settings(max_examples=200, stateful_step_count=60, deadline=None)
TestCore = CoreMachine.TestCase

STREAMS = 1000
STEPS = 15
HEADER = {"manager": "manager", "rtkit": "1"}
REPLAY = """
import sys
from pathlib import Path
from rtkit.manager.core.dump import from_lines
from rtkit.manager.core.replay import Replay

for path in Path(sys.argv[1]).iterdir():
    with path.open() as file:
        replay = Replay(from_lines(file).recording)
    steps = list(replay.steps())
    assert steps
    assert not replay.differences, (path, replay.differences)
    print(len(steps))
"""


def machine(folder: Path) -> type[CoreMachine]:
    """Return a machine that writes a dump of each of its streams."""
    sizes, numbers = cycle((10, 60, 4096)), count()

    class RecordedMachine(CoreMachine):
        def ring_size(self) -> int:
            return next(sizes)

        def teardown(self) -> None:
            super().teardown()
            recording = self.shell.ring.capture()
            if recording.start is not None:  # it was at rest, as it is at the end at the latest
                lines = to_lines(Dump(HEADER, recording))
                (folder / f"{next(numbers)}.dump").write_text("\n".join(lines))

    return RecordedMachine


@pytest.mark.timeout(600)
def test_a_thousand_streams_end_in_equal_states_when_replayed(tmp_path: Path) -> None:
    recorded = settings(max_examples=STREAMS, stateful_step_count=STEPS, deadline=None)
    run_state_machine_as_test(machine(tmp_path), settings=recorded)
    found = len(list(tmp_path.iterdir()))

    assert found >= STREAMS
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    done = subprocess.run(
        [sys.executable, "-c", REPLAY, tmp_path], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr[-3000:]
    steps = [int(line) for line in done.stdout.split()]
    assert len(steps) == found
    assert max(steps) > STEPS
