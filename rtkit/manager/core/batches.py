"""Runs batches and operations of clients: begins actions, gathers results, answers once recorded.

A batch that comes again with the id of an earlier one is not done again: it gets the same answer,
also from the next manager when it changed anything.
"""

from __future__ import annotations

from functools import partial

from rtkit.deployment.actions import Result
from rtkit.deployment.batch import results_to_text, stamp_of
from rtkit.errors import Refused, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.manager.core import events as ev
from rtkit.manager.core import operations
from rtkit.manager.core.deletion import retire
from rtkit.manager.core.durable_replies import DurableReplies, unkept
from rtkit.manager.core.effects import AcquireSlave, Procedure
from rtkit.manager.core.procedures import procedure_for, slaves_of
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.supervisor import Supervisor
from rtkit.manager.core.tasks import Tasks, failed
from rtkit.property.exchange import NOT_BEGUN, Reply

STOPPING = "the manager is stopping"
REMEMBERED = 64
"""How many answers are remembered, the last ones."""
TOO_OLD = "request {} is too old: it may have been done, and its answer is not remembered any more"


class _Job:
    """A batch under way, with all clients that wait for its answer."""

    def __init__(self, asked: ev.BatchRequested) -> None:
        self.batch = asked.batch
        self.requests = [asked.request]
        self.until = asked.until
        self.results: list[Result | None] = [None] * len(asked.batch.actions)
        self.pending = len(self.results)
        self.slaves: list[str] = []
        self.is_over = False


class Batches:
    """Batches that clients requested; `out` collects instructions for the shell.

    Attributes:
        now: The monotonic time [s].
        is_stopping: Nothing is begun any more.
    """

    def __init__(
        self,
        state: ManagerState,
        out: list[ev.Instruction],
        tasks: Tasks,
        keeping: DurableReplies,
        supervisor: Supervisor,
    ) -> None:
        self._state = state
        self._out = out
        self._tasks = tasks
        self._keeping = keeping
        self._supervisor = supervisor
        self._jobs: dict[str, _Job] = {}
        self._answered: dict[str, str] = {}
        self._forgotten: dict[str, int] = {}
        self.now = 0.0
        self.is_stopping = False

    def recall(self) -> None:
        """Remember what an earlier manager has answered."""
        self._answered.update(self._state.kept.answered)
        if len(self._answered) >= REMEMBERED - 1:  # before the first of them were others
            self._forget(next(iter(self._answered)))

    def take(self, asked: ev.BatchRequested) -> None:
        """Begin a batch as soon as it can be recorded, unless it is or was done already."""
        id = asked.batch.id
        if id and id in self._jobs:
            self._jobs[id].requests.append(asked.request)
        elif id and id in self._answered:
            self._out.append(ev.AnswerClient(asked.request, Reply(self._answered[id])))
        elif self._is_too_old(id):
            self._out.append(
                ev.AnswerClient(asked.request, Reply(TOO_OLD.format(id), Refused.kind))
            )
        else:
            self._admit(_Job(asked))

    def _is_too_old(self, id: str) -> bool:
        """Return whether an id may be one of those that were answered and forgotten."""
        stamp = stamp_of(id)
        return stamp is not None and stamp[1] <= self._forgotten.get(stamp[0], -1)

    def _forget(self, id: str) -> None:
        """Note that the answer to a batch is remembered no longer."""
        stamp = stamp_of(id)
        if stamp is None:
            return
        boot, made = stamp
        self._forgotten[boot] = max(made, self._forgotten.pop(boot, -1))
        while len(self._forgotten) > REMEMBERED:
            del self._forgotten[next(iter(self._forgotten))]

    def operate(self, asked: ev.OperationRequested) -> None:
        """Begin an operation."""

        def answer(results: list[Result]) -> None:
            (result,) = results
            text, kind = (result.value, "") if result.ok else (result.why, result.kind)
            self._out.append(ev.AnswerClient(asked.request, Reply(text, kind)))

        def done(result: Result) -> None:
            self._keeping.finish([operations.action(asked.name, asked.argument)], [result], answer)

        if self.is_stopping:
            self._out.append(ev.AnswerClient(asked.request, Reply(STOPPING, Refused.kind)))
        else:
            steps = operations.DO[asked.name](self._state, asked.argument)
            self._tasks.begin(steps, operations.TIMEOUT_S, done)

    def _admit(self, job: _Job) -> None:
        def go_on(why: str) -> None:
            if why:
                self._answer(job, Reply(unkept(why), Refused.kind))
            else:
                self._begin(job)

        if job.batch.id:
            self._jobs[job.batch.id] = job
        self._keeping.admit(job.batch.actions, go_on)

    def _answer(self, job: _Job, reply: Reply) -> None:
        self._out.extend(ev.AnswerClient(request, reply) for request in job.requests)
        self._jobs.pop(job.batch.id, None)

    def _begin(self, job: _Job) -> None:
        if self.is_stopping:
            self._answer(job, Reply(STOPPING, Refused.kind))
        elif not job.pending:
            self._finish(job)
        elif job.batch.is_ordered:
            self._start_slaves(job)
            self._start(job, 0)
        else:
            for index in range(job.pending):
                self._start(job, index)

    def _start_slaves(self, job: _Job) -> None:
        """Start the slaves of an ordered batch side by side; its actions find them ready."""
        for name in slaves_of(job.batch.actions):
            if name != self._state.name and self._state.living_process(name) is None:
                job.slaves.append(name)
                self._tasks.begin(self._started(job, name), job.batch.timeout_s)

    def _started(self, job: _Job, name: str) -> Procedure:
        process: Process = yield AcquireSlave(name)
        if job.is_over:
            yield from retire(self._state, process)
        return Result()

    def _start(self, job: _Job, index: int) -> None:
        done = partial(self._done, job, index, self.now)
        if self.now > job.until:
            done(failed(Unreachable(NOT_BEGUN)))
            return
        action = job.batch.actions[index]
        steps = self._supervisor.steps(action) or procedure_for(action, self._state)
        self._tasks.begin(steps, job.batch.timeout_s, done)

    def _done(self, job: _Job, index: int, began: float, result: Result) -> None:
        job.results[index] = replace(result, took_s=round(self.now - began, 6))
        job.pending -= 1
        is_over = job.batch.is_ordered and (not result.ok or self.is_stopping)
        if is_over or not job.pending:
            self._finish(job)
        elif job.batch.is_ordered:
            self._start(job, index + 1)

    def _finish(self, job: _Job) -> None:
        job.is_over = True
        for name in job.slaves:
            process = self._state.living_process(name)
            if process is not None:
                self._tasks.begin(retire(self._state, process), job.batch.timeout_s)
        done = [
            (action, result)
            for action, result in zip(job.batch.actions, job.results, strict=True)
            if result is not None
        ]
        results = [result for _, result in done]
        text, kept = results_to_text(results), self._state.kept
        if job.batch.id and kept.has_changed:  # in the same commit
            for old in list(kept.answered)[: 1 - REMEMBERED]:
                kept.drop("answered", old)
            kept.put("answered", job.batch.id, text)

        before = list(results)  # those that are taken back are changed in their place

        def answer(recorded: list[Result]) -> None:
            self._conclude(job, text if recorded == before else results_to_text(recorded))

        self._keeping.finish([action for action, _ in done], results, answer)

    def _conclude(self, job: _Job, text: str) -> None:
        """Answer a batch, now that its changes are recorded, or rolled back."""
        id, kept = job.batch.id, self._state.kept
        self._answer(job, Reply(text))
        if not id:
            return
        self._answered[id] = text
        for old in list(self._answered)[:-REMEMBERED]:
            del self._answered[old]
            self._forget(old)
        if kept.answered.get(id, text) != text:
            kept.drop("answered", id)
