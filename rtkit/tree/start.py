"""Carries out a start or stop on a tree: the shell of `rtkit.deployment.execution`.

Each action is sent before the next one is taken up; its answer, and a change of a state that
somebody waits for, is awaited by a thread of its own and comes back through a queue.
"""

from __future__ import annotations

from collections.abc import Iterable
from queue import Empty, SimpleQueue
from threading import Event, Thread
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

_Outcome = Result | BaseException


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
        self._inbox: SimpleQueue[tuple[Turn | None, _Outcome | None]] = SimpleQueue()
        self._sent: dict[int, Turn] = {}
        self._lost: dict[int, Turn] = {}
        self._is_watching = False

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
            outcome: _Outcome
            try:
                answer = self._tree.begin([action])
                is_sent.set()
                (outcome,) = answer()
            except BaseException as error:
                outcome = error
            self._inbox.put((turn, outcome))
            is_sent.set()

        self._announce(f"Executing {turn.step.line}")
        self._sent[turn.id] = turn
        Thread(target=work, daemon=True).start()
        is_sent.wait()

    def _watch(self, watched: tuple[Turn, ...], known: tuple[str, ...]) -> None:
        targets = [turn.watched for turn in watched]

        def work() -> None:
            outcome = None
            try:
                self._tree.watch(targets, known, _WATCH_S)
            except BaseException as error:
                outcome = error
            self._inbox.put((None, outcome))

        self._is_watching = True
        Thread(target=work, daemon=True).start()

    def _hear(self) -> None:
        """Wait until something happens, or until it is time to act."""
        now = monotonic()
        moment = self._execution.next_moment(now)
        patience_s = None if moment is None else bounded(max(0.0, moment - now))
        try:
            turn, outcome = self._inbox.get(timeout=patience_s)
        except Empty:
            return
        self._take(turn, outcome)
        if isinstance(outcome, BaseException):
            raise outcome

    def _take(self, turn: Turn | None, outcome: _Outcome | None) -> None:
        if turn is None:
            self._is_watching = False
            return
        del self._sent[turn.id]
        if isinstance(outcome, Result):
            self._execution.answered(turn, outcome, monotonic())
            self._tell(self._execution.reports())
        else:
            self._lost[turn.id] = turn

    def _settle(self) -> str:
        """Wait a little for what is under way; tell what was not done."""
        end = monotonic() + apply.GRACE_S
        while self._sent:
            try:
                self._take(*self._inbox.get(timeout=max(0.0, end - monotonic())))
            except Empty:
                break
        lost = {**self._lost, **self._sent}
        execution = self._execution
        rest = [turn for turn in (*execution.running, *execution.waiting) if turn.id not in lost]
        parts = ("no answer to", lost.values()), ("not run", rest)
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
