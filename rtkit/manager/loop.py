"""Runs the manager's loop thread: feeds the core with events, carries its instructions out."""

from __future__ import annotations

import json
import logging
import os
import queue
import selectors
import signal
import socket
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import NamedTuple

from rtkit import fault
from rtkit.container.container import ComponentContainer
from rtkit.container.exit_diagnostics import exit_diagnostics
from rtkit.deployment.delta import TREE
from rtkit.deployment.message import Message
from rtkit.deployment.metrics import METRICS
from rtkit.deployment.port_samples import SAMPLES
from rtkit.deployment.terminal import TERMINAL
from rtkit.errors import RtkitError
from rtkit.fast_dataclass import replace
from rtkit.link import zenoh_keys
from rtkit.link.requests.server import RequestServer
from rtkit.link.transport import Link
from rtkit.manager.core import events as ev
from rtkit.manager.core.core import Core
from rtkit.manager.core.event_ring import CORE, EventRing
from rtkit.manager.core.requests import NOBODY, PendingRequests
from rtkit.manager.device_watch import DeviceWatch
from rtkit.manager.duty import Duty
from rtkit.manager.fault_guard import FaultGuard, header, select_but, text_of
from rtkit.manager.following.following import Following
from rtkit.manager.host_link_processes import HostLinkProcesses
from rtkit.manager.limits.usage import usage
from rtkit.manager.peers.peers import Peers
from rtkit.manager.port_sampler import PortSampler
from rtkit.manager.process_monitor import ProcessMonitor
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.manager.service_notifier import ServiceNotifier
from rtkit.manager.slaves.slave_connections import SlaveConnections
from rtkit.manager.slaves.slave_supervisor import SlaveSupervisor
from rtkit.manager.store.writer import StoreWriter
from rtkit.manager.terminal_relay import TerminalRelay
from rtkit.property.exchange import Reply, Request, failure

_log = logging.getLogger(__name__)
_WAKES = 4096
_LONG_S = 3600.0
"""The longest sleep; a selector takes no arbitrarily long one [s]."""
_BREATH_S = 0.01
"""How long the loop rests when it cannot wait for anything [s]."""
_AFTER_FAULT_S = 1.0
"""How long after a fault of the core it goes on with what it has left [s]."""


class _Failed(NamedTuple):
    """A fault on another thread."""

    work: str
    error: BaseException


class Loop:
    """Owns the core; everybody else only enqueues (`post`).

    Attributes:
        requests: Requests whose clients wait for answers.
        query_server: Where requests are taken.
        following: Follows the events of systems.
        links: Links to other hosts.
        peers: Managers at other ends of connectors.
        connections: To slaves and zygotes.
        notifier: Reports to the service manager that started this one, if one did.
        wake_descriptor: A byte at it wakes the loop, for `signal.set_wakeup_fd`.
        has_failed: The manager ends because its start failed.
    """

    def __init__(
        self,
        core: Core,
        container: ComponentContainer,
        slave_supervisor: SlaveSupervisor,
        listener: socket.socket,
        keeper: StoreWriter,
    ) -> None:
        self._core = core
        self._ring = EventRing(core)
        self._guard = FaultGuard(core.state, self._ring)
        self._keeper = keeper
        keeper.failed = self.note_fault
        keeper.stored = lambda *outcome: self.post(ev.RowsStored(*outcome))
        self.requests = PendingRequests()
        self.query_server = ManagerQueryServer(core.state, self.requests)
        self.following = Following(self.post, core.state, self.requests, self.note_fault)
        self.query_server.follow = self.following.ask
        self.query_server.dump = self._dump
        self.query_server.events = self._ring.about
        self.links = HostLinkProcesses(core.state)
        self.has_failed = False
        self.notifier = ServiceNotifier(core.state, {})
        self._container = container
        self._slave_supervisor = slave_supervisor
        self._inbox: queue.SimpleQueue[ev.Event | Request | _Failed] = queue.SimpleQueue()
        self._wake_at: float | None = None
        self._processes = ProcessMonitor(
            core.state, slave_supervisor, self._handle, self.post, self._send
        )
        self._devices = DeviceWatch(self._handle)
        self.peers = Peers(core.state, self.post, self.requests.add, self.note_fault)
        self._sampler = PortSampler(core.state, self._send)
        self.query_server.sample = self._sampler.ask
        self._terminals = TerminalRelay(core.state, self._send)
        self.query_server.ask_terminal = self._terminals.ask
        self._announce: dict[str, Callable[[str], object]] = {}
        self._is_finished = self._is_closed = False
        self._selector = selectors.DefaultSelector()
        self._wake_read, self.wake_descriptor = os.pipe()
        for descriptor in (self._wake_read, self.wake_descriptor):
            os.set_blocking(descriptor, False)
        self._selector.register(self._wake_read, selectors.EVENT_READ, lambda _mask: self._drain())
        self.connections = SlaveConnections(
            self._selector, listener, slave_supervisor, self._handle
        )
        self._duties = self._all_duties()

    def post(self, item: ev.Event | Request | _Failed) -> None:
        """Hand in an event or a request, from any thread."""
        self._inbox.put(item)
        if not self._is_closed:
            with suppress(BlockingIOError):  # it is awake already
                os.write(self.wake_descriptor, b"x")

    def end_with(self, pidfd: int) -> None:
        """Ask for the end of the manager as soon as a process has ended."""

        def end(_mask: int) -> None:
            self._selector.unregister(pidfd)
            self.post(ev.StopRequested())

        self._selector.register(pidfd, selectors.EVENT_READ, end)

    def note_fault(self, work: str, error: BaseException) -> None:
        """Take note of a fault on another thread, from there."""
        self.post(_Failed(work, error))

    def recall(self, remembered: ev.StoreRead) -> None:
        """Pass the store of an earlier manager to the core, before anything else."""
        self._handle(remembered)

    def take_requests_at(self, path: str) -> Callable[[], object]:
        """Take requests of commands at a socket; return what ends that.

        Raises:
            OSError: It cannot be made.
        """
        server = RequestServer(path, lambda asked: self._guard.run("request", self._serve, asked))
        self._selector.register(server, selectors.EVENT_READ, lambda _mask: server.turn())
        return server.close

    def open_lines(self, link: Link, service: str) -> None:
        """Publish on the manager's topics, from now on, what the core wants published."""
        for line in (TREE, METRICS):
            listened = partial(self._listened, line)
            self._announce[line] = link.announce(zenoh_keys.line_key(service, line), listened)

    def run(self) -> None:
        """Work until the core reports that all is done; no fault in a duty ends that."""
        while not self._is_finished:
            for key, mask in self._guard.run("waiting", self._select) or ():
                self._guard.run(f"socket {key.fd}", self._exchange, key.data, mask)
            self._guard.run("inbox", self._take_inbox)
            for duty in self._duties:
                self._guard.run(duty.name, self._do, duty)

    def _do(self, duty: Duty) -> None:
        if not self._guard.is_paused(duty.name) and duty.is_due(time.monotonic()):
            fault.point(f"duty.{duty.name}")
            duty.work()

    def _select(self) -> list[tuple[selectors.SelectorKey, int]]:
        if self._guard.is_paused("waiting"):
            time.sleep(_BREATH_S)
        fault.point("duty.waiting")
        can_be_woken = not self._is_left_alone(self._wake_read)
        wait_s = self._wait_s() if can_be_woken else _BREATH_S
        return select_but(self._selector, self._is_left_alone, wait_s)

    def _is_left_alone(self, descriptor: int) -> bool:
        """Return whether what was due at a descriptor failed just before."""
        return self._guard.is_paused(f"socket {descriptor}")

    def _exchange(self, react: Callable[[int], object], mask: int) -> None:
        fault.point("duty.socket")
        react(mask)

    def close(self) -> None:
        """Let go of all descriptors; what is posted from now on is not received."""
        self._is_closed = True
        self.following.close()
        self.links.close()
        self.peers.close()
        self._selector.close()
        self.connections.close()
        self._processes.close()
        for descriptor in (self._wake_read, self.wake_descriptor):
            os.close(descriptor)

    def _all_duties(self) -> tuple[Duty, ...]:
        """Return what is to be done at certain times; a new duty belongs here, and is guarded."""
        supervisor, lines = self._slave_supervisor, self.connections
        return (
            Duty("settling", lambda: lines.deadline, lines.check_settled, is_each_turn=True),
            Duty("timer", lambda: self._wake_at, self._tick),
            Duty("zygote", lambda: supervisor.start_at, lines.restart_zygote),
            *self._processes.duties(),
            Duty("samples", self._sampler.due_at, self._sampler.give_up),
            Duty("terminals", self._terminals.due_at, self._terminals.hurry),
            Duty("devices", lambda: self._devices.look_at, self._devices.look),
            Duty("sweeping", lambda: supervisor.sweep_at, supervisor.sweep),
            Duty("heartbeat", lambda: self.notifier.due_at, lambda: self.notifier.beat()),
        )

    def _wait_s(self) -> float | None:
        able = [duty for duty in self._duties if not self._guard.is_paused(duty.name)]
        deadlines = (self._guard.retry_at, *(duty.due_at() for duty in able))
        moments = [moment for moment in deadlines if moment is not None]
        return min(max(0.0, min(moments) - time.monotonic()), _LONG_S) if moments else None

    def _wake(self, moment: float) -> None:
        if self._wake_at is None or moment < self._wake_at:
            self._wake_at = moment

    def _tick(self) -> None:
        self._wake_at = None
        self._handle(ev.TimerExpired())

    def _drain(self) -> None:
        woken_by = os.read(self._wake_read, _WAKES)
        # Where there were more, there was perhaps no room for the number of a signal.
        if signal.SIGCHLD in woken_by or len(woken_by) == _WAKES:
            for event in self._slave_supervisor.reap():
                self._handle(event)

    def _take_inbox(self) -> None:
        fault.point("duty.inbox")
        while True:
            try:
                item = self._inbox.get_nowait()
            except queue.Empty:
                return
            if isinstance(item, Request):
                self._guard.run("request", self._serve, item)
            elif isinstance(item, _Failed):
                self._guard.note(item.work, item.error)
            else:
                self._guard.run("event", self._handle, item)

    def _dump(self) -> Callable[[], str]:
        recording = self._ring.capture()
        return lambda: text_of(header(self._core.state, "rtmgr dump"), recording)

    def _serve(self, request: Request) -> None:
        try:
            fault.point("duty.request")
            event = self.query_server.take(request)
        except RtkitError as error:
            request.answer(failure(error))
        except Exception as bug:
            request.answer(failure(bug))
            raise
        else:
            if event is not None:
                self._handle(event)

    def _handle(self, event: ev.Event) -> None:
        if isinstance(event, ev.ContainerReported) and self._is_aside(event):
            return
        if isinstance(event, ev.SlaveEnded):
            event = self._processes.explained(event)
        elif isinstance(event, ev.SlaveExitedUnseen):
            words = exit_diagnostics(self._core.state.name, event.name, event.pid)
            event = replace(event, reason=words.reason(event.reason), time=words.time_s)
            _log.warning("slave %s ended while no manager ran: %s", event.name, event.reason)
        for instruction in self._decide(event):
            try:
                self._carry_out(instruction)
            except Exception as error:
                self._guard.note("instruction", error)
                if isinstance(instruction, ev.StoreRows):  # replies wait for its outcome
                    why = f"a fault of the manager: {error}"
                    self.post(ev.RowsStored(instruction.number, why))
        self._devices.watch(self._core.state.bound)
        self._guard.run("aftermath", self._follow_up, event)

    def _is_aside(self, event: ev.ContainerReported) -> bool:
        """Take what passes by the core; return whether it was that."""
        for kind, take in ((SAMPLES, self._sampler.take), (TERMINAL, self._terminals.take)):
            if kind in event.message:
                take(event.key, event.message)
                return True
        return False

    def _decide(self, event: ev.Event) -> Sequence[ev.Instruction]:
        """Have the core take an event; return what is to be done."""
        now = time.monotonic()
        self._ring.record(event, now)
        try:
            return self._core.handle(event, now)
        except RtkitError as error:
            _log.warning("%s", error)
        except Exception as error:
            self._guard.note(CORE, error)
            why = f"fault of the manager ({error!r}); whether it is done is not known"
            self.requests.answer(getattr(event, "request", NOBODY), Reply(why, RtkitError.kind))
            self._wake(now + _AFTER_FAULT_S)  # what it has left undone goes on then
        finally:
            self.query_server.forget_views()
        return ()

    def _follow_up(self, event: ev.Event) -> None:
        """Do what an event means to the shell itself."""
        fault.point("duty.aftermath")
        match event:
            case ev.ContainerReported(key, message) if "metrics" not in message:
                self._processes.hasten(key)
            case ev.FollowAsked():
                self.following.sync()
            case ev.OperationRequested("link_host" | "unlink_host" | "own"):
                self.links.sync()
            case ev.StopRequested():
                self.notifier.end(is_restart=self.query_server.restart is not None)
                self.following.end()
            case ev.SlaveReady(key):
                self._processes.watch(key, self._core.state.processes[key].pid)
            case ev.SlaveStopped(key, is_halted):
                self._processes.halted(key, is_halted=is_halted)
            case ev.SlaveEnded(key):
                self._terminals.ended(key, event.reason)
                self.connections.drop(key)
                self._processes.forget(key)

    def _listened(self, line: str, has_listeners: bool) -> None:
        self.post(ev.ListenersChanged(line, has_listeners))

    def _send(self, key: int, message: Message) -> None:
        if key == ev.OWN_PROCESS:
            self._container.put(message)
        else:
            self.connections.send(key, message)

    def _publish(self, line: str, message: Message) -> None:
        whole = {**message, "time": time.time()}
        if line == METRICS:
            whole["at_s"] = time.monotonic()
            for process in whole["processes"]:
                used = usage(process["pid"])
                if used is not None:
                    process.update(used._asdict())
        self.following.on_published(line, whole)
        if line in self._announce:
            self._announce[line](json.dumps(whole, separators=(",", ":")))

    def _carry_out(self, instruction: ev.Instruction) -> None:
        fault.point("duty.instruction")
        match instruction:
            case ev.SendToContainer(key, message):
                fault.point("manager.sending")
                self._send(key, message)
            case ev.AnswerClient(request, reply):
                fault.point("manager.answering")
                self.requests.answer(request, reply)
                fault.point("manager.answered")
            case ev.SpawnSlave(key, name, ahead):
                unspawned = self._slave_supervisor.fork(key, name, ahead)
                if unspawned is not None:
                    self.post(unspawned)
                fault.point("manager.asked_for_slave")
            case ev.AdoptSlave(key, pid, is_guest):
                self.connections.adopt(key, pid, is_guest=is_guest)
                fault.point("manager.adopted")
                self._processes.watch(key, pid, is_guest=is_guest)
            case ev.SignalSlave(key, number):
                self._slave_supervisor.signal(key, signal.Signals(number))
                fault.point("manager.signalled")
            case ev.LimitSlave():
                self._processes.limit(instruction)
            case ev.AskPeer() | ev.WatchPeers():
                fault.point("manager.asking_peer")
                self.peers.order(instruction)
            case ev.StoreRows(number, rows):
                self._keeper.keep(number, rows)
            case ev.RemoveStore():
                self._keeper.forget()
            case ev.InspectProcess(key, age_s):
                self._processes.inspect(key, age_s)
            case ev.Publish(line, message):
                self._publish(line, message)
            case ev.WakeAt(moment):
                self._wake(moment)
            case ev.ExitDaemon():
                self._is_finished = True
