"""Schedules procedures: resumes each when its effect is complete or its time is up.

A procedure that is ready to go on is queued, never resumed from inside another one, so that a
batch of any length needs no stack. Time comes in as an argument.
"""

from __future__ import annotations

import heapq
import json
import logging
import math
import signal
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from rtkit.deployment.actions import Result
from rtkit.deployment.message import Message, message_from
from rtkit.errors import RtkitError, Unreachable, from_kind
from rtkit.fast_dataclass import dataclass
from rtkit.manager.core import effects as fx
from rtkit.manager.core import events as ev
from rtkit.manager.core.state import ManagerState, Process
from rtkit.rtc.create import FRESH_SLAVE
from rtkit.rtc.enums import ReturnCode

Done = Callable[[Result], None]
_log = logging.getLogger(__name__)
_SPARE_DEADLINES = 64
_INSPECTION_S = 0.15
"""How long it may take to find out what holds up an answer that is late [s]."""


@dataclass(slots=True, eq=False)
class _Task:
    """A procedure under way.

    Attributes:
        done: Receives the outcome; None when nobody waits for it.
        until: When its time is up, but for waits of a time of their own; monotonic [s].
        wait: Event that it waits for at present.
        since: When it began to wait, monotonic [s].
        key: Of the process that it waits for.
        is_late: Its time is up; what it waits for is being inspected.
        reported: The failure in a container's answer, and the error that stands for it.
    """

    steps: fx.Procedure
    timeout_s: float
    done: Done | None = None
    until: float | None = None
    wait: fx.Wait | None = None
    since: float = 0.0
    key: int = -1
    is_late: bool = False
    reported: tuple[RtkitError, Result] | None = None


class _Step(NamedTuple):
    """A task that can go on, with the value or the error that it waited for."""

    task: _Task
    value: Any = None
    error: RtkitError | None = None


class Tasks:
    """Procedures under way; `out` collects instructions for the shell."""

    def __init__(self, state: ManagerState, out: list[ev.Instruction]) -> None:
        self._state = state
        self._out = out
        self._now = 0.0
        self._number = 0
        self._key = ev.OWN_PROCESS
        self._ready: deque[_Step] = deque()
        self._waiting: dict[int, _Task] = {}
        self._conditions: dict[int, None] = {}
        self._deadlines: list[tuple[float, int]] = []

    @property
    def is_idle(self) -> bool:
        """Return whether no procedure is under way."""
        return not self._waiting and not self._ready

    def begin(self, steps: fx.Procedure, timeout_s: float, done: Done | None = None) -> None:
        """Take a procedure in; `done` receives its outcome.

        All that it waits for together, but for what names a time of its own, takes at most
        `timeout_s` [s].
        """
        self._ready.append(_Step(_Task(steps, timeout_s, done)))

    def run(self, now: float) -> None:
        """Go on with all that can, at monotonic time `now` [s]."""
        self._now = now
        while True:
            while self._ready:
                self._resume(self._ready.popleft())
            if not (self._go_on_with_what_is_so() or self._expire()):
                break
        self._prune()
        if self._deadlines and self._deadlines[0][0] < math.inf:
            self._out.append(ev.WakeAt(self._deadlines[0][0]))

    def run_new(self, now: float) -> None:
        """Go on with what was begun since `run`, if there is any."""
        if self._ready:
            self.run(now)

    def new_process(self, name: str, pid: int = 0, *, trial_of: str = "") -> Process:
        """Enter another slave into the state, under a key that was never used."""
        self._key += 1
        process = Process(self._key, name, pid, trial_of=trial_of)
        self._state.processes[process.key] = process
        return process

    def take_answer(self, key: int, message: Message) -> None:
        """Take the answer of a container; one that nobody waits for any more is ignored."""
        number = message["reply"]
        task = self._waiting.get(number) if isinstance(number, int) else None
        if task is None or task.key != key or not isinstance(task.wait, fx.Call):
            return
        result = _result(message)
        if result.ok:
            self._go_on(number, message.get("value", ""))
        else:
            error = from_kind(result.kind, result.why)
            task.reported = (error, result)
            self._go_on(number, None, error)

    def process_is_up(self, process: Process) -> None:
        """Go on with those who need this slave."""
        key = process.key
        self._end_waits(lambda t: t.key == key and isinstance(t.wait, fx.AcquireSlave), process)

    def inspected(self, key: int) -> None:
        """Give up what is late at a process: it is known what is stuck in it."""
        for number, task in self._waiting_for(key):
            if task.is_late:
                self._go_on(number, None, self._late(task))

    def process_ended(self, process: Process) -> None:
        """Notify the tasks that wait for this slave that it ended."""
        self.give_up_on(process, Unreachable(process.end))
        self._end_waits(lambda t: isinstance(t.wait, fx.WaitForEnds) and _have_ended(t.wait))

    def give_up_on(self, process: Process, error: RtkitError) -> None:
        """Raise an error in every procedure that waits for this slave, whatever it waits for."""
        self._end_waits(lambda t: t.key == process.key, None, error)

    def peer_answered(self, event: ev.PeerAnswered) -> None:
        """Take the answer of another manager; one that nobody waits for any more is ignored."""
        task = self._waiting.get(event.number)
        if task is None or not isinstance(task.wait, fx.CallPeer):
            return
        try:
            if event.error:
                raise from_kind(event.error, event.text)
            self._go_on(event.number, message_from(event.text))
        except RtkitError as error:
            self._go_on(event.number, None, error)

    def peers_asked(self) -> set[str]:
        """Return the managers that are just asked something."""
        waits = (task.wait for task in self._waiting.values())
        return {wait.peer for wait in waits if isinstance(wait, fx.CallPeer)}

    def peer_lost(self, peer: str, error: RtkitError) -> None:
        """Raise an error in every procedure that waits for another manager."""
        self._end_waits(
            lambda t: isinstance(t.wait, fx.CallPeer) and t.wait.peer == peer, None, error
        )

    def cancel(self, error: RtkitError) -> None:
        """Raise an error in every procedure whose outcome somebody waits for."""
        self._end_waits(lambda t: t.done is not None, None, error)

    def give_up(self, error: RtkitError, key: int | None = None) -> None:
        """Raise an error in every procedure that waits for an answer, of one process or of any."""
        self._end_waits(lambda t: isinstance(t.wait, fx.Call) and key in (None, t.key), None, error)

    def _end_waits(
        self, is_meant: Callable[[_Task], bool], value: Any = None, error: RtkitError | None = None
    ) -> None:
        for number in [number for number, task in self._waiting.items() if is_meant(task)]:
            self._go_on(number, value, error)

    def _waiting_for(self, key: int) -> list[tuple[int, _Task]]:
        return [(number, task) for number, task in self._waiting.items() if task.key == key]

    def _go_on(self, number: int, value: Any, error: RtkitError | None = None) -> None:
        task = self._waiting.pop(number)
        task.wait, task.key, task.is_late = None, -1, False
        self._ready.append(_Step(task, value, error))

    def _resume(self, step: _Step) -> None:
        task, value, error = step
        while True:
            effect = _advance(task, value, error)
            value, error = None, None
            match effect:
                case None:
                    return
                case fx.ReadClock():
                    value = self._now
                case fx.Spawn(procedure):
                    self._resume(_Step(_Task(procedure, task.timeout_s)))
                case fx.SendSignal(process, number):
                    self._out.append(ev.SignalSlave(process.key, number))
                case fx.Send(process, message):
                    self._out.append(ev.SendToContainer(process.key, message))
                case fx.Call(process):
                    if not process.unfit:
                        self._ask(task, effect)
                        return
                    error = Unreachable(process.unfit)
                case fx.CallPeer():
                    self._ask_peer(task, effect)
                    return
                case fx.AcquireSlave():
                    slave = self._needed(effect)
                    if slave is None:
                        error = Unreachable(f"no slave can be started: {self._state.barred}")
                    elif slave.state == "starting":
                        self._wait(task, effect, slave.key)
                        return
                    value = slave
                case fx.Sleep(time_s):
                    self._wait(task, effect, -1, time_s)
                    return
                case fx.WaitForEnds():
                    if not _have_ended(effect):
                        self._wait(task, effect, -1, effect.timeout_s)
                        return
                case fx.WaitUntil(is_so):
                    if not is_so():
                        self._conditions[self._wait(task, effect, -1)] = None
                        return
                case fx.Gather():
                    self._side_by_side(task, effect)
                    return

    def _wait(self, task: _Task, wait: fx.Wait, key: int, timeout_s: float | None = None) -> int:
        """Have a task wait for so long, or until its own time is up."""
        self._number += 1
        number = self._number
        task.wait, task.key, task.since = wait, key, self._now
        self._waiting[number] = task
        if task.until is None:
            task.until = self._now + task.timeout_s
        until = task.until if timeout_s is None else self._now + timeout_s
        heapq.heappush(self._deadlines, (until, number))
        return number

    def _ask(self, task: _Task, ask: fx.Call) -> None:
        key = ask.process.key
        number = self._wait(task, ask, key, ask.timeout_s or None)
        message = {**ask.message, "call": number}
        if not ask.is_lasting:
            message["until"] = task.until if not ask.timeout_s else self._now + ask.timeout_s
        self._out.append(ev.SendToContainer(key, message))

    def _ask_peer(self, task: _Task, ask: fx.CallPeer) -> None:
        number = self._wait(task, ask, -1, ask.timeout_s or None)
        assert task.until is not None
        left_s = ask.timeout_s or task.until - self._now
        text = json.dumps(ask.message, separators=(",", ":"))
        self._out.append(ev.AskPeer(number, ask.peer, text, left_s))

    def _side_by_side(self, task: _Task, effect: fx.Gather) -> None:
        """Begin procedures, and go on with the task when each has ended; each has its time-out."""
        results: list[Result | None] = [None] * len(effect.procedures)
        left = len(results)
        if not left:
            self._ready.append(_Step(task, []))
            return
        number = self._wait(task, effect, -1, math.inf)

        def done(index: int, result: Result) -> None:
            nonlocal left
            results[index] = result
            left -= 1
            if not left and number in self._waiting:
                self._go_on(number, results)

        for index, steps in enumerate(effect.procedures):
            self.begin(steps, task.timeout_s, partial(done, index))

    def _needed(self, need: fx.AcquireSlave) -> Process | None:
        """Return a slave that lives, or is started now; None when none can be."""
        name = need.name
        is_fresh = bool(need.trial_of) or name == FRESH_SLAVE
        process = None if is_fresh else self._state.living_process(name)
        if process is None and not self._state.barred:
            process = self.new_process(name, trial_of=need.trial_of)
            self._out.append(ev.SpawnSlave(process.key, name, tuple(sorted(self._state.ahead))))
        return process

    def _go_on_with_what_is_so(self) -> bool:
        """End the waits for what others have brought about; return whether there were any."""
        for number in list(self._conditions):
            task = self._waiting.get(number)
            if task is None:
                del self._conditions[number]
            elif isinstance(task.wait, fx.WaitUntil) and task.wait.is_so():
                self._go_on(number, None)
                return True  # one at a time: what it does may undo what the next one waits for
        return False

    def _expire(self) -> bool:
        """End the waits whose time is up; return whether there were any."""
        while self._deadlines and self._deadlines[0][0] <= self._now:
            _, number = heapq.heappop(self._deadlines)
            task = self._waiting.get(number)
            if task is None:
                continue
            if isinstance(task.wait, fx.Call) and not task.is_late:
                self._inspect(number, task)
            else:
                is_late = not isinstance(task.wait, fx.Sleep)
                self._go_on(number, None, self._late(task) if is_late else None)
        return bool(self._ready)

    def _inspect(self, number: int, task: _Task) -> None:
        """Find out what holds up an answer before it is given up; it may still come meanwhile."""
        task.is_late = True
        waited_s = self._now - task.since
        self._out.append(ev.InspectProcess(task.key, waited_s / 2))
        heapq.heappush(self._deadlines, (self._now + _INSPECTION_S, number))

    def _late(self, task: _Task) -> Unreachable:
        if isinstance(task.wait, fx.WaitUntil):
            return Unreachable(task.wait.why)
        if isinstance(task.wait, fx.CallPeer):
            return Unreachable(f"manager {task.wait.peer} does not answer")
        key = task.key
        process = self._state.processes.get(key)
        if process is None:
            return Unreachable("time is up")
        if process.unfit:
            return Unreachable(process.unfit)
        if process.state != "starting":
            reasons = process.stuck or self._state.waits_in(key)
            stuck = "; ".join(f"{name} is {text}" for name, text in reasons.items())
            return Unreachable(
                f"no answer from {process.name} in time" + (f": {stuck}" if stuck else "")
            )
        if len(self._waiting_for(key)) == 1:
            process.is_wanted = False
            self._out.append(ev.SignalSlave(key, signal.SIGKILL))
        barred = f": {self._state.barred}" if self._state.barred else ""
        return Unreachable(f"slave {process.name} did not start in time{barred}")

    def _prune(self) -> None:
        """Drop deadlines of waits that are over, so that long ones do not pile up."""
        while self._deadlines and self._deadlines[0][1] not in self._waiting:
            heapq.heappop(self._deadlines)
        if len(self._deadlines) > _SPARE_DEADLINES + 2 * len(self._waiting):
            self._deadlines = [each for each in self._deadlines if each[1] in self._waiting]
            heapq.heapify(self._deadlines)


def ignored(_result: Result) -> None:
    """Take an outcome that nobody waits for: the procedure is broken off when the manager stops."""


def failed(error: RtkitError) -> Result:
    """Return the result that stands for an error."""
    is_bad = isinstance(error, (ValueError, LookupError))
    code = ReturnCode.BAD_PARAMETER if is_bad else ReturnCode.ERROR
    return Result(code, error.kind, str(error))


def _result(message: Message) -> Result:
    """Return the result in a container's answer."""
    try:
        code = ReturnCode(message.get("code", ReturnCode.OK.value))
    except ValueError:
        code = ReturnCode.ERROR
    return Result(code, str(message.get("kind", "")), str(message.get("why", "")))


def _advance(task: _Task, value: Any, error: RtkitError | None) -> fx.Effect | None:
    """Resume a procedure; return its next effect, None when it is over."""
    try:
        return task.steps.throw(error) if error else task.steps.send(value)
    except StopIteration as stop:
        result: Result = stop.value
    except RtkitError as failure:
        reported = task.reported
        result = reported[1] if reported is not None and reported[0] is failure else failed(failure)
    except Exception as bug:
        _log.exception("a procedure failed")
        result = failed(RtkitError(f"{type(bug).__name__}: {bug}"))
    if task.done is not None:
        task.done(result)
    return None


def _have_ended(wait: fx.WaitForEnds) -> bool:
    return not any(process.is_alive for process in wait.slaves)
