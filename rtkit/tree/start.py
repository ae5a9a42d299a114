"""Carries out a start or stop on a tree: the shell of `rtkit.deployment.execution`.

Each action is sent before the next one is taken up; its answer, and a change of a state that
somebody waits for, is awaited by a thread of its own. What these find is kept, and a queue wakes
who waits for it: so an interruption, which may strike anywhere, loses no answer.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Event, Lock, Thread
from time import monotonic

from rtkit.deployment.actions import Result
from rtkit.deployment.execution import Execution
from rtkit.deployment.turns import StartPlan, Turn
from rtkit.errors import Refused, RtkitError
from rtkit.tree import apply
from rtkit.tree.apply import Talk, uninterrupted
from rtkit.tree.client import Tree, bounded

_WATCH_S = 60.0
"""How long the manager keeps a watch whose client went away [s]."""


class Starter:
    """Carries out one plan whose checks hold."""

    def __init__(
        self,
        tree: Tree,
        plan: StartPlan,
        announce: Talk,
        report: Talk,
        timeout_s: float | None = None,
    ) -> None:
        """Prepare to carry out `plan`.

        Args:
            tree: Where.
            plan: What.
            announce: Is told each action before it is sent.
            report: Is told failures that do not end the plan.
            timeout_s: Bound on the whole [s]; None for none.
        """
        self._tree = tree
        self._announce = announce
        self._report = report
        self._told: set[str] = set()
        self._execution = Execution(plan, monotonic(), timeout_s, tree.timeout_s)
        self._news: SimpleQueue[None] = SimpleQueue()
        self._lock = Lock()
        self._is_broken_off = False
        self._sent: set[int] = set()
        self._outcomes: dict[int, Result | BaseException] = {}
        self._is_watching = False
        self._lost_watch: BaseException | None = None

    def run(self) -> None:
        """Carry the plan out.

        Raises:
            Refused: A required action failed, or conditions were not met in time; what was not
                begun by then is not done.
            Unreachable: The manager does not answer.
            KeyboardInterrupt: Interrupted; its text tells what was not done.
        """
        execution = self._execution
        try:
            while not execution.failure and not execution.is_over:
                self._go_on()
        except KeyboardInterrupt:
            execution.cancel("interrupted")
            raise KeyboardInterrupt(self._settle()) from None
        except RtkitError as error:
            execution.cancel(str(error))
            raise type(error)(_joined(error, self._settle())) from error
        if execution.failure:
            raise Refused(_joined(execution.failure, self._settle()))

    def _go_on(self) -> None:
        execution = self._execution
        watched = execution.watched
        known = self._look(watched)
        begun = execution.ready(monotonic())
        self._tell(execution.reports())
        for turn in begun:
            self._send(turn)
        if execution.lacks_a_state and not self._is_watching:
            self._watch(watched, known)
        if not execution.failure and not execution.is_over:
            self._hear()

    def _look(self, watched: tuple[Turn, ...]) -> tuple[str, ...]:
        if not watched:
            return ()
        known = uninterrupted(lambda: self._tree.watch([turn.watched for turn in watched]))
        targets = [turn.target for turn in watched]
        self._execution.saw(dict(zip(targets, known, strict=True)))
        return known

    def _send(self, turn: Turn) -> None:
        """Send an action and return when it is under way, so that the next one comes after it."""
        action = turn.step.action
        assert action is not None
        is_sent = Event()

        def work() -> None:
            with self._lock:
                if self._is_broken_off:
                    return
                self._sent.add(turn.id)
            try:
                answer = self._tree.begin([action])
                is_sent.set()
                (self._outcomes[turn.id],) = answer()
            except BaseException as error:
                self._outcomes[turn.id] = error
            self._news.put(None)
            is_sent.set()

        self._announce(f"Executing {turn.step.line}")
        Thread(target=work, daemon=True).start()
        is_sent.wait()

    def _watch(self, watched: tuple[Turn, ...], known: tuple[str, ...]) -> None:
        targets = [turn.watched for turn in watched]

        def work() -> None:
            try:
                self._tree.watch(targets, known, _WATCH_S)
            except BaseException as error:
                self._lost_watch = error
            self._is_watching = False
            self._news.put(None)

        self._is_watching = True
        Thread(target=work, daemon=True).start()

    def _hear(self) -> None:
        """Wait until something happens, or until it is time to act."""
        moment = self._execution.next_moment()
        patience_s = None if moment is None else bounded(max(0.0, moment - monotonic()))
        with suppress(Empty):
            self._news.get(timeout=patience_s)
        error = self._take() or self._lost_watch
        if error is not None:
            raise error

    def _take(self) -> BaseException | None:
        """Take the answers that have come; return why one did not come, if so."""
        failure = None
        for turn in self._execution.running:
            outcome = self._outcomes.get(turn.id)
            if isinstance(outcome, Result):
                self._execution.answered(turn, outcome, monotonic())
            else:
                failure = failure or outcome
        self._tell(self._execution.reports())
        return failure

    def _settle(self) -> str:
        """Wait a little for what is under way; tell what was not done."""
        with self._lock:
            self._is_broken_off = True
        end = monotonic() + apply.GRACE_S
        while self._sent - self._outcomes.keys():
            try:
                self._news.get(timeout=max(0.0, end - monotonic()))
            except Empty:
                break
        self._take()
        left = (*self._execution.running, *self._execution.waiting)
        parts = (
            ("no answer to", [turn for turn in left if turn.id in self._sent]),
            ("not run", [turn for turn in left if turn.id not in self._sent]),
        )
        return "; ".join(
            f"{what}: {', '.join(f'{{{turn.id}}}' for turn in turns)}"
            for what, turns in parts
            if turns
        )

    def _tell(self, reports: Iterable[str]) -> None:
        for text in reports:
            if text not in self._told:
                self._told.add(text)
                self._report(text)


def _joined(first: object, more: str) -> str:
    return f"{first}; {more}" if more else str(first)
