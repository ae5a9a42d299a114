"""Carries out a start or stop on a tree: the imperative shell around `rtkit.deployment.execution`.

The shell sends each action before it takes up the next one; a thread of its own awaits each answer.
The threads keep their results and raise a wakeup: so an interruption, which may strike anywhere,
loses no answer. Where states count, a subscription to the manager receives their changes.
"""

from __future__ import annotations

from threading import Event, Lock, Thread
from time import monotonic

from rtkit.deployment.actions import Action, Result
from rtkit.deployment.execution import StartExecution
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.plan_watch import BEGUN, PlanWatch
from rtkit.deployment.runner import Count, Talk
from rtkit.deployment.start_schedule import ScheduledAction, StartPlan, look
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import stopping
from rtkit.link.wakeup import Wakeup
from rtkit.tree import grace
from rtkit.tree.client import Tree, bounded
from rtkit.tree.grace import uninterrupted
from rtkit.tree.manager_set import ManagerSetSubscription, subscription_at
from rtkit.tree.subscription import ManagerSubscription, SubscriptionEnded


class Starter:
    """Carries out one plan whose checks hold."""

    def __init__(
        self,
        tree: Tree,
        plan: StartPlan,
        announce: Talk,
        report: Talk,
        timeout_s: float | None = None,
        count: Count = lambda _done, _known: None,
        taken: list[tuple[Action, float]] | None = None,
        watch: PlanWatch | None = None,
    ) -> None:
        """Prepare to carry out `plan`.

        Args:
            tree: Where.
            plan: What.
            announce: Receives each action before it is sent.
            report: Receives failures that do not end the plan.
            timeout_s: Bound on the whole [s]; None for none.
            count: Receives how many actions are done, and how many there are.
            taken: Gets what the actions took that were done [s], where the manager reports it.
            watch: Receives what becomes of each step; `announce` nothing then.
        """
        self._tree = tree
        self._announce = announce
        self._report = report
        self._watch = watch
        self._count = count
        self._reported: set[str] = set()
        self._execution = StartExecution(plan, monotonic(), timeout_s, tree.timeout_s)
        self._wakeup: Wakeup
        self._subscription: ManagerSubscription | ManagerSetSubscription | None = None
        self._lock = Lock()
        self._is_broken_off = False
        self._sent: set[int] = set()
        self._outcomes: dict[int, Result | BaseException] = {}
        self._taken = [] if taken is None else taken

    def run(self) -> None:
        """Carry the plan out.

        Raises:
            Refused: A required action failed, or conditions were not met in time; what was not
                begun by then is not done.
            Unreachable: The manager does not answer.
            KeyboardInterrupt: Interrupted; its text states what was not done.
        """
        self._wakeup = Wakeup()
        try:
            with stopping.waking(self._wakeup.ring):
                self._run()
        finally:
            if self._subscription is not None:
                self._subscription.close()
            self._wakeup.close()

    def _run(self) -> None:
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
        self._look(watched)
        begun = execution.ready(monotonic())
        self._report_new()
        all_turns = len(execution.plan.turns)
        self._count(all_turns - len(execution.waiting) - len(execution.running), all_turns)
        for turn in begun:
            self._send(turn)
        if not execution.failure and not execution.is_over:
            self._receive()

    def _look(self, watched: tuple[ScheduledAction, ...]) -> None:
        if not watched:
            return
        facts = uninterrupted(self._facts)
        seen = look([turn.watched for turn in watched], facts.component)
        self._execution.saw(dict(zip((turn.target for turn in watched), seen, strict=True)))

    def _facts(self) -> Snapshot:
        """Return what the manager knows now, and listen from now on.

        Raises:
            Unreachable: It has ended.
        """
        if self._subscription is None:
            self._subscription = subscription_at(self._tree)
        for event in self._subscription.take():
            if isinstance(event, SubscriptionEnded):
                raise Unreachable(event.why)
        return self._subscription.facts

    def _send(self, turn: ScheduledAction) -> None:
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
            self._wakeup.ring()
            is_sent.set()

        if self._watch is not None:
            self._watch.step(turn.step.text, BEGUN)
        else:
            self._announce(f"Executing {turn.step.line}")
        Thread(target=work, daemon=True).start()
        is_sent.wait()

    def _receive(self) -> None:
        """Wait until something happens, or until it is time to act."""
        moment = self._execution.next_moment()
        patience_s = None if moment is None else bounded(max(0.0, moment - monotonic()))
        self._wakeup.wait(
            self._subscription.sources if self._subscription is not None else (), patience_s
        )
        stopping.check()
        error = self._take()
        if error is not None:
            raise error

    def _take(self) -> BaseException | None:
        """Take the answers that have come; return why one did not come, if so."""
        failure = None
        for turn in self._execution.running:
            outcome = self._outcomes.get(turn.id)
            if isinstance(outcome, Result):
                if outcome.ok and outcome.took_s and turn.step.action is not None:
                    self._taken.append((turn.step.action, outcome.took_s))
                self._execution.answered(turn, outcome, monotonic())
            else:
                failure = failure or outcome
        self._report_new()
        return failure

    def _settle(self) -> str:
        """Wait a little for what is under way; report what was not done."""
        with self._lock:
            self._is_broken_off = True
        end = monotonic() + grace.GRACE_S
        while self._sent - self._outcomes.keys():
            if not self._wakeup.wait((), max(0.0, end - monotonic())):
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

    def _report_new(self) -> None:
        for end in self._execution.ends():
            if self._watch is not None:
                self._watch.step(*end)
        for text in self._execution.reports():
            if text not in self._reported:
                self._reported.add(text)
                self._report(text)


def _joined(first: object, more: str) -> str:
    return f"{first}; {more}" if more else str(first)
