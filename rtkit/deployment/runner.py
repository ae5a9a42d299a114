"""Runs a plan: one batch a layer, reports every failure, and ends in order when interrupted."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from rtkit.deployment.actions import Action, Result, strict
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.layered_plan import Check, LayeredPlan, PlannedAction, merged
from rtkit.deployment.plan_watch import BEGUN, DONE, FAILED, HELD, PlanWatch
from rtkit.deployment.site import UNFINISHED, Careful, Site, at_once
from rtkit.errors import Refused, RtkitError, Unreachable

Talk = Callable[[str], None]
Count = Callable[[int, int], None]


class PlanRunner:
    """Carries plans out at one site.

    Attributes:
        attempted: Every action sent so far.
        done: The steps that were carried out.
        failed: The required steps that failed.
    """

    def __init__(
        self,
        site: Site,
        report: Talk,
        progress: Talk = lambda _: None,
        count: Count = lambda _done, _known: None,
        taken: list[tuple[Action, float]] | None = None,
        careful: Careful = at_once,
        *,
        is_strict: bool = False,
        watch: PlanWatch | None = None,
    ) -> None:
        """Carry out plans at `site`.

        Args:
            site: Where.
            report: Receives failures that do not end the run.
            progress: Receives each layer before it is done, and each step when it is.
            count: Receives how many steps are done, of how many that are known of.
            taken: Gets what the actions took that were done [s], where the manager reports it.
            careful: Makes the calls; an interruption of the command waits for their end.
            is_strict: Steps that would be done with a note are to fail instead.
            watch: Receives what becomes of each step; then `progress` is not told of it.
        """
        self._is_strict = is_strict
        self._watch = watch
        self._site = site
        self._careful = careful
        self._report = report
        self._progress = progress
        self._count = count
        self._passed = self._known = 0
        self._reported: set[str] = set()
        self.attempted: list[Action] = []
        self.done: list[PlannedAction] = []
        self.failed: list[PlannedAction] = []
        self._taken = [] if taken is None else taken

    def check(self, checks: Iterable[Check]) -> None:
        """Refuse to begin when something that must hold does not.

        Raises:
            Refused: Required checks failed; those before the last one were reported.
        """
        failures = []
        for check in checks:
            if check.failure and check.is_required:
                failures.append(check.failure)
            else:
                self._report_once(check.failure)
        self._refuse(failures)

    def _refuse(self, failures: Sequence[str]) -> None:
        for why in failures[:-1]:
            self._report(f"Required action failed: {why}")
        if failures:
            raise Refused(f"Required action failed: {failures[-1]}")

    def run(self, plan: LayeredPlan) -> None:
        """Carry out a plan whose checks hold.

        Raises:
            Refused: A required action failed; what follows it was not begun.
            Unreachable: The manager does not answer.
        """
        self._known += sum(len(layer.steps) for layer in plan.layers)
        for layer in plan.layers:
            self._count(self._passed, self._known)
            todo = sum(step.action is not None for step in layer.steps)
            if self._watch is None:
                self._progress(f"{layer.name}: {todo} of {len(layer.steps)} to be done")
            for steps in [[step] for step in layer.steps] if layer.is_ordered else [layer.steps]:
                self._run_at_once(steps)
            self._passed += len(layer.steps)
        self._count(self._passed, self._known)

    def _run_at_once(self, steps: Sequence[PlannedAction]) -> None:
        for step in steps:
            if step.blocked:
                self._failed([step], step.blocked)
            elif step.holds:
                self._note(step, HELD)
        sent = merged(steps)
        for step in (step for _, together in sent for step in together):
            self._note(step, BEGUN)
        failures = []
        for (_, together), result in zip(sent, self._send([a for a, _ in sent]), strict=True):
            if result.ok:
                self.done += together
                for step in together:
                    self._note(step, DONE, result.took_s)
            elif any(step.is_required for step in together):
                self.failed += together
                failures.append(together[0].failure_text(result.why))
                for step in together:
                    self._note(step, FAILED, why=result.why)
            else:
                self._failed(together, together[0].failure_text(result.why))
        self._refuse(failures)

    def _note(
        self, step: PlannedAction, state: str, took_s: float | None = None, why: str = ""
    ) -> None:
        if self._watch is not None:
            self._watch.step(step.text, state, took_s, why)
        elif state == DONE:
            self._progress(f"done: {step.text}")

    def _failed(self, steps: Sequence[PlannedAction], why: str) -> None:
        for step in steps:
            self._note(step, FAILED, why=why)
        if any(step.is_required for step in steps):
            self.failed += steps
            raise Refused(f"Required action failed: {why}")
        self._report_once(why)

    def _report_once(self, why: str) -> None:
        if why and why not in self._reported:
            self._reported.add(why)
            self._report(f"Action failed: {why}")

    def _send(self, actions: Sequence[Action]) -> tuple[Result, ...]:
        if not actions:
            return ()
        if self._is_strict:
            actions = [strict(action) for action in actions]
        self.attempted += actions
        results = self._careful(lambda: self._site.apply(actions, is_ordered=False))
        for note in filter(None, (result.note for result in results)):
            self._report(f"note: {note}")
        done = zip(actions, results, strict=False)  # what follows a failure has no result
        self._taken += [(action, each.took_s) for action, each in done if each.ok and each.took_s]
        return results

    def undo(self, before: Snapshot) -> tuple[list[str], list[str]]:
        """Take back what was attempted since `before`; return what was removed and what remains.

        Raises:
            RtkitError: The manager does not answer the request for a snapshot.
        """
        from rtkit.deployment.traces import traces

        removed: list[str] = []
        remaining: list[str] = []
        left = deque(traces(self.attempted, before, self._careful(self._site.remains)))
        while left:
            trace = left.popleft()
            try:
                (result,) = self._careful(partial(self._site.apply, [trace.undo]))
            except Unreachable as error:
                # A silent manager would be waited for once more with each of the others.
                remaining += [f"{trace.what} ({error})", *(each.what for each in left)]
                break
            if result.ok or result.kind == "not-found":
                removed.append(trace.what)
            else:
                remaining.append(f"{trace.what} ({result.why})")
        return removed, remaining


def roll_back(runner: PlanRunner, before: Snapshot, error: BaseException) -> str:
    """Take back what a failed run did and report it in a few words; empty when it did nothing."""
    if not runner.attempted:
        return ""
    try:
        removed, remaining = runner.undo(before)
    except (RtkitError, KeyboardInterrupt) as trouble:
        return f"what was made could not be removed ({str(trouble) or 'interrupted again'})"
    parts = [f"removed again: {', '.join(removed)}"] if removed else []
    parts += [f"remains: {', '.join(remaining)}"] if remaining else []
    if UNFINISHED in error.args:
        parts.append("the manager may still be busy with what it was last asked for")
    return "; ".join(parts)
