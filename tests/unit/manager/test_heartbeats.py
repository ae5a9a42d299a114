"""Heartbeats in shared memory, and the line of a stack that is told."""

from __future__ import annotations

import sys
import sysconfig
import threading
import time
from pathlib import Path

import pytest

from rtkit.component.contexts import callbacks
from rtkit.component.contexts.waiting import grant_by
from rtkit.component.ports.buffer import GuardedRing
from rtkit.component.ports.options import BufferOptions, EmptyPolicy, FullPolicy, PortStatus
from rtkit.container.heartbeats import CALLBACKS, HeartbeatReader, Heartbeats
from rtkit.container.stacks import is_in_debugger, place_of
from rtkit.manager.slaves.watchdog import DEADLINE_S, callback_deadline_s


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Heartbeats, HeartbeatReader]:
    path = str(tmp_path / "beats")
    heartbeats = Heartbeats(path)
    return heartbeats, HeartbeatReader(path)


@pytest.mark.parametrize("callback", CALLBACKS[1:])
def test_a_callback_is_seen_from_entry_to_exit(
    pair: tuple[Heartbeats, HeartbeatReader], callback: str
) -> None:
    heartbeats, reader = pair
    slot = heartbeats.slot()
    assert slot is not None
    before = time.monotonic_ns()
    slot.watch("Motor0", callback)
    (beat,) = reader.inside()
    assert (beat.instance, beat.callback) == ("Motor0", callback)
    assert before <= beat.since_ns <= time.monotonic_ns()
    assert beat.thread == threading.get_ident()
    slot.watch("", "")
    assert reader.inside() == []


def test_each_context_has_a_slot_of_its_own(pair: tuple[Heartbeats, HeartbeatReader]) -> None:
    heartbeats, reader = pair
    slots = [heartbeats.slot() for _ in range(3)]
    for number, slot in enumerate(slots):
        assert slot is not None
        slot.watch(f"C{number}", "on_execute")
    assert [beat.instance for beat in reader.inside()] == ["C0", "C1", "C2"]
    assert slots[1] is not None
    heartbeats.release(slots[1])
    assert [beat.instance for beat in reader.inside()] == ["C0", "C2"]
    again = heartbeats.slot()
    assert again is not None
    assert again.index == 1


def test_slots_come_to_an_end(pair: tuple[Heartbeats, HeartbeatReader]) -> None:
    heartbeats, _ = pair
    slots = [heartbeats.slot() for _ in range(1025)]
    assert slots[1023] is not None
    assert slots[1024] is None


def test_a_long_name_is_cut_and_disturbs_no_neighbour(
    pair: tuple[Heartbeats, HeartbeatReader],
) -> None:
    heartbeats, reader = pair
    first, second = heartbeats.slot(), heartbeats.slot()
    assert first is not None
    assert second is not None
    second.watch("B", "on_error")
    first.watch("ä" * 200, "on_execute")
    names = [beat.instance for beat in reader.inside()]
    assert names == ["ä" * 55, "B"]


def test_the_line_is_the_author_s_own() -> None:
    stacks = f'''Thread 0x{17:016x} (most recent call first):
  File "{sysconfig.get_path("stdlib")}/re/__init__.py", line 166 in match
  File "/home/me/Arm.py", line 21 in grasp
  File "/home/me/Arm.py", line 9 in on_execute

Current thread 0x{18:016x} (most recent call first):
  File "/home/me/Leg.py", line 3 in on_execute
'''
    assert place_of(stacks, 17) == "Arm.py:21 in grasp"
    assert place_of(stacks, 18) == "Leg.py:3 in on_execute"
    assert place_of(stacks, 19) == ""


def test_without_a_line_of_the_author_the_innermost_is_told() -> None:
    import selectors

    stacks = f'Thread 0x{1:016x}\n  File "{selectors.__file__}", line 5 in select\n'
    assert place_of(stacks, 1) == "selectors.py:5 in select"
    assert sys.modules["selectors"] is selectors


CALLBACK = f'''  File "/home/me/Arm.py", line 12 in on_execute
  File "{callbacks.__file__}", line 5 in attempt
'''


@pytest.mark.parametrize(
    ("frames", "is_so"),
    [
        ('  File "/py/pdb.py", line 3 in interaction\n' + CALLBACK, True),
        ('  File "/x/pydevd/pydevd.py", line 9 in do_wait_suspend\n' + CALLBACK, True),
        (CALLBACK, False),
        (CALLBACK + '  File "/py/bdb.py", line 3 in run\n', False),
    ],
)
def test_a_debugger_that_has_stopped_a_callback_is_seen_not_one_that_runs_it(
    frames: str, is_so: bool
) -> None:
    stacks = f"Thread 0x{17:016x} (most recent call first):\n{frames}\n"
    assert is_in_debugger(stacks, 17) is is_so
    assert not is_in_debugger(stacks, 18)


@pytest.mark.parametrize(
    ("create", "deadline_s"),
    [
        ("Arm", DEADLINE_S),
        ("Arm?exec_cxt.callback_deadline=0.2", 0.2),
        ("Arm?exec_cxt.callback_deadline=soon", DEADLINE_S),
        ("Arm?exec_cxt.callback_deadline=-1", DEADLINE_S),
        ("Arm?rtkit.health.stuck=restart", DEADLINE_S),
        ("Arm?rtkit.health.stuck=restart&exec_cxt.callback_deadline=0.3", 0.3),
        ("Arm?rtkit.health.stuck=0.2:restart&exec_cxt.callback_deadline=0.3", 0.2),
    ],
)
def test_the_deadline_is_an_option(create: str, deadline_s: float) -> None:
    assert callback_deadline_s(create) == deadline_s


@pytest.mark.parametrize("is_reader", [True, False])
def test_a_wait_that_a_connector_allows_does_not_make_a_callback_late(
    pair: tuple[Heartbeats, HeartbeatReader], monkeypatch: pytest.MonkeyPatch, is_reader: bool
) -> None:
    heartbeats, reader = pair
    slot = heartbeats.slot()
    assert slot is not None
    ring = GuardedRing[int](BufferOptions(2, FullPolicy.BLOCK, 3.0, EmptyPolicy.BLOCK, 2.0))
    entered: list[int] = []

    def wait_for(_: object, bound_s: float) -> bool:
        entered.append(reader.inside()[0].since_ns)
        assert entered[1] - entered[0] == pytest.approx(bound_s * 1e9)
        return False

    monkeypatch.setattr(ring._changed, "wait_for", wait_for)
    grant_by(slot.grant)
    try:
        slot.watch("A", "on_execute")
        entered.append(reader.inside()[0].since_ns)
        if is_reader:
            assert ring.wait() is None
        else:
            assert [ring.write(each) for each in range(3)][-1] is PortStatus.TIMEOUT
    finally:
        grant_by(None)
    (beat,) = reader.inside()  # from now on it counts again
    assert entered[0] <= beat.since_ns <= time.monotonic_ns()
    slot.watch("", "")
    slot.grant(1)
    assert reader.inside() == []
