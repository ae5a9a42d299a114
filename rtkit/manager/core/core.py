"""Core of the daemon: events in, instructions out; the only place where its state changes.

Each action of a client runs as a *procedure*, a generator that yields what it waits for (see
`rtkit.manager.core.procedures`). No thread, socket or clock is known here: time comes in as an
argument.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.deployment.delta import TREE
from rtkit.deployment.metrics import METRICS
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable
from rtkit.manager.core import adoption, manager_properties, modules
from rtkit.manager.core import events as ev
from rtkit.manager.core.batches import STOPPING, Batches
from rtkit.manager.core.change_feed import ChangeFeed
from rtkit.manager.core.deletion import FINALISE_S, TERM_S, retire, stop_everything
from rtkit.manager.core.devices import DeviceKeeper
from rtkit.manager.core.durable_replies import DurableReplies
from rtkit.manager.core.follows import Follows
from rtkit.manager.core.health_monitor import HealthMonitor
from rtkit.manager.core.limiting import Limiting
from rtkit.manager.core.meetings import Meetings
from rtkit.manager.core.metrics import MetricsCollector
from rtkit.manager.core.modules import TRIAL
from rtkit.manager.core.recovery import RESTORE_S, note_loss, repair, restore
from rtkit.manager.core.required_devices import note_devices
from rtkit.manager.core.state import ManagerState, Process
from rtkit.manager.core.supervisor import Supervisor
from rtkit.manager.core.tasks import Tasks
from rtkit.property.exchange import Reply
from rtkit.rtc.profiles import ConnectorProfile


class Core:
    """Manager without its shell.

    Attributes:
        state: Its knowledge.
    """

    DERIVED = ("_reactions",)

    def __init__(self, state: ManagerState) -> None:
        self.state = state
        self._out: list[ev.Instruction] = []
        self._tasks = Tasks(state, self._out)
        self._keeping = DurableReplies(state, self._out, self._tasks)
        self._supervisor = Supervisor(state, self._tasks)
        self._batches = Batches(state, self._out, self._tasks, self._keeping, self._supervisor)
        self._announcer = ChangeFeed(state, self._out)
        self._devices = DeviceKeeper(state, self._tasks, self._supervisor)
        self._limiting = Limiting(state, self._out, self._tasks)
        self._health_monitor = HealthMonitor(state, self._supervisor, self._tasks)
        self._survey = MetricsCollector(
            state, self._out, self._announcer.run_id, self._health_monitor
        )
        self._meetings = Meetings(state, self._out, self._tasks, self._keeping)
        self._follows = Follows(state, self._out, self._keeping)
        self._listeners: dict[str, set[str]] = {}
        self._is_stopping = False
        self._now = 0.0
        self._is_restoring = False
        self._reactions = self._all_reactions()

    @property
    def is_idle(self) -> bool:
        """Return whether nothing is under way."""
        return self._tasks.is_idle and self._keeping.is_idle

    @property
    def is_at_rest(self) -> bool:
        """Return whether its state can be copied: nothing is under way, nor left by a fault."""
        return self.is_idle and not self._out

    def resume(self) -> None:
        """Derive what a checkpoint leaves out, from the state that was put in."""
        self._announcer.resume()

    def handle(self, event: ev.Event, now: float) -> list[ev.Instruction]:
        """Take one event at monotonic time `now` [s] and return what is to be done.

        Raises:
            Malformed: A container reported what cannot be read; nothing is changed.
        """
        self._now = self._batches.now = now
        self._reactions[type(event)](event)
        self._tasks.run(now)
        self._meetings.run(now)
        self._devices.run(now)
        until = self._survey.run(now)
        self._tasks.run_new(now)  # what metrics have given cause for
        self._limiting.run()
        self._keeping.run(now)
        if until is not None:
            self._out.append(ev.WakeAt(until))
        self._announcer.run()
        out = list(self._out)
        self._out.clear()
        return out

    def _all_reactions(self) -> Mapping[type[ev.Event], Callable[[Any], object]]:
        """Return what is done at each kind of event."""
        return {
            ev.BatchRequested: self._batches.take,
            ev.SnapshotRequested: lambda event: self._announcer.send_picture(event.request),
            ev.ListenersChanged: self._listened,
            ev.FollowAsked: self._follow,
            ev.FollowSaid: self._follows.take_report,
            ev.OperationRequested: self._batches.operate,
            ev.PeerAsked: self._meetings.asked,
            ev.PeerAnswered: self._tasks.peer_answered,
            ev.PeerFound: self._meetings.found,
            ev.PeerLost: self._meetings.lost,
            ev.ContainerReported: self._on_report,
            ev.SlaveForked: self._forked,
            ev.SlaveReady: lambda event: self._ready(event.key),
            ev.SlaveFound: self._found,
            ev.SlaveExitedUnseen: self._missed,
            ev.SlaveEnded: self._ended,
            ev.SlaveFailed: self._ended,
            ev.SpawnDisabled: lambda event: setattr(self.state, "barred", event.why),
            ev.SlaveStopped: lambda event: self._halted(event.key, event.is_halted),
            ev.SlaveOverLimit: lambda event: self._limiting.reached(event.key, event.why),
            ev.DevicesSeen: self._devices.seen,
            ev.CallbackStuck: self._stuck,
            ev.ProcessInspected: lambda event: self._tasks.inspected(event.key),
            ev.StoreRead: self._remember,
            ev.RecoveryRequested: lambda event: self._restore(event.request),
            ev.StartStepDone: lambda event: self.state.kept.put("begun", event.step, "done"),
            ev.RowsStored: self._keeping.kept,
            ev.StopRequested: self._stop,
            ev.TimerExpired: lambda _event: None,
        }

    def _listened(self, event: ev.ListenersChanged) -> None:
        listeners = self._listeners.setdefault(event.line, set())
        (listeners.add if event.is_heard else listeners.discard)(event.who)
        if event.line == TREE:
            self._announcer.listen(bool(listeners))
        elif event.line == METRICS:
            self._survey.listen(bool(listeners))

    def _follow(self, asked: ev.FollowAsked) -> None:
        if self._is_stopping:
            self._out.append(ev.AnswerClient(asked.request, Reply(STOPPING, Refused.kind)))
        else:
            self._follows.ask(asked)

    # desired state

    def _remember(self, event: ev.StoreRead) -> None:
        state = self.state
        self._announcer.hold()
        bad = state.kept.read(event.rows)
        state.remark = event.remark
        if bad:
            state.remark = "; ".join([*filter(None, [event.remark]), f"not understood: {bad[0]}"])
        for key, value in state.kept.settings.items():
            with suppress(RtkitError):  # a property that there is no more
                state.settings.change(key, value)
        self._batches.recall()
        is_same_boot = state.kept.begin_life(event.boot)
        state.kept.name_store(event.life)
        self._supervisor.recall(is_same_boot=is_same_boot)
        for instance, desired in state.kept.components.items():
            note_devices(state, instance, desired.create)
        for facts in list(state.kept.zombies.values()):
            if is_same_boot:
                process = self._tasks.new_process(facts.process)
                process.state, process.reason = "lost", facts.zombie
                adoption.take_missed(state, process, adoption.Holding([facts], []))
            else:
                state.kept.drop("zombie", facts.instance)

    def _restore(self, request: int) -> None:
        self._announcer.release()

        def answer(results: list[Result]) -> None:
            self._out.append(ev.AnswerClient(request, Reply(results[0].value)))

        def done(result: Result) -> None:
            self._keeping.finish([act.Tick("", "")], [result], answer)

        self._is_restoring = self._meetings.is_open = True  # who reports from now on is late
        self._tasks.begin(restore(self.state, self._resume), RESTORE_S, done)

    def _resume(self, now: float) -> None:
        """Go on where an earlier manager was."""
        self._supervisor.resume(now)
        self._devices.run(now)

    # reports of processes

    def _on_report(self, event: ev.ContainerReported) -> None:
        message, process = event.message, self.state.processes.get(event.key)
        if process is None or not process.is_alive:
            return  # sent before it died, received after
        if "reply" in message:
            self._tasks.take_answer(process.key, message)
        elif "facts" in message:
            facts = adoption.take_report(self.state, process, message["facts"])
            self._limiting.on_facts(facts)
            self._supervisor.on_facts(facts, self._now)
            for connector in self.state.connectors_of(facts.instance):
                ends = [end for end in connector.ports if end.instance == facts.instance]
                if any(facts.port(end.port) is None for end in ends):
                    self._cut(connector)
        elif "metrics" in message:
            self._survey.take_report(process, message["metrics"])
        elif "loaded" in message:
            modules.take_all(self.state, process, message["loaded"])
        elif "gone" in message:
            self._gone(process, message["gone"])
        else:
            raise Malformed(f"unknown report from {process.name}: {sorted(map(str, message))}")

    def _gone(self, process: Process, instance: object) -> None:
        if not isinstance(instance, str):
            return
        if self.state.containers.get(instance) == process.key:
            for connector in self.state.connectors_of(instance):
                self._cut(connector)
            self.state.forget(instance)
        if instance not in self.state.ending and not self._is_stopping:
            self.state.kept.forget(instance)
            self._tasks.begin(retire(self.state, process), TERM_S)

    def _forked(self, event: ev.SlaveForked) -> None:
        process = self.state.processes.get(event.key)
        if process is None or not process.is_alive:
            return
        process.pid = event.pid
        process.name = process.name.replace("%p", str(event.pid))
        self._end_unwanted(process)

    def _ready(self, key: int) -> None:
        process = self.state.processes.get(key)
        if process is None or process.state != "starting":
            return
        process.state = "up"
        if not self._end_unwanted(process):
            if manager_properties.is_needed(self.state):
                self._configure(process)
            self._tasks.process_is_up(process)

    def _configure(self, process: Process) -> None:
        message = manager_properties.message(self.state)
        self._out.append(ev.SendToContainer(process.key, message))

    def _found(self, event: ev.SlaveFound) -> None:
        """Believe a process about what it holds; what contradicts the living, it is to drop."""
        holding = adoption.read(event.name, event.components, event.wires, event.asked)
        process = adoption.process_of(self.state, event.pid)
        if process is None:
            name = adoption.free_name(self.state, event.name, event.pid)
            process = self._tasks.new_process(name, event.pid)
            process.is_guest = event.is_guest
        if event.name == TRIAL:  # nobody waits for its import check any more
            process.trial_of, process.is_wanted = TRIAL, False
        was_silent, process.silence = bool(process.silence), event.silence
        process.state = "silent" if event.silence else "up"
        self._out.append(ev.AdoptSlave(process.key, event.pid, process.is_guest))
        if event.silence:
            adoption.take_unsaid(self.state, process, holding)
            self._end_unwanted(process)
            return
        if process.is_slave:
            is_needed = manager_properties.has_other(self.state, event.configured)
        else:
            is_needed = manager_properties.is_needed(self.state)
        if is_needed:
            self._configure(process)
        for message in adoption.take(self.state, process, holding):
            self._out.append(ev.SendToContainer(process.key, message))
        adoption.believe(self.state, process, holding)
        for connector in adoption.absent_wires(self.state, process, holding) if was_silent else ():
            self._cut(connector)
        if process.is_guest:
            welcome = {"welcome": self.state.held_by(process.key)}
            self._out.append(ev.SendToContainer(process.key, welcome))
        process.is_wanted &= not self._is_stopping
        self._end_unwanted(process)
        self._tasks.begin(adoption.cut_loose(self.state, process), adoption.SETTLE_S)
        if self._is_restoring:
            held = self.state.held_by(process.key)
            self._tasks.begin(repair(self.state, held), RESTORE_S)
        self._tasks.begin(retire(self.state, process), adoption.SETTLE_S)

    def _missed(self, event: ev.SlaveExitedUnseen) -> None:
        holding = adoption.read(event.name, event.components, [])
        name = adoption.free_name(self.state, event.name, event.pid)
        process = self._tasks.new_process(name, event.pid)
        process.state, process.reason = "lost", event.reason
        adoption.take_missed(self.state, process, holding)
        held = self.state.held_by(process.key)
        for instance in held:
            self.state.update(instance, since=event.time)
        if event.is_seen:
            for instance in held:
                self.state.kept.lost(self.state.components[instance])
            self._supervisor.lost(held, event.reason, self._now)

    def _end_unwanted(self, process: Process) -> bool:
        """End a slave that came when nobody waited for it any more."""
        if not process.is_wanted and process.is_slave:
            self._out.append(ev.SignalSlave(process.key, signal.SIGKILL))
        return not process.is_wanted

    def _ended(self, event: ev.SlaveEnded | ev.SlaveFailed) -> None:
        process = self.state.processes.get(event.key)
        if process is None or not process.is_alive:
            return
        process.state, process.reason = "lost", process.verdict or event.reason
        process.last = event.last if isinstance(event, ev.SlaveEnded) else ""
        process.silence = ""
        self.state.drop_loose(process.key)
        self._release_slave(process, getattr(event, "time", 0.0))
        self.state.drop_if_empty(process.key)
        self._tasks.process_ended(process)

    def _release_slave(self, process: Process, at: float) -> None:
        lost = []
        for instance in self.state.held_by(process.key):
            for connector in self.state.connectors_of(instance):
                self._cut(connector)
            if (process.is_wanted or process.verdict) and not process.is_guest:
                self.state.drop_connectors(instance)
                self.state.update(instance, zombie=process.reason, trouble="", since=at)
                self._tasks.begin(note_loss(self.state, instance), RESTORE_S)
                lost.append(instance)
            else:
                self.state.forget(instance)
                if process.is_guest:
                    self.state.kept.forget(instance)
        if not self._is_stopping:
            self._supervisor.lost(lost, process.reason, self._now)

    def _cut(self, connector: ConnectorProfile) -> None:
        """Drop a connector and take it off the ends that live."""
        self.state.cut(connector.connector_id)
        ends = {self.state.containers.get(end.instance) for end in connector.ports}
        for process in list(self.state.processes.values()):
            if process.key in ends and process.is_ready:
                message = {"op": "unlink", "connector_id": connector.connector_id}
                self._out.append(ev.SendToContainer(process.key, message))

    def _halted(self, key: int, is_halted: bool) -> None:
        process = self.state.processes.get(key)
        if process is not None and process.state == "starting" and is_halted:
            self._give_up_spawn(process)
        if process is None or not (process.is_ready or process.silence):
            return
        if process.silence:
            process.silence = "stopped" if is_halted else "does not answer"
        else:
            process.state = "stopped" if is_halted else "up"
        if is_halted and self._is_stopping:
            self._tasks.give_up(Unreachable(process.unfit), key)
        for instance in self.state.held_by(key):
            self.state.update(instance, trouble=self.state.trouble_of(instance, process))

    def _give_up_spawn(self, process: Process) -> None:
        """End a slave that was stopped before it connected: nobody has use for it."""
        process.is_wanted = False
        self._out.append(ev.SignalSlave(process.key, signal.SIGKILL))
        why = f"slave {process.name} was stopped before it was ready, and is ended"
        self._tasks.give_up_on(process, Unreachable(why))

    def _stuck(self, event: ev.CallbackStuck) -> None:
        process, instance = self.state.processes.get(event.key), event.instance
        if process is None or not process.is_alive:
            return
        if event.text:
            process.stuck[instance] = event.text
        else:
            process.stuck.pop(instance, None)
        if self.state.containers.get(instance) == event.key:
            self.state.update(instance, trouble=self.state.trouble_of(instance, process))
            self._supervisor.on_facts(self.state.components[instance], self._now)
            self._health_monitor.stuck(instance, self._now, is_all_known=event.is_all)

    # the end

    def _stop(self, event: ev.StopRequested) -> None:
        is_kept = event.is_kept
        if not self._is_stopping:
            self._is_stopping = self._batches.is_stopping = True
            self._meetings.is_open = False
            self._keeping.stop(is_kept=is_kept)
            if not is_kept:
                self._out.append(ev.RemoveStore())
            self._tasks.cancel(Refused(STOPPING))
            self._tasks.begin(stop_everything(self.state), FINALISE_S, self._stopped)
        if event.is_urgent:
            self._hurry()

    def _hurry(self) -> None:
        """Kill all slaves, and wait for nobody else."""
        self.state.is_in_haste = True
        for process in self.state.processes.values():
            if process.is_slave and process.is_alive:
                process.is_wanted = False
                self._out.append(ev.SignalSlave(process.key, signal.SIGKILL))
        self._tasks.give_up(Unreachable(STOPPING))

    def _stopped(self, _result: Result) -> None:
        self._announcer.end()
        self._out.append(ev.ExitDaemon())
