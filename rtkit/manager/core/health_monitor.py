"""Monitors the health rules of components once a second, and runs the actions of broken rules.

Callbacks that are stuck are found by `rtkit.manager.slaves.watchdog`.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

from rtkit.deployment.actions import Result
from rtkit.deployment.health import IN_DEBUGGER, HealthRule, Reaction, Sample, broken, read_rules
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.manager.core.deletion import HANGING_S, end_slaves
from rtkit.manager.core.effects import Procedure, ReadClock, Sleep
from rtkit.manager.core.recovery import lives
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.supervisor import Supervisor, bring_to_rest
from rtkit.manager.core.tasks import Tasks
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import LifeCycleState

_log = logging.getLogger(__name__)
_STOP_S = 5.0
"""How long a component that is not well may take to come to rest [s]."""
_LINE_S = 0.15
"""How long to wait until it is known at which line a callback is stuck [s]."""


class HealthMonitor:
    """Observations of components with health rules, and the rules that they break."""

    def __init__(self, state: ManagerState, supervisor: Supervisor, tasks: Tasks) -> None:
        self._state = state
        self._supervisor = supervisor
        self._tasks = tasks
        self._samples: dict[str, Sample] = {}
        self._broken: dict[tuple[str, HealthRule], str] = {}

    @property
    def is_needed(self) -> bool:
        """Return whether any component has rules."""
        return bool(self._state.ruled)

    def judge(self, answers: Mapping[int, Sequence[ComponentMetrics]], now: float) -> None:
        """Judge all that have rules by the metrics of their processes, at `now` [s]."""
        state = self._state
        metrics = {each.instance: each for every in answers.values() for each in every}
        for instance in sorted(state.ruled):
            desired = state.kept.components.get(instance)
            if desired is None:
                state.ruled.discard(instance)
            if desired is None or instance in state.returning or not lives(state, instance):
                self._forget(instance)
                continue
            sample = self._sample(instance, metrics.get(instance), now)
            before = self._samples.get(instance)
            self._samples[instance] = sample
            rules = read_rules(parse_create(desired.create).options)
            self._react(instance, dict(broken(rules, before, sample)), now)

    def stuck(self, instance: str, now: float, *, is_all_known: bool) -> None:
        """Judge at once one of which a callback does not come back.

        If its line is not known yet, that is waited for, but not for long.
        """
        if is_all_known:
            self._judge_stuck(instance, now)
        elif instance in self._state.ruled:
            self._tasks.begin(self._judge_soon(instance), _LINE_S)

    def _judge_soon(self, instance: str) -> Procedure:
        yield Sleep(_LINE_S)
        self._judge_stuck(instance, (yield ReadClock()))
        return Result()

    def _judge_stuck(self, instance: str, now: float) -> None:
        state = self._state
        desired, why = (
            state.kept.components.get(instance),
            _stuck(state.process_of(instance), instance),
        )
        if desired is None or not why or instance in state.returning or not lives(state, instance):
            return
        for rule in read_rules(parse_create(desired.create).options):
            if rule.kind == "stuck":
                self._break(instance, rule, why, now)
                self._report(instance)

    def _sample(self, instance: str, metrics: ComponentMetrics | None, now: float) -> Sample:
        state = self._state
        facts, process = state.components[instance], state.process_of(instance)
        contexts = facts.contexts
        return Sample(
            at_s=now,
            is_active=metrics is not None
            and any(each.state is LifeCycleState.ACTIVE for each in contexts),
            metrics=metrics or ComponentMetrics(instance),
            values=facts.sets.get(facts.active_set, {}),
            stuck=_stuck(process, instance),
        )

    def _react(self, instance: str, now_broken: Mapping[HealthRule, str], now: float) -> None:
        for key in [each for each in self._broken if each[0] == instance]:
            if key[1] not in now_broken:
                del self._broken[key]
                _log.info("%s is well again (%s)", instance, key[1].kind)
        for rule, why in now_broken.items():
            self._break(instance, rule, why, now)
        self._report(instance)

    def _break(self, instance: str, rule: HealthRule, why: str, now: float) -> None:
        """Note that a rule is broken; run its action if it was not before."""
        is_new = (instance, rule) not in self._broken
        self._broken[instance, rule] = why
        if is_new:
            self._act(instance, rule, why, now)

    def _report(self, instance: str) -> None:
        degraded = [why for (i, r), why in self._broken.items() if (i, r.reaction) == _of(instance)]
        self._state.degraded[instance] = degraded[0] if degraded else ""
        self._state.report_restart_status(instance)

    def _act(self, instance: str, rule: HealthRule, why: str, now: float) -> None:
        _log.warning("%s is not well: %s (%s)", instance, why, rule.reaction.value)
        if rule.reaction is Reaction.RESTART:
            if self._end_process(instance, rule, why):
                return
            self._state.unwell.add(instance)
            self._supervisor.lost([instance], f"not well: {why}", now)
            if instance in self._state.returning:
                self._forget(instance)  # it begins anew
            else:
                self._state.unwell.discard(instance)
        elif rule.reaction is Reaction.STOP:
            if self._supervisor.policy(instance).is_critical:
                self._supervisor.stop_all([instance], why)
            else:
                self._state.watch(instance, rested=why)
                self._tasks.begin(bring_to_rest(self._state, instance), _STOP_S)

    def _end_process(self, instance: str, rule: HealthRule, why: str) -> bool:
        """End the slave of one that is stuck, as nothing else ends it; return whether that is so.

        Its loss decides what is restarted after that.
        """
        process = self._state.process_of(instance)
        if rule.kind != "stuck" or process is None or not process.is_slave:
            return False
        if self._supervisor.wants(instance, why):
            self._forget(instance)  # it begins anew
            process.verdict = f"{instance} was {why}"
            self._tasks.begin(end_slaves([process], HANGING_S), _STOP_S)
        return True

    def _forget(self, instance: str) -> None:
        self._samples.pop(instance, None)
        self._state.degraded.pop(instance, None)
        self._state.report_restart_status(instance)
        for key in [each for each in self._broken if each[0] == instance]:
            del self._broken[key]


def _of(instance: str) -> tuple[str, Reaction]:
    return instance, Reaction.DEGRADE


def _stuck(process: Process | None, instance: str) -> str:
    """Return which callback does not come back in a process that is not being ended.

    One that a debugger has stopped comes back when its user is done: rules wait.
    """
    why = process.stuck.get(instance, "") if process is not None and process.is_wanted else ""
    return "" if why.startswith(IN_DEBUGGER) else why
