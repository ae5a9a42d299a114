"""Restarts components that died as their policy says: with back-off, within limits, or not at all.

A restarted component is configured, connected and active as desired. A user takes precedence:
what he ended is not restarted, what he made himself begins with a clean record.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Generator, Iterable, Mapping
from typing import Any
from zlib import crc32

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.listing import is_device_absence
from rtkit.deployment.supervision import WINDOW_S, RestartPolicy, RestartRule, at_end, at_health
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.fast_dataclass import replace
from rtkit.manager.core.deletion import FORCE_S, HANGING_S, end_slaves, remedy
from rtkit.manager.core.desired_changes import note
from rtkit.manager.core.effects import Call, Procedure, ReadClock, Sleep
from rtkit.manager.core.effects import Effect as Yielded
from rtkit.manager.core.policies import policy_of
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.recovery import Failed, lives, revive
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.tasks import Tasks, ignored
from rtkit.rtc.enums import LifeCycleState, Transition

_log = logging.getLogger(__name__)
_REVIVE_S = 10.0
"""How long each step of a restart may take [s]."""
BREATH_S = 0.001
"""Delay from the report of a component to the report of its restart [s]."""
_STOP_S = 30.0
"""How long it may take to stop a system [s]."""
_ORDERLY = "exit status 0"
_WELL = (LifeCycleState.ACTIVE, LifeCycleState.INACTIVE)


class Supervisor:
    """Restarts components that ended, as their policies say.

    Until all that was left by an earlier manager is back, ends are only noted.
    """

    def __init__(self, state: ManagerState, tasks: Tasks) -> None:
        self._state = state
        self._tasks = tasks
        self._early: list[tuple[list[str], str]] | None = None

    @property
    def is_early(self) -> bool:
        """Return whether it is not known yet what an earlier manager left."""
        return self._early is not None

    def policy(self, instance: str) -> RestartPolicy:
        """Return the policy of a component; one that is not desired is not restarted."""
        entry = self._state.kept.components.get(instance)
        return RestartPolicy() if entry is None else policy_of(self._state, entry.create)

    def wants(self, instance: str, reason: str) -> bool:
        """Return whether a component that ended for that reason is to be restarted."""
        return self.policy(instance).wants(reason != _ORDERLY)

    def recall(self, *, is_same_boot: bool) -> None:
        """Take up what an earlier manager noted; in another run of the machine all begin anew."""
        kept = self._state.kept
        self._early = []
        for instance, watched in list(kept.watched.items()):
            if not is_same_boot:
                kept.put("watched", instance, watched.record)
            elif watched.pending:
                self._state.returning.add(instance)

    def resume(self, now: float) -> None:
        """Go on where an earlier manager was: all that lives is known."""
        state, kept = self._state, self._state.kept
        early, self._early = self._early or [], None
        ended = {instance for instances, _ in early for instance in instances}
        state.returning.difference_update(ended)
        waiting: dict[str, list[str]] = {}
        for instance, watched in list(kept.watched.items()):
            if instance not in kept.components:
                kept.drop("watched", instance)
            elif not watched.pending or instance in ended or is_device_absence(watched.pending):
                continue
            elif lives(state, instance):
                state.returning.discard(instance)
                self._note(instance, now)
            else:
                waiting.setdefault(watched.pending, []).append(instance)
        for why, instances in waiting.items():
            due = max(max(kept.watched[each].ledger.times, default=now) for each in instances)
            if due > now:
                self._begin(instances, due - now, why)
            else:  # perhaps it was restarted and died with that manager: that counts
                state.returning.difference_update(instances)
                early.append((instances, why))
        for instances, why in early:
            self.lost(instances, why, now)
        for facts in list(state.components.values()):
            if not facts.zombie:
                self.on_facts(facts, now)

    def lost(self, instances: Iterable[str], why: str, now: float) -> None:
        """Take note of components that ended at monotonic time `now` [s]."""
        state = self._state
        if self._early is not None:
            self._early.append((list(instances), why))
            wanted = [each for each in instances if self.wants(each, why)]
            state.returning.update(wanted)
            for instance in wanted:  # in one commit with their end, so that neither is forgotten
                state.watch(instance, pending=why)
            return
        instances = list(instances)
        for each in filter(state.returning.__contains__, instances):
            self._show_zombie(each)  # dead again before it was noted
        policies = {each: self.policy(each) for each in instances if each not in state.returning}
        critical = [each for each, policy in policies.items() if policy.is_critical]
        if critical:
            self.stop_all(critical, why)
        waits = {}
        for instance, policy in policies.items():
            if not policy.wants(why != _ORDERLY):
                continue
            watched = state.watched(instance)
            ledger, wait_s = at_end(
                watched.ledger, policy, now, _spread(instance, watched.restarts)
            )
            if wait_s is None:
                state.watch(instance, ledger=ledger, pending="")
                self._give_up(instance, policy, why)
            else:
                state.watch(instance, ledger=ledger, pending=why)
                self._show_zombie(instance)
                waits[instance] = wait_s
        if waits:
            self._begin(tuple(waits), max(waits.values()), why)

    def stop_all(self, critical: Collection[str], why: str) -> None:
        """Deactivate everything, since these were lost or are not well."""
        for instance in critical:
            self._state.watch(instance, halted=why)
        self._tasks.begin(_stop_system(self._state, critical, why), _STOP_S, ignored)

    def steps(self, action: act.Action) -> Procedure | None:
        """Return how an action is done to a component that is in hand; None for any other."""
        if not isinstance(action, act.ChangeState) or not self._state.is_in_hand(action.instance):
            return None
        return self._change_desired(action)

    def _change_desired(self, action: act.ChangeState) -> Procedure:
        """Set a dead component's desired state to rest; at a reset restart it at once, forgive all.

        Raises:
            Refused: It is to be active, which it cannot be now.
            RtkitError: It cannot be made.
        """
        yield from ()
        state, instance = self._state, action.instance
        if action.transition is Transition.ACTIVATE:
            raise Refused(f"zombie ({state.components[instance].zombie}): {instance}")
        note(state.kept, action)
        if action.transition is Transition.RESET:
            yield from self._make_at_once(instance)
        return Result()

    def _make_at_once(self, instance: str) -> Generator[Yielded, Any, None]:
        state, failures = self._state, list[RtkitError]()
        state.kept.put("watched", instance, state.watched(instance).record)
        state.returning.discard(instance)
        yield from revive(state, [instance], lambda _what, error: failures.append(error))
        if failures:
            raise failures[0]
        state.watch(instance, restarts=state.watched(instance).restarts + 1)

    def on_facts(self, facts: ComponentFacts, now: float) -> None:
        """Take note of how a component is: in Error it counts as lost."""
        state, instance = self._state, facts.instance
        if instance in state.claims or instance in state.ending:
            return
        if instance in state.returning or self._early is not None:
            return
        is_in_error = _is_in_error(facts)
        if is_in_error is not state.watched(instance).is_in_error:
            self._erred(facts, now, is_in_error=is_in_error)
        watched = state.kept.watched.get(instance)
        if watched is not None:
            is_well = not (facts.trouble or facts.restart_status.trouble)
            is_well = is_well and all(c.state in _WELL for c in facts.contexts)
            state.watch(instance, ledger=at_health(watched.ledger, now, is_well=is_well))

    def _erred(self, facts: ComponentFacts, now: float, *, is_in_error: bool) -> None:
        """Take note that a component has come into Error, or out of it."""
        policy = self.policy(facts.instance)
        if policy.restart is RestartRule.NEVER and not policy.is_critical:
            return
        self._state.watch(facts.instance, is_in_error=is_in_error)
        if is_in_error:
            self.lost([facts.instance], ": ".join(filter(None, ["in Error", facts.cause])), now)

    def _give_up(self, instance: str, policy: RestartPolicy, why: str) -> None:
        state = self._state
        text = f"given up after {policy.limit} restarts within {WINDOW_S:g} s"
        text = state.watched(instance).given_up or text
        _log.error("%s is %s: %s", instance, text, why, extra={"about": instance})
        state.watch(instance, given_up=text)
        if instance in state.components and not lives(state, instance):
            state.update(instance, zombie=f"{why}; {text}")
        self._show_zombie(instance)

    def _show_zombie(self, instance: str) -> None:
        """Have the next manager show what has died, too."""
        facts = self._state.components.get(instance)
        if facts is not None and facts.zombie:
            self._state.kept.lost(facts)

    def _begin(self, instances: Collection[str], wait_s: float, why: str) -> None:
        self._state.returning.update(instances)
        dues = {each: self._state.watched(each).ledger.times for each in instances}
        again = self._bring_back(dues, wait_s, why)
        self._tasks.begin(again, _REVIVE_S, ignored)

    def _bring_back(
        self, dues: Mapping[str, tuple[float, ...]], wait_s: float, why: str
    ) -> Procedure:
        """Make components again after a while, unless somebody has done so or ended them.

        The last moment in `dues` identifies the restart of each: another one may be due after
        a reset.
        """
        state = self._state
        failures: list[str] = []

        def failed(what: str, error: RtkitError) -> None:
            failures.append(f"cannot {what}: {error}")
            _log.error("%s", failures[-1])

        try:
            yield Sleep(wait_s)
            still = [each for each in self._of_this(dues) if self._is_missed(each)]
            for instance in still:
                if lives(state, instance):
                    yield from take_down(state, instance, why, failed)
            still = [each for each in still if not lives(state, each)]
            yield from revive(state, still, failed)
            yield Sleep(BREATH_S)
        finally:
            instances = self._of_this(dues)
            state.returning.difference_update(instances)
            state.unwell.difference_update(instances)
        now = yield ReadClock()
        dead = [each for each in still if not lives(state, each) and self._is_missed(each)]
        for instance in instances:
            if instance in still and lives(state, instance):
                self._note(instance, now)
                self.on_facts(state.components[instance], now)
            elif instance in state.kept.watched:
                state.watch(instance, pending="")
        self.lost(dead, failures[0] if failures else "it ended at its start", now)
        return Result()

    def _of_this(self, dues: Mapping[str, tuple[float, ...]]) -> list[str]:
        """Return those for which no other restart is due by now."""
        watched = {each: self._state.watched(each) for each in dues}
        return [
            instance
            for instance, each in watched.items()
            if (not each.pending or each.ledger.times == dues[instance])
            and not is_device_absence(each.pending)
        ]

    def _is_missed(self, instance: str) -> bool:
        """Return whether a component is desired, nothing usable exists, and nobody has reset it."""
        state = self._state
        if instance not in state.kept.components or not state.watched(instance).pending:
            return False
        if instance in state.ending or instance in state.claims:
            return False
        is_bad = instance in state.unwell or not lives(state, instance)
        return is_bad or _is_in_error(state.components[instance])

    def _note(self, instance: str, now: float) -> None:
        """Note that a component is there again."""
        watched = self._state.watched(instance)
        ended = max(watched.ledger.times, default=now) - watched.ledger.wait_s
        self._state.watch(instance, pending="", took_s=round(now - ended, 6))
        count, why = watched.restarts, watched.pending
        about = {"about": instance}
        _log.warning("%s was made again (%d.): %s", instance, count, why, extra=about)


def _spread(instance: str, count: int) -> float:
    """Return a number from -1 to 1 that differs between components, so that they do not crowd."""
    return crc32(f"{instance} {count}".encode()) / 0x7FFFFFFF - 1.0


def _is_in_error(facts: ComponentFacts) -> bool:
    return any(context.state is LifeCycleState.ERROR for context in facts.contexts)


def take_down(
    state: ManagerState, instance: str, why: str, failed: Failed
) -> Generator[Yielded, Any, None]:
    """End a component that is bad, its process where that does not work; it stays desired."""
    process = state.process_of(instance)
    if process is None:
        return
    state.ending.add(instance)
    try:
        yield Call(process, {"op": "delete", "instance": instance}, FORCE_S)
        state.forget(instance)
    except Unreachable as error:
        if process.is_slave and process.is_alive:
            process.verdict = f"{instance} did not end by itself ({why}): {error}"
            yield from end_slaves([process], HANGING_S)
        elif process.is_alive:
            text = f"{error}; {remedy(state, process, instance)}"
            failed(f"end {instance}", Unreachable(text))
            ledger = replace(state.watched(instance).ledger, is_given_up=True)
            text = f"it cannot be ended: {text}"
            state.watch(instance, pending="", ledger=ledger, given_up=text)
    finally:
        state.ending.discard(instance)


def _stop_system(state: ManagerState, critical: Collection[str], why: str) -> Procedure:
    """Deactivate all components, the last made first: it is not safe to go on without one."""
    _log.error("critical: %s; the system is stopped (%s)", ", ".join(critical), why)
    for instance in critical:
        state.kept.change(instance, active=())
    for instance in reversed(list(state.components)):
        facts = state.components.get(instance)
        if facts is not None and not facts.zombie:
            yield from bring_to_rest(state, instance)
    return Result()


def bring_to_rest(state: ManagerState, instance: str) -> Procedure:
    """Deactivate a component where it is active."""
    for context in state.components[instance].contexts:
        if context.state is LifeCycleState.ACTIVE:
            rest = act.ChangeState(instance, context.id, Transition.DEACTIVATE)
            try:
                yield from procedure_for(rest, state)
            except RtkitError as error:
                _log.error("cannot deactivate %s: %s", instance, error)
    return Result()
