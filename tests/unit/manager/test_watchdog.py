"""What is stuck is told once, with its line, until it is over; and sooner when somebody asks."""

from __future__ import annotations

import os
import re
import threading
import time
from pathlib import Path

import pytest

from rtkit.container.heartbeats import STACKS_AT, Heartbeats, guest_pattern, heartbeats_path
from rtkit.container.stacks import open_stacks, write_stacks
from rtkit.manager.core.events import CallbackStuck, ProcessInspected
from rtkit.manager.slaves.watchdog import POLL_S, Watchdog, remove_traces

KEY = 7


class Watched:
    """This process as one that is watched; its deadline is `deadline_s`."""

    def __init__(self, folder: Path, *, is_guest: bool = False) -> None:
        of_slaves = str(folder / "m.%p.data")
        pattern = guest_pattern(of_slaves) if is_guest else of_slaves
        heartbeats = Heartbeats(heartbeats_path(pattern, os.getpid()))
        slot = heartbeats.slot()
        assert slot is not None
        self.slot = slot
        self.deadline_s = 1000.0
        self.answers = {False, True}
        self.asked = []
        self._stacks = open_stacks(pattern, os.getpid())
        self.file = Path(heartbeats_path(pattern, os.getpid()))
        self.shortest_s = 0.0
        self.watchdog = Watchdog(
            of_slaves, lambda _instance: self.deadline_s, lambda: self.shortest_s, self._dump
        )
        self.watchdog.watch(KEY, os.getpid(), is_guest=is_guest)

    def _dump(self, _key: int, is_urgent: bool) -> None:
        self.asked.append(is_urgent)
        if is_urgent in self.answers:
            write_stacks(self._stacks)

    def close(self) -> None:
        self.watchdog.forget(KEY)
        os.close(self._stacks)

    def poll(self) -> list[object]:
        time.sleep(max(0.0, self.wait_s))
        return list(self.watchdog.poll())

    @property
    def wait_s(self) -> float:
        return self.watchdog.look_at - time.monotonic()

    def inspect(self, age_s: float) -> list[object]:
        return list(self.watchdog.inspect(KEY, age_s))


@pytest.fixture
def watched(tmp_path):
    watched = Watched(tmp_path)
    yield watched
    watched.close()


def text(told):
    (event,) = told
    assert isinstance(event, CallbackStuck)
    assert (event.key, event.instance) == (KEY, "A")
    return re.sub(r"[\d:]{8}", "NOW", re.sub(r"\(.*\)", "(PLACE)", event.text))


def test_what_takes_too_long_is_told_then_its_line_then_its_end(watched):
    assert watched.poll() == []
    watched.slot.watch("A", "on_execute")
    assert watched.poll() == []
    watched.deadline_s = 0.0
    assert text(watched.poll()) == "stuck in on_execute since NOW"
    assert text(watched.poll()) == "stuck in on_execute since NOW (PLACE)"
    assert watched.poll() == []
    watched.slot.watch("", "")
    assert watched.poll() == [CallbackStuck(KEY, "A", "")]
    assert watched.poll() == []


def test_of_an_attached_process_nothing_is_told_before_its_stack(tmp_path):
    watched = Watched(tmp_path, is_guest=True)
    watched.deadline_s = 0.0
    watched.slot.watch("A", "on_execute")
    assert watched.poll() == []
    assert text(watched.poll()) == "stuck in on_execute since NOW (PLACE)"
    watched.close()
    remove_traces(str(tmp_path / "m.%p.data"), os.getpid())
    assert list(tmp_path.iterdir()) == []


def test_the_same_callback_of_a_later_cycle_is_told_anew(watched):
    watched.deadline_s = 0.0
    watched.slot.watch("A", "on_execute")
    watched.poll()
    watched.poll()
    watched.slot.watch("A", "on_execute")
    assert text(watched.poll()) == "stuck in on_execute since NOW"


def test_who_asks_is_told_before_the_deadline_and_that_it_is_all(watched):
    watched.slot.watch("A", "creation")
    time.sleep(0.002)
    assert text(watched.inspect(0.001)) == "stuck in creation since NOW"
    *lines, last = watched.poll()
    assert text(lines) == "stuck in creation since NOW (PLACE)"
    assert last == ProcessInspected(KEY)
    assert watched.poll() == []  # it stays said, though its deadline is not over
    watched.slot.watch("", "")
    assert watched.poll() == [CallbackStuck(KEY, "A", "")]


def test_who_asks_when_nothing_takes_long_is_told_so_at_once(watched):
    watched.slot.watch("A", "on_execute")
    assert watched.inspect(1000.0) == [ProcessInspected(KEY)]
    assert watched.poll() == []


def test_a_process_without_heartbeats_is_known_to_tell_nothing(watched):
    assert list(watched.watchdog.inspect(8, 0.0)) == [ProcessInspected(8)]


def test_a_process_that_writes_no_stack_is_not_waited_for_without_end(watched):
    watched.answers = set()
    watched.slot.watch("A", "on_execute")
    time.sleep(0.002)
    watched.inspect(0.001)
    polls = 0
    while not (told := watched.poll()):
        polls += 1
        assert polls < 100
    assert text(told[:1]) == "stuck in on_execute since NOW"
    assert told[1:] == [ProcessInspected(KEY)]
    assert watched.asked == [False, True]


def test_who_answers_is_sent_no_signal_who_does_not_is(watched):
    for answers, asked in (({False, True}, [False]), ({True}, [False, True])):
        watched.answers, watched.asked = answers, []
        watched.slot.watch("A", "on_execute")
        time.sleep(0.002)
        told = watched.inspect(0.001)
        while ProcessInspected(KEY) not in told:
            told += watched.poll()
        assert "(test_watchdog.py:" in told[-2].text
        assert watched.asked == asked
        watched.slot.watch("", "")
        watched.poll()


def test_the_file_of_stacks_does_not_grow(watched):
    watched.deadline_s = 0.0
    sizes = set()
    for _ in range(5):
        watched.slot.watch("A", "on_execute")
        watched.poll()
        watched.poll()
        sizes.add(watched.file.stat().st_size - STACKS_AT)
    assert max(sizes) < 2 * min(sizes)


def test_the_line_is_that_of_the_thread_that_is_stuck(watched):
    gate = threading.Event()

    def run():
        watched.slot.watch("A", "on_execute")
        begun.set()
        gate.wait()

    begun = threading.Event()
    thread = threading.Thread(target=run)
    thread.start()
    begun.wait()
    watched.deadline_s = 0.0
    watched.poll()
    (event,) = watched.poll()
    gate.set()
    thread.join()
    assert f"({Path(__file__).name}:" in event.text
    assert event.text.endswith(" in run)")


def test_what_rests_is_looked_at_when_something_could_be_late(watched):
    watched.shortest_s = 100.0
    watched.poll()
    assert 90.0 < watched.wait_s <= 100.0
    watched.watchdog.hasten(KEY)
    assert 0.0 < watched.wait_s <= POLL_S


def test_what_runs_is_looked_at_when_it_would_be_late(watched):
    watched.shortest_s = 1000.0
    watched.deadline_s = 100.0
    watched.slot.watch("A", "on_execute")
    assert watched.poll() == []
    assert 90.0 < watched.wait_s <= 100.0


def test_what_is_stuck_is_looked_at_often(watched):
    watched.shortest_s = 1000.0
    watched.deadline_s = 0.0
    watched.slot.watch("A", "on_execute")
    for _ in range(3):
        watched.poll()
        assert watched.wait_s <= POLL_S


def test_a_look_that_is_not_due_reads_nothing(watched):
    watched.shortest_s = 1000.0
    watched.poll()
    watched.deadline_s = 0.0
    watched.slot.watch("A", "on_execute")
    assert list(watched.watchdog.poll()) == []


def test_what_was_stopped_counts_from_when_it_goes_on(watched):
    watched.deadline_s = 0.05
    watched.watchdog.halted(KEY, is_halted=True)
    watched.slot.watch("A", "on_execute")
    time.sleep(2 * watched.deadline_s)
    assert list(watched.watchdog.poll()) == []
    watched.deadline_s = 1000.0
    watched.watchdog.halted(KEY, is_halted=False)
    assert list(watched.watchdog.poll()) == []
    watched.deadline_s = 0.05
    watched.watchdog.hasten(KEY)
    time.sleep(2 * watched.deadline_s)
    assert [each.instance for each in watched.watchdog.poll() if each.text] == ["A"]
