"""Dumps: every event survives its file, strangers' files do no harm, secrets stay out."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from fake_shell import FakeShell, facts, wire

from rtkit.deployment import actions as act
from rtkit.deployment.batch import Batch
from rtkit.deployment.facts import Followed
from rtkit.deployment.limits import Capacity
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import fields
from rtkit.manager.core import events as ev
from rtkit.manager.core.checkpoint import restored, take
from rtkit.manager.core.dump import HIDDEN, Dump, from_lines, from_plain, to_lines, to_plain
from rtkit.manager.core.event_ring import CORE, EventRing, Fault
from rtkit.manager.core.replay import Replay, described
from rtkit.rtc.enums import Transition
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile

BATCH = Batch(
    (
        act.Create("Thing?instance_name=A", ("x/A.rtc",), ComponentPattern(TypeProfile("T"))),
        act.Connect(wire("w", dataport__dataflow_type="push")),
        act.ChangeState("A", "0", Transition.ACTIVATE),
        act.SetPolicy("A", {"rtkit.restart": "always"}),
    ),
    False,
    3.0,
    "id",
)
MESSAGE = {"facts": facts("A"), "numbers": [1, 0.5, None, True, "ü\x00\ud800"]}
EVENTS: tuple[ev.Event, ...] = (
    ev.BatchRequested(BATCH, 7, 12.5),
    ev.SnapshotRequested(1),
    ev.ListenersChanged("tree", True, "S"),
    ev.FollowAsked("S", "{}", 2),
    ev.FollowSaid(Followed("S", "a", "b", "e", 1, 5.0), 3),
    ev.OperationRequested("fork", "s", 4),
    ev.PeerAsked("{}", 5, 1.5, "robot1/manager"),
    ev.PeerAnswered(6, "no", "refused"),
    ev.PeerFound("m1"),
    ev.PeerLost("m1", "it ended"),
    ev.StopRequested(True, True),
    ev.StoreRead([("component", "A", None), ("wire", "w", "{}")], "boot", "remark", "life"),
    ev.RecoveryRequested(5),
    ev.StartStepDone("manager.preload.modules: x"),
    ev.RowsStored(3, "full", True),
    ev.SlaveForked(1, 200),
    ev.SlaveFailed(1, "cannot fork"),
    ev.SpawnDisabled("full"),
    ev.SlaveReady(1),
    ev.SlaveFound(900, "s", [facts("A")], [], True, "stopped", {"A": {}}, {"op": "configure"}),
    ev.SlaveExitedUnseen(900, "s", [facts("A")], "signal 9", False, 1.5),
    ev.SlaveEnded(1, "signal 9", "last words", 1.5),
    ev.SlaveStopped(1, True),
    ev.SlaveOverLimit(1, "memory"),
    ev.CallbackStuck(1, "A", "stuck", True),
    ev.ProcessInspected(1),
    ev.DevicesSeen(("/dev/video0",)),
    ev.ContainerReported(1, MESSAGE),
    ev.TimerExpired(),
)


def through_a_file(value: object) -> Any:
    return from_plain(json.loads(json.dumps(to_plain(value))))


def test_there_is_a_sample_of_each_event() -> None:
    assert {type(event) for event in EVENTS} == set(ev.Event.__subclasses__())


@pytest.mark.parametrize("event", EVENTS, ids=lambda event: type(event).__name__)
def test_each_event_survives_a_file(event: ev.Event) -> None:
    assert through_a_file(event) == event
    for field in fields(event):
        assert getattr(event, field.name) != field.default, "the sample shows nothing of this field"


@pytest.mark.parametrize(
    "value",
    [
        Capacity(1.5, 2.0),
        Capacity(math.inf, 1.0),
        Fault("timer", "KeyError: 1", "Traceback"),
        {1: {"a"}, ("a", 2): ("b", (3,)), "~": {"~tuple": 1}},
        {"~tuple": [1]},
        set(),
        [[], {}, ()],
    ],
    ids=repr,
)
def test_values_of_all_kinds_survive_a_file(value: object) -> None:
    found = through_a_file(value)
    assert found == value
    assert type(found) is type(value)


def test_an_error_survives_a_file() -> None:
    found = through_a_file(NotFound("no such thing"))
    assert (type(found), str(found)) == (NotFound, "no such thing")


def test_what_is_neither_event_nor_state_is_not_written() -> None:
    with pytest.raises(TypeError, match="neither event nor state: function"):
        to_plain({"x": through_a_file})


@pytest.mark.parametrize(
    "told",
    [
        ev.OperationRequested("set_configuration", "net.password:hunter2", 1),
        ev.OperationRequested("create_component", "X?mqtt.token=hunter2&b=1", 1),
        ev.OperationRequested("create_component", "X?url=mqtt://me:hunter2@host/x", 1),
        ev.ContainerReported(1, {"values": {"the_secret": "hunter2", "plain": "1"}}),
        ev.ContainerReported(1, {"text": '{"password": "hunter2"}'}),
        ev.StoreRead([("setting", "x", '{"private_key":"hunter2"}')]),
    ],
    ids=str,
)
def test_what_is_named_like_a_secret_is_hidden(told: ev.Event) -> None:
    text = json.dumps(to_plain(told))
    assert "hunter2" not in text
    assert HIDDEN in text
    assert type(from_plain(json.loads(text))) is type(told)


# the ring


def recorded(count: int, ring_size: int = 100_000) -> FakeShell:
    shell = FakeShell(ring_size=ring_size)
    for number in range(count):
        shell.make(f"A{number}", "s")
    return shell


def test_a_ring_is_bounded_in_number_and_begins_at_rest() -> None:
    shell = recorded(60, ring_size=40)
    assert shell.ring is not None
    assert 20 <= shell.ring.size[0] <= 40
    recording = shell.ring.capture()
    assert recording.start is not None
    assert recording.lost + len(recording.items) == sum(1 for _ in all_events(60))


def all_events(count: int) -> Any:
    shell = recorded(count)
    assert shell.ring is not None
    return shell.ring.capture().items


def test_a_ring_is_bounded_in_bytes(shell: FakeShell) -> None:
    ring = EventRing(shell.core, most_bytes=100_000)
    for number in range(1000):
        event = ev.ContainerReported(0, {"reply": number, "value": "x" * 1000})
        ring.record(event, 0.0)
        shell.core.handle(event, 0.0)
        assert ring.size[1] <= 100_000
    assert ring.capture().start is not None


def test_one_event_that_is_too_large_is_kept_alone(shell: FakeShell) -> None:
    ring = EventRing(shell.core, most_bytes=1000)
    for _ in range(3):
        ring.record(ev.OperationRequested("x", "y" * 5000, 0), 0.0)
        assert ring.size[0] == 1


def test_what_was_never_at_rest_is_told_and_not_replayed() -> None:
    shell = FakeShell(ring_size=20)
    shell.ask(act.Create("Thing?instance_name=A&manager_name=s"))  # nobody forks it
    for _ in range(50):
        shell.feed(ev.TimerExpired())
    assert shell.ring is not None
    recording = shell.ring.capture()
    assert recording.start is None
    assert recording.lost
    with pytest.raises(Refused, match="not at rest"):
        Replay(recording)
    shell.fork("s")
    shell.serve()
    for _ in range(2):
        shell.feed(ev.TimerExpired())
    assert shell.ring.capture().start is not None


def test_what_is_recorded_does_not_change_with_what_was_handed_in() -> None:
    shell = FakeShell(ring_size=100)
    message: dict[str, Any] = {"reply": 1, "value": {"a": 1}}
    shell.feed(ev.ContainerReported(0, message))
    message["value"]["a"] = 2
    assert shell.ring is not None
    ((_, event),) = shell.ring.capture().items
    assert event == ev.ContainerReported(0, {"reply": 1, "value": {"a": 1}})


def test_the_capacity_of_the_host_is_recorded_with_the_event(shell: FakeShell) -> None:
    shell.state.capacity = lambda: Capacity(memory=1 << 30)
    shell.ring = EventRing(shell.core)
    limited = "Thing?instance_name={}&manager_name=s&rtkit.limit.memory=600M"
    shell.ask(act.Create(limited.format("A")))
    shell.fork("s")
    shell.serve()
    assert not shell.ask(act.Create(limited.format("B"))).result.ok
    replay = Replay(from_lines(to_lines(Dump({}, shell.ring.capture()))).recording)
    assert list(replay.steps())
    assert replay.differences == []


# replays


def test_a_checkpoint_shares_nothing_that_changes() -> None:
    shell = recorded(3)
    before = json.dumps(to_plain(take(shell.core)))
    checkpoint = take(shell.core)
    shell.end(shell.state.containers["A0"])
    shell.stop()
    assert json.dumps(to_plain(checkpoint)) == before
    assert json.dumps(to_plain(take(restored(from_plain(json.loads(before)))))) == before


def test_a_replay_that_goes_otherwise_says_where() -> None:
    shell = recorded(2)
    assert shell.ring is not None
    recording = shell.ring.capture()
    left_out = [each for each in recording.items if not isinstance(each[1], ev.SlaveReady)]
    replay = Replay(recording._replace(items=left_out))
    assert list(replay.steps())
    assert any("state.components" in each for each in replay.differences)


def test_a_fault_of_the_core_comes_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the loop records it: the event, then the fault that it led to."""

    def fail(*_arguments: object) -> None:
        raise KeyError("a bug")

    monkeypatch.setattr("rtkit.manager.core.core.Core._stuck", fail)
    shell = recorded(1)
    event = ev.CallbackStuck(1, "A0", "stuck")
    assert shell.ring is not None
    with pytest.raises(KeyError) as raised:
        shell.feed(event)
    shell.ring.note(Fault(CORE, described(raised.value)))
    shell.feed(ev.TimerExpired())
    dump = from_lines(to_lines(Dump({}, shell.ring.capture())))
    replay = Replay(dump.recording)
    (step,) = [step for step in replay.steps() if step.is_bug]
    assert (step.item, step.error) == (event, "KeyError: 'a bug'")
    assert replay.differences == []
    monkeypatch.undo()
    mended = Replay(dump.recording)
    assert not [step for step in mended.steps() if step.is_bug]
    assert "CallbackStuck: raises nothing, raised KeyError: 'a bug'" in mended.differences


# files of strangers


def lines(count: int = 1) -> list[str]:
    shell = recorded(count)
    assert shell.ring is not None
    return list(to_lines(Dump({"manager": "m", "rtkit": "9"}, shell.ring.capture())))


def with_line(number: int, text: str) -> list[str]:
    found = lines()
    found[number] = text
    return found


DEEP = "[" * 100_000 + "]" * 100_000
NESTED = "[" * 200 + "]" * 200


@pytest.mark.parametrize(
    ("found", "why"),
    [
        (["\x7fELF"], "line 1: not JSON"),
        ([], "it ends after line 0"),
        (["[]"], "line 1: not a JSON table"),
        (["{}"], "line 1: no header"),
        (['{"rtkit-dump":2,"rtkit":"9.9"}'], "form 2, of rtkit 9.9; this rtkit reads form 1"),
        (['{"rtkit-dump":1,"lost":0,"x":[]}'], "header of another kind"),
        (lines()[:-1], "not a whole dump"),
        (lines()[:2], "not a whole dump"),
        ([*lines(), lines()[-1]], "something follows the end"),
        (lines()[:1] + lines()[2:], "no such line is expected"),
        (with_line(2, '{"at":0,"item":'), "line 3: not JSON"),
        (with_line(2, '{"at":"x","item":1}'), "no time"),
        (with_line(2, '{"at":NaN,"item":1}'), "no time"),
        (with_line(2, '{"at":0,"item":{"~":"Popen","args":"x"}}'), "unknown class: 'Popen'"),
        (with_line(2, '{"at":0,"item":{"~":"SlaveReady"}}'), "SlaveReady"),
        (with_line(2, '{"at":0,"item":{"~":"SlaveReady","key":"x"}}'), "SlaveReady.key: not"),
        (with_line(2, '{"at":0,"item":{"~":"SlaveReady","key":true}}'), "SlaveReady.key: not"),
        (with_line(2, '{"at":0,"item":{"~":"SlaveReady","q":1}}'), "unknown field 'q'"),
        (with_line(2, '{"at":0,"item":{"~eval":"1"}}'), "unknown kind of value"),
        (with_line(2, '{"at":0,"item":{"~enum":"Transition.NO"}}'), "~enum"),
        (with_line(2, '{"at":0,"item":{"~set":[[]]}}'), "~set"),
        (with_line(2, '{"at":0,"item":' + NESTED + "}"), "more than 64"),
        (with_line(2, DEEP), "line 3: not JSON"),
        (with_line(1, '{"start":7}'), "it has no state"),
        (with_line(-1, '{"end":7}'), "it has no state"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_dump_is_refused(found: list[str], why: str) -> None:
    with pytest.raises(Malformed) as refused:
        from_lines(found)
    assert why in str(refused.value)


@pytest.mark.parametrize(
    ("part", "key", "value"),
    [
        ("core", "state", 1),
        ("_tasks", "_number", "x"),
        ("_tasks", "unheard_of", 1),
        ("_unheard_of", "x", 1),
    ],
)
def test_a_checkpoint_of_another_rtkit_is_refused(part: str, key: str, value: object) -> None:
    shell = recorded(1)
    checkpoint: Any = take(shell.core)
    checkpoint.setdefault(part, {})[key] = value
    with pytest.raises(Malformed, match="checkpoint"):
        restored(checkpoint)
