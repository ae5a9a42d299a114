"""The daemon's core: events in, instructions out; the only place where its state changes.

Each action of a client runs as a *procedure*, a generator that yields what it waits for (see
`rtkit.manager.procedures`). The core resumes it when the answer arrives, the process dies, or the
time is up. No thread, socket or clock is known here: time comes in as an argument.
"""

from __future__ import annotations

import heapq
import itertools
import signal
from collections.abc import Generator
from dataclasses import dataclass, field
from typing import Any

from rtkit.deployment.actions import Result
from rtkit.deployment.batch import results_to_text
from rtkit.errors import RtkitError, Unreachable
from rtkit.manager import facts_in
from rtkit.manager.events import (
    OWN_PROCESS,
    AnswerClient,
    BatchAsked,
    Event,
    Finish,
    HolderSaid,
    Instruction,
    Message,
    SendToHolder,
    SignalSlave,
    SlaveEnded,
    SlaveFailed,
    SlaveForked,
    SlaveHalted,
    SlaveReady,
    SpawnSlave,
    StopAsked,
    Tick,
    WakeAt,
)
from rtkit.manager.procedures import (
    Ask,
    Later,
    Need,
    Procedure,
    Signal,
    Tell,
    UntilEnded,
    procedure_for,
)
from rtkit.manager.state import Process, State
from rtkit.manager.stopping import stop_everything
from rtkit.property.exchange import Reply
from rtkit.rtc.create import FRESH_SLAVE
from rtkit.rtc.enums import ReturnCode


@dataclass(slots=True)
class _Job:
    """A batch under way."""

    asked: BatchAsked
    results: list[Result | None]
    pending: int


@dataclass(slots=True, eq=False)
class _Task:
    """A procedure under way; `number` tells which of its waits is the present one."""

    steps: Generator[Any, Any, Result]
    job: _Job | None = None
    index: int = 0
    timeout_s: float = 10.0
    number: int = 0
    key: int = -1


@dataclass(slots=True)
class Core:
    """A manager without its shell."""

    state: State
    _out: list[Instruction] = field(default_factory=list)
    _now: float = 0.0
    _numbers: Any = field(default_factory=lambda: itertools.count(1))
    _keys: Any = field(default_factory=lambda: itertools.count(OWN_PROCESS + 1))
    _asked: dict[int, _Task] = field(default_factory=dict)
    _waiting: list[_Task] = field(default_factory=list)
    _deadlines: list[tuple[float, int, _Task]] = field(default_factory=list)
    _is_stopping: bool = False

    def handle(self, event: Event, now: float) -> list[Instruction]:
        """Take one event at monotonic time `now` [s] and return what is to be done."""
        self._now = now
        match event:
            case BatchAsked():
                self._begin(event)
            case HolderSaid(key, message):
                self._heard(key, message)
            case SlaveForked(key, pid):
                self._forked(key, pid)
            case SlaveReady(key):
                self._ready(key)
            case SlaveEnded(key, reason) | SlaveFailed(key, reason):
                self._ended(key, reason)
            case SlaveHalted(key, is_halted):
                self._halted(key, is_halted)
            case StopAsked():
                self._stop()
            case Tick():
                pass
        self._expire()
        out, self._out = self._out, []
        return out

    # batches

    def _begin(self, asked: BatchAsked) -> None:
        count = len(asked.batch.actions)
        job = _Job(asked, [None] * count, count)
        if self._is_stopping:
            refusal = Reply("the manager is stopping", "refused")
            self._out.append(AnswerClient(asked.answer, refusal))
        elif not count:
            self._finish(job)
        elif asked.batch.is_ordered:
            self._start(job, 0)
        else:
            for index in range(count):
                self._start(job, index)

    def _start(self, job: _Job, index: int) -> None:
        batch = job.asked.batch
        steps = procedure_for(batch.actions[index], self.state)
        self._resume(_Task(steps, job, index, batch.timeout_s), None)

    def _done(self, task: _Task, result: Result) -> None:
        job = task.job
        if job is None:
            return
        job.results[task.index] = result
        job.pending -= 1
        if job.asked.batch.is_ordered and result.ok and job.pending:
            self._start(job, task.index + 1)
        elif not job.pending or job.asked.batch.is_ordered:
            self._finish(job)

    def _finish(self, job: _Job) -> None:
        results = [result for result in job.results if result is not None]
        self._out.append(AnswerClient(job.asked.answer, Reply(results_to_text(results))))

    # procedures

    def _resume(self, task: _Task, value: Any, error: RtkitError | None = None) -> None:
        task.number = next(self._numbers)
        task.key = -1
        while True:
            try:
                wish = task.steps.throw(error) if error else task.steps.send(value)
            except StopIteration as stop:
                self._done(task, stop.value)
                return
            except RtkitError as failure:
                self._done(task, failed(failure))
                return
            value, error = None, None
            match wish:
                case Signal(process, number):
                    self._out.append(SignalSlave(process.key, number))
                case Tell(process, message):
                    self._out.append(SendToHolder(process.key, message))
                case Later(procedure):
                    self._resume(_Task(procedure), None)
                case Need(name):
                    value = self._needed(task, name)
                    if value is None:
                        return
                case Ask(process, message, timeout_s):
                    error = _unfit(process)
                    if error is None:
                        self._ask(task, process, message, timeout_s or task.timeout_s)
                        return
                case UntilEnded(timeout_s):
                    self._wait(task, timeout_s)
                    return

    def _ask(self, task: _Task, process: Process, message: Message, timeout_s: float) -> None:
        task.key = process.key
        self._asked[task.number] = task
        self._out.append(SendToHolder(process.key, {**message, "call": task.number}))
        self._expire_at(task, timeout_s)

    def _wait(self, task: _Task, timeout_s: float) -> None:
        self._waiting.append(task)
        self._expire_at(task, timeout_s)

    def _needed(self, task: _Task, name: str) -> Process | None:
        process = self.state.living_process(name) if name != FRESH_SLAVE else None
        if process is None:
            process = Process(next(self._keys), name)
            self.state.processes[process.key] = process
            self._out.append(SpawnSlave(process.key, name))
        if process.state != "starting":
            return process
        task.key = process.key
        self._wait(task, task.timeout_s)
        return None

    def _expire_at(self, task: _Task, timeout_s: float) -> None:
        deadline = self._now + timeout_s
        heapq.heappush(self._deadlines, (deadline, task.number, task))
        if self._deadlines[0][1] == task.number:
            self._out.append(WakeAt(deadline))

    def _expire(self) -> None:
        while self._deadlines and self._deadlines[0][0] <= self._now:
            _, number, task = heapq.heappop(self._deadlines)
            if task.number == number:
                self._drop(task)
                self._resume(task, None, self._late(task.key))
        if self._deadlines:
            self._out.append(WakeAt(self._deadlines[0][0]))

    def _drop(self, task: _Task) -> None:
        self._asked.pop(task.number, None)
        if task in self._waiting:
            self._waiting.remove(task)

    def _late(self, key: int) -> Unreachable:
        process = self.state.processes.get(key)
        if process is None:
            return Unreachable("time is up")
        if process.state == "starting":
            process.is_wanted = False
            self._out.append(SignalSlave(key, signal.SIGKILL))
            return Unreachable(f"slave {process.name} did not start in time")
        return Unreachable(f"no answer from {process.name} in time")

    # what processes report

    def _heard(self, key: int, message: Message) -> None:
        if "reply" not in message:
            facts_in.take(self.state, key, message)
            return
        task = self._asked.pop(message["reply"], None)
        if task is None or task.key != key:
            return
        result = facts_in.result(message)
        if result.ok:
            self._resume(task, message.get("value", ""))
        else:
            self._resume(task, None, facts_in.error(result))

    def _forked(self, key: int, pid: int) -> None:
        process = self.state.processes.get(key)
        if process is not None:
            process.pid = pid
            process.name = process.name.replace("%p", str(pid))

    def _ready(self, key: int) -> None:
        process = self.state.processes.get(key)
        if process is None or not process.is_alive:
            return
        process.state = "up"
        self._wake(key, process)

    def _ended(self, key: int, reason: str) -> None:
        process = self.state.processes.get(key)
        if process is None:
            return
        process.state, process.reason = "lost", reason
        self._bury(process)
        self.state.drop_if_empty(key)
        error = Unreachable(f"slave {process.name} ended: {reason}")
        for task in [t for t in self._asked.values() if t.key == key]:
            self._drop(task)
            self._resume(task, None, error)
        for task in [t for t in self._waiting if t.key == key]:
            self._drop(task)
            self._resume(task, None, error)
        self._wake(-1, None)

    def _bury(self, process: Process) -> None:
        for instance in self.state.held_by(process.key):
            if not process.is_wanted:
                self.state.forget(instance)
                continue
            self.state.update(instance, zombie=process.reason, trouble="")
            for wire in self.state.connectors_of(instance):
                self._cut(wire.connector_id, process.key)

    def _cut(self, connector_id: str, dead_key: int) -> None:
        """Take the surviving end off a connector whose other end died."""
        wire = self.state.connectors.pop(connector_id)
        for end in wire.ports:
            survivor = self.state.process_of(end.instance)
            if survivor is not None and survivor.key != dead_key and survivor.is_alive:
                message = {"op": "unlink", "connector_id": connector_id}
                self._out.append(SendToHolder(survivor.key, message))

    def _halted(self, key: int, is_halted: bool) -> None:
        process = self.state.processes.get(key)
        if process is None or not process.is_alive or process.state == "starting":
            return
        process.state = "stopped" if is_halted else "up"
        for instance in self.state.held_by(key):
            self.state.update(instance, trouble="stopped" if is_halted else "")

    def _wake(self, key: int, value: Process | None) -> None:
        for task in [t for t in self._waiting if t.key == key]:
            self._drop(task)
            self._resume(task, value)

    # the end

    def _stop(self) -> None:
        if self._is_stopping:
            return
        self._is_stopping = True
        self._resume(_Task(self._stopping()), None)

    def _stopping(self) -> Procedure:
        result = yield from stop_everything(self.state)
        self._out.append(Finish())
        return result


def failed(error: RtkitError) -> Result:
    """Return the result that stands for an error."""
    code = (
        ReturnCode.BAD_PARAMETER
        if isinstance(error, (ValueError, LookupError))
        else (ReturnCode.ERROR)
    )
    return Result(code, error.kind, str(error))


def _unfit(process: Process) -> RtkitError | None:
    if not process.is_alive:
        return Unreachable(f"slave {process.name} ended: {process.reason}")
    if process.state == "stopped":
        return Unreachable(f"slave {process.name} does not answer: it is stopped")
    return None
