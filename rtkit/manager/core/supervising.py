"""Makes again what has died, as its policy says: with back-off, within limits, or not at all.

What is made again is configured, connected and active as it is wished. A user's word counts more:
what he ended is not made again, what he made himself begins with a clean record.
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Generator, Iterable
from typing import Any
from zlib import crc32

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.supervision import (
    WINDOW_S,
    Policy,
    at_end,
    at_health,
)
from rtkit.errors import RtkitError, Unreachable
from rtkit.manager.core.deletion import FORCE_S
from rtkit.manager.core.policies import policy_of
from rtkit.manager.core.procedures import procedure_for
from rtkit.manager.core.restoring import lives, revive
from rtkit.manager.core.state import State, Watched
from rtkit.manager.core.stopping import end_slaves, grace_s
from rtkit.manager.core.tasks import Tasks
from rtkit.manager.core.wishes import Ask, Clock, Pause, Procedure
from rtkit.manager.core.wishes import Wish as Yielded
from rtkit.records import replace
from rtkit.rtc.enums import LifeCycleState, Transition

_log = logging.getLogger(__name__)
_REVIVE_S = 10.0
"""How long each step of a restart may take [s]."""
_STOP_S = 30.0
"""How long it may take to stop a system [s]."""
_ORDERLY = "exit status 0"
_WELL = (LifeCycleState.ACTIVE, LifeCycleState.INACTIVE)


class Supervisor:
    """What is done about ends."""

    def __init__(self, state: State, tasks: Tasks) -> None:
        self._state = state
        self._tasks = tasks

    def policy(self, instance: str) -> Policy:
        """Return the policy of a component; one that is not wished for is not made again."""
        wish = self._state.kept.components.get(instance)
        return Policy() if wish is None else policy_of(self._state, wish.create)

    def wants(self, instance: str, reason: str) -> bool:
        """Whether a component that ended for that reason is to be made again."""
        return self.policy(instance).wants(reason != _ORDERLY)

    def lost(self, instances: Iterable[str], why: str, now: float) -> None:
        """Take note of components that ended at monotonic time `now` [s]."""
        state = self._state
        policies = {each: self.policy(each) for each in instances if each not in state.returning}
        critical = [each for each, policy in policies.items() if policy.is_critical]
        if critical:
            self.stop_all(critical, why)
        waits = {}
        for instance, policy in policies.items():
            if not policy.wants(why != _ORDERLY):
                continue
            watched = state.watched.get(instance, Watched())
            ledger, wait_s = at_end(
                watched.ledger, policy, now, _spread(instance, watched.restarts)
            )
            state.watched[instance] = replace(watched, ledger=ledger)
            if wait_s is None:
                self._give_up(instance, policy, why)
            else:
                waits[instance] = wait_s
        if waits:
            state.returning.update(waits)
            again = self._bring_back(tuple(waits), max(waits.values()), why)
            self._tasks.begin(again, _REVIVE_S, _ignore)

    def stop_all(self, critical: Collection[str], why: str) -> None:
        """Deactivate everything, since these were lost or are not well."""
        self._tasks.begin(_stop_system(self._state, critical, why), _STOP_S, _ignore)

    def heard(self, facts: ComponentFacts, now: float) -> None:
        """Take note of how a component is: in Error it counts as lost."""
        state, instance = self._state, facts.instance
        if instance in state.claims or instance in state.ending:
            return
        if instance in state.returning:
            return
        watched = state.watched.get(instance, Watched())
        is_in_error = _is_in_error(facts)
        if is_in_error is not watched.is_in_error:
            state.watched[instance] = replace(watched, is_in_error=is_in_error)
            if is_in_error:
                self.lost([instance], ": ".join(filter(None, ["in Error", facts.cause])), now)
        if instance in state.watched:
            watched = state.watched[instance]
            is_well = not facts.trouble and all(c.state in _WELL for c in facts.contexts)
            ledger = at_health(watched.ledger, now, is_well=is_well)
            state.watched[instance] = replace(watched, ledger=ledger)

    def _give_up(self, instance: str, policy: Policy, why: str) -> None:
        state = self._state
        text = f"given up after {policy.limit} restarts within {WINDOW_S:g} s"
        _log.error("%s is %s: %s", instance, text, why)
        if lives(state, instance):
            process = state.process_of(instance)
            if process is not None:
                state.update(instance, trouble=state.trouble_of(instance, process))
        elif instance in state.components:
            state.update(instance, zombie=f"{why}; {text}")
            state.kept.lost(state.components[instance])

    def _bring_back(self, instances: Collection[str], wait_s: float, why: str) -> Procedure:
        """Make components again after a while, unless somebody has done so or ended them."""
        state = self._state
        failures: list[str] = []

        def failed(what: str, error: RtkitError) -> None:
            failures.append(f"cannot {what}: {error}")
            _log.error("%s", failures[-1])

        try:
            yield Pause(wait_s)
            still = [each for each in instances if self._is_missed(each)]
            for instance in still:
                if lives(state, instance):
                    yield from _take_down(state, instance)
            yield from revive(state, still, failed)
        finally:
            state.returning.difference_update(instances)
            state.unwell.difference_update(instances)
        now = yield Clock()
        for instance in still:
            if lives(state, instance):
                self._note(instance, why)
                self.heard(state.components[instance], now)
        dead = [each for each in still if not lives(state, each) and self._is_missed(each)]
        self.lost(dead, failures[0] if failures else "it ended at its start", now)
        return Result()

    def _is_missed(self, instance: str) -> bool:
        """Whether a component is wished for and there is nothing of use."""
        state = self._state
        if instance not in state.kept.components:
            return False
        if instance in state.ending or instance in state.claims:
            return False
        is_bad = instance in state.unwell or not lives(state, instance)
        return is_bad or _is_in_error(state.components[instance])

    def _note(self, instance: str, why: str) -> None:
        state = self._state
        watched = state.watched.get(instance, Watched())
        made = state.components[instance].restarts  # also those that ended before they were done
        watched = replace(watched, restarts=max(watched.restarts + 1, made), why=why)
        state.watched[instance] = watched
        state.update(instance, restarts=watched.restarts, restarted_for=why)
        _log.warning("%s was made again (%d.): %s", instance, watched.restarts, why)


def _ignore(_result: Result) -> None:
    """Nobody waits for a restart; but when the manager stops, it is broken off."""


def _spread(instance: str, count: int) -> float:
    """Return a number from -1 to 1 that differs between components, so that they do not crowd."""
    return crc32(f"{instance} {count}".encode()) / 0x7FFFFFFF - 1.0


def _is_in_error(facts: ComponentFacts) -> bool:
    return any(context.state is LifeCycleState.ERROR for context in facts.contexts)


def _take_down(state: State, instance: str) -> Generator[Yielded, Any, None]:
    """End a component that is in Error, its process where that does not work; its wish stays."""
    process = state.process_of(instance)
    if process is None:
        return
    state.ending.add(instance)
    try:
        yield Ask(process, {"op": "delete", "instance": instance}, FORCE_S)
        state.forget(instance)
    except Unreachable as error:
        if process.is_slave and process.is_alive:
            process.verdict = f"ended, since {instance} was in Error and did not end: {error}"
            yield from end_slaves([process], grace_s(state))
    finally:
        state.ending.discard(instance)


def _stop_system(state: State, critical: Collection[str], why: str) -> Procedure:
    """Deactivate all components, the last made first: it is not safe to go on without one."""
    _log.error("critical: %s; the system is stopped (%s)", ", ".join(critical), why)
    for instance in critical:
        state.kept.change(instance, active=())
    for instance in reversed(list(state.components)):
        facts = state.components.get(instance)
        if facts is not None and not facts.zombie:
            yield from bring_to_rest(state, instance)
    return Result()


def bring_to_rest(state: State, instance: str) -> Procedure:
    """Deactivate a component where it is active."""
    for context in state.components[instance].contexts:
        if context.state is LifeCycleState.ACTIVE:
            rest = act.ChangeState(instance, context.id, Transition.DEACTIVATE)
            try:
                yield from procedure_for(rest, state)
            except RtkitError as error:
                _log.error("cannot deactivate %s: %s", instance, error)
    return Result()
