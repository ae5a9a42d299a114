"""Ends components whose device goes, and makes them again when it appears.

A component that waits for a device is a zombie that says so: its desired state is kept, and a user
may end it. The shell looks at devices and reports which are absent; everything else follows from
the state, so that it does not matter when the manager was restarted.
"""

from __future__ import annotations

import logging
from collections.abc import Collection

from rtkit.deployment.actions import Result
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.listing import device_absence, is_device_absence
from rtkit.errors import RtkitError
from rtkit.fast_dataclass import replace
from rtkit.manager.core import adoption
from rtkit.manager.core import events as ev
from rtkit.manager.core.deletion import retire
from rtkit.manager.core.effects import Procedure, ReadClock, Sleep
from rtkit.manager.core.recovery import RESTORE_S, lives, revive
from rtkit.manager.core.state import ManagerState
from rtkit.manager.core.supervisor import BREATH_S, Supervisor, take_down
from rtkit.manager.core.tasks import Tasks, ignored
from rtkit.rtc.create import readable_create
from rtkit.rtc.profiles import TypeProfile

_log = logging.getLogger(__name__)


class DeviceKeeper:
    """Compares what components require with the devices that are there."""

    def __init__(self, state: ManagerState, tasks: Tasks, supervisor: Supervisor) -> None:
        self._state = state
        self._tasks = tasks
        self._supervisor = supervisor
        self._busy: set[str] = set()

    def seen(self, event: ev.DevicesSeen) -> None:
        """Take note of which of the required devices are absent."""
        self._state.absent = frozenset(event.absent)
        self._state.unjudged.clear()

    def run(self, _now: float) -> None:
        """Begin what has to be done, once it is known what lives."""
        state = self._state
        if self._supervisor.is_early:
            return
        if not state.bound.keys() <= state.kept.components.keys():  # whose devices are looked at
            state.bound = {k: v for k, v in state.bound.items() if k in state.kept.components}
        come = []
        for instance, devices in state.bound.items():
            missing = next((each for each in devices if each in state.absent), "")
            is_held = instance in self._busy or instance in state.ending or instance in state.claims
            if is_held or instance in state.unjudged:
                continue
            watched = state.watched(instance)
            waits = is_device_absence(watched.pending)
            if missing and (not waits or lives(state, instance)):
                if not watched.ledger.is_given_up:
                    self._lost(instance, device_absence(missing))
            elif waits and not missing:
                come.append(instance)
        if come:
            self._busy.update(come)
            self._tasks.begin(self._bring_back(come), RESTORE_S, ignored)

    def _lost(self, instance: str, why: str) -> None:
        """Have a component wait for its device, and end it if it lives."""
        state = self._state
        state.returning.add(instance)
        state.watch(instance, pending=why)
        if not lives(state, instance):
            self._show(instance, why)
            return
        if self._supervisor.policy(instance).is_critical:
            self._supervisor.stop_all([instance], why)
        self._busy.add(instance)
        self._tasks.begin(self._end(instance, why), RESTORE_S, ignored)

    def _end(self, instance: str, why: str) -> Procedure:
        state = self._state
        facts, process = state.components[instance], state.process_of(instance)

        def failed(what: str, error: RtkitError) -> None:
            _log.error("cannot %s: %s", what, error)

        try:
            yield from take_down(state, instance, why, failed)
            if not lives(state, instance):
                _log.warning("%s was ended: %s", instance, why, extra={"about": instance})
                self._show(instance, why, facts)
                if process is not None:
                    yield from retire(state, process)
        finally:
            self._busy.discard(instance)
        return Result()

    def _show(self, instance: str, why: str, facts: ComponentFacts | None = None) -> None:
        """Show a component as a zombie that waits, also to the next manager."""
        state = self._state
        if instance not in state.components:
            row = state.kept.components[instance]
            create = readable_create(row.create)
            known = facts or ComponentFacts(
                instance,
                TypeProfile(create.implementation_id),
                create.place or state.name,
                names=row.names,
                create=row.create,
            )
            contexts = tuple(replace(each, participants=()) for each in known.contexts)
            shown = replace(known, zombie=why, trouble="", contexts=contexts)
            process = self._tasks.new_process(known.process)
            process.state, process.reason = "lost", why
            adoption.take_missed(state, process, adoption.Holding([shown], []))
        state.update(instance, zombie=why)
        state.report_restart_status(instance)
        state.kept.lost(state.components[instance])

    def _bring_back(self, instances: Collection[str]) -> Procedure:
        """Make components again whose devices are there."""
        state = self._state
        failures: list[str] = []

        def failed(what: str, error: RtkitError) -> None:
            failures.append(f"cannot {what}: {error}")
            _log.error("%s", failures[-1])

        began: float = yield ReadClock()
        try:
            missing = [each for each in instances if each in state.kept.components]
            yield from revive(state, missing, failed)
            yield Sleep(BREATH_S)
        finally:
            self._busy.difference_update(instances)
            state.returning.difference_update(instances)
        now: float = yield ReadClock()
        dead = []
        for instance in filter(state.kept.components.__contains__, instances):
            why = state.watched(instance).pending
            state.watch(instance, pending="", took_s=round(now - began, 6))
            if lives(state, instance):
                _log.warning("%s was made again: its device is there", instance)
            else:
                dead.append(instance)
                state.update(instance, zombie=failures[0] if failures else why)
        self._supervisor.lost(dead, failures[0] if failures else "it ended at its start", now)
        return Result()
