"""Supervises slave processes: has them forked, watches and reaps them.

The manager is subreaper: when the zygote dies its slaves become the manager's own children, so
that their end is still reported with its reason. A zygote that died is restarted by exec.
"""

from __future__ import annotations

import logging
import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

from rtkit import fault
from rtkit.container.control_channel import ControlChannel
from rtkit.container.orphans import (
    end_children,
    end_family,
    end_sessions,
    end_slave,
    family,
    is_stopped,
    reap_orphans,
)
from rtkit.container.slave_checkpoint import SlaveCheckpoint, checkpoint_path
from rtkit.deployment.message import Message
from rtkit.link.places import of_pid, remove_socket
from rtkit.manager.child_process import ENDS, STOPS, exit_reason
from rtkit.manager.core import events as ev
from rtkit.manager.predecessor.former_zygotes import FormerZygotes
from rtkit.manager.predecessor.unreported import UNKNOWN, UnreportedSlaves
from rtkit.manager.slaves.fork_server import ForkServer
from rtkit.manager.slaves.watchdog import remove_traces

NOBODY: Mapping[int, SlaveCheckpoint] = {}
_NO_ZYGOTE = 0
"""In place of the pid of a zygote that has ended."""
_SWEEP_S = 0.1
"""For how long nobody else ends before what ended slaves left behind is looked for [s].

Each look through all processes costs milliseconds: those that end one after the other share one
(decision 42).
"""

_SWEEP_WITHIN_S = 1.0
"""When it is looked for at the latest [s]."""

_log = logging.getLogger(__name__)
_OPTIONS = os.WEXITED | os.WSTOPPED | os.WCONTINUED | os.WNOHANG


class SlaveSupervisor:
    """Supervises slave processes; for `selectors` it is the socket to the zygote.

    Args:
        settings: Of slaves (see `rtkit.container.slave`), and ``zygote``, a path.
        dead: Components of slaves that ended while no manager ran, by pid.

    Attributes:
        sweep_at: When `sweep` is due, monotonic [s]; None while nothing is to be swept.
        unwatch: Is called with each pidfd before it is closed, as its number is free then.
    """

    def __init__(
        self, settings: Mapping[str, Any], dead: Mapping[int, SlaveCheckpoint] = NOBODY
    ) -> None:
        self._settings = {**settings, "manager_run": f"{os.getpid()}.{time.monotonic_ns()}"}
        self._pids: dict[int, int] = {}
        self._keys: dict[int, int] = {}
        self._pidfds: dict[int, int] = {}
        self._asked: dict[int, Message] = {}
        self._adopted: set[int] = set()
        self._guests: set[int] = set()
        self._halted: set[int] = set()
        self._over: set[int] = set()
        self._over_since = 0.0
        self._is_all_ours = True
        self._zygotes: set[int] = set()
        self._families: dict[int, dict[int, int]] = {}
        self._parents: dict[int, int] = {}
        self.sweep_at: float | None = None
        self.unwatch: Callable[[int], object] = lambda _pidfd: None
        self.former_zygotes = FormerZygotes(self._settings["zygote"], self._zygotes)
        self._unreported = UnreportedSlaves(self._settings["manager"], dead)
        self._server = ForkServer(self._settings)
        self._zygotes.add(self._server.pid)

    def fileno(self) -> int:
        """Return the descriptor of the socket to the zygote."""
        return self._server.channel.fileno()

    @property
    def start_at(self) -> float | None:
        """Return when the next zygote is to be started, monotonic [s]; None while there is one."""
        return self._server.start_at

    @property
    def data_pattern(self) -> str:
        """Path of slaves' data sockets, ``%p`` for the pid."""
        return str(self._settings["data"])

    def fork(self, key: int, name: str, ahead: Sequence[str] = ()) -> ev.Event | None:
        """Ask for a slave that has imported some modules; return why it cannot be, if known now.

        When the zygote is just ending, `on_zygote_exit` reports that it failed; when it has ended,
        the next one is asked.
        """
        try:
            for descriptor in os.pipe():  # as many as a slave will cost
                os.close(descriptor)
        except OSError as error:
            return ev.SlaveFailed(key, f"the manager has no descriptors left: {error.strerror}")
        self._asked[key] = {"key": key, "name": name, "ahead": [*ahead]}
        if self.start_at is None:
            self._ask(self._asked[key])
        return None

    def _ask(self, message: Message) -> None:
        try:
            self._server.channel.send(message)
        except OSError as error:
            _log.warning("cannot ask for slave %s: %s", message["name"], error)

    def expects(self, key: object, pid: object, manager: object) -> bool:
        """Return whether a connecting slave with this key and pid was requested here."""
        is_ours = manager == self._settings["manager_run"]
        if not is_ours or not isinstance(key, int) or not isinstance(pid, int):
            return False
        if key in self._asked:
            self._spawned(key, pid)
        is_ours = self._pids.get(key) == pid
        if is_ours:
            self._server.backoff.prove()
        return is_ours

    def adopt(self, key: int, pid: int, *, is_guest: bool = False) -> int | None:
        """Take a slave in that an earlier manager left, or an attached process.

        Returns:
            Its pidfd if nobody else would report its end; it turns readable then.
        """
        if self._pids.get(key) == pid:
            return None
        self._enter(key, pid)
        self._adopted.add(key)
        if is_guest:
            self._guests.add(pid)
        self.former_zygotes.found(pid)
        return None if self.former_zygotes.has(pid) else self._pidfds.get(key)

    def distrust_pid(self, key: int) -> None:
        """Take who was adopted under a pid for a stranger: it is neither watched nor signalled."""
        pidfd = self._pidfds.pop(key, None)
        if pidfd is not None:
            self.unwatch(pidfd)
            os.close(pidfd)

    def is_guest(self, key: int) -> bool:
        """Return whether a process is an attached one."""
        return self._pids.get(key) in self._guests

    def pidfd_of(self, key: int) -> int | None:
        """Return the pidfd of a process, None where there is none."""
        return self._pidfds.get(key)

    def lost(self, key: int) -> ev.Event | None:
        """Return the end of an adopted slave of which only its pidfd reported."""
        pid = self._pids.get(key)
        return None if pid is None else self._ended(pid, UNKNOWN)

    def is_unwatched(self, key: int) -> bool:
        """Return whether a slave was adopted too late for zygote or pidfd to report its end."""
        is_seen = key in self._pidfds or self.former_zygotes.has(self._pids.get(key, 0))
        return key in self._adopted and not is_seen

    def events_from(self, former_zygote: ControlChannel) -> list[ev.Event] | None:
        """Return what an earlier manager's zygote reports; None when it ended."""
        messages = self.former_zygotes.receive(former_zygote)
        if messages is None:
            return None
        return [event for message in messages for event in _some(self._event(message))]

    def look_for_absent(self) -> None:
        """Find the slaves of earlier managers that no zygote reported."""
        # Its own zygote has heartbeats as a slave has, while it warms up.
        self._unreported.look({*self.processes, *self.former_zygotes.missing})

    @property
    def is_complete(self) -> bool:
        """Return whether all slaves of earlier managers have reported, but for stopped ones."""
        former_zygotes = self.former_zygotes
        return former_zygotes.is_complete and not self._unreported.is_worth_waiting(
            former_zygotes.missing, self._keys
        )

    def absent(self) -> Iterator[ev.Event]:
        """Yield who did not come back, living and dead; once."""
        return self._unreported.settle(self.former_zygotes.missing, self._keys)

    def orphans(self) -> list[tuple[int, int]]:
        """Return key and pidfd of the slaves whose end neither zygote nor kernel will report."""
        return [(key, self._pidfds[key]) for key in self._pids if self.is_orphan(key)]

    def is_orphan(self, key: int) -> bool:
        """Return whether only its pidfd tells the end of an adopted slave."""
        is_watched = key in self._adopted and key in self._pidfds
        return is_watched and not self.former_zygotes.has(self._pids[key])

    @property
    def processes(self) -> set[int]:
        """The children of the manager that are none of its components' making, and their like."""
        return {*self._zygotes, *self._keys}

    def halts(self) -> Iterator[ev.Event]:
        """Yield which of those slaves have been stopped since the last look, or have gone on.

        A pidfd reports neither, so somebody has to look; and at what descends from them, for no
        zygote inherits it.
        """
        for pid in self._keys:
            if pid not in self._guests and not self._has_zygote(pid):
                self._families[pid] = family(pid)
        for key, _ in self.orphans():
            pid = self._pids[key]
            is_halted = is_stopped(pid)
            if pid not in self._guests and is_halted is not (key in self._halted):
                self._halted ^= {key}
                yield ev.SlaveStopped(key, is_halted)

    def _has_zygote(self, pid: int) -> bool:
        return self.former_zygotes.has(pid) or self._parents.get(pid, _NO_ZYGOTE) != _NO_ZYGOTE

    def signal(self, key: int, number: signal.Signals) -> None:
        """Send a signal to a slave; through its pidfd, so never to a stranger of the same pid.

        SIGKILL goes to its process group as well: a slave that forks without end does not outrun
        it.
        """
        pidfd, pid = self._pidfds.get(key), self._pids.get(key)
        if pidfd is None or pid is None:
            return
        if number == signal.SIGKILL:  # nobody misses its components
            with suppress(FileNotFoundError):
                os.unlink(checkpoint_path(self.data_pattern, pid))
        try:
            if number == signal.SIGKILL and pid not in self._guests:
                end_slave(pid, pidfd)
            else:
                signal.pidfd_send_signal(pidfd, number)
        except ProcessLookupError:
            _log.debug("slave %d has ended already", key)

    def receive(self) -> list[ev.Event] | None:
        """Return what the zygote reports; None when it ended, and `on_zygote_exit` is due."""
        messages = self._server.receive()
        if messages is None:
            return None
        return [event for message in messages for event in _some(self._event(message))]

    def on_zygote_exit(self) -> list[ev.Event]:
        """Let go of a zygote that ended; return the failures of what it had not done yet.

        The next one is due at `start_at`.
        """
        why = self._server.release()
        _log.error("%s", why)
        self._buried(self._server.pid)
        failed = list(self._asked)
        self._asked.clear()
        barred = [ev.SpawnDisabled(why)] if self._server.is_failing else []
        return [*barred, *(ev.SlaveFailed(key, why) for key in failed)]

    def restart(self) -> None:
        """Start another zygote, and ask it for the slaves that were wanted since the last one."""
        self._server.start()
        self._zygotes.add(self._server.pid)
        for message in self._asked.values():
            self._ask(message)

    def reap(self) -> Iterator[ev.Event]:
        """Yield what happened to slaves that have become children of the manager itself."""
        for pid in (*self._zygotes, *self._keys):
            try:
                report = os.waitid(os.P_PID, pid, _OPTIONS)
            except ChildProcessError:
                if self._is_abandoned(pid):
                    yield from _some(self._ended(pid, UNKNOWN))
                continue
            if report is not None and pid in self._zygotes:
                yield from self._zygote_report(report)
            elif report is not None:
                yield from _some(self._event_of(report))
        for pid in reap_orphans({*self._zygotes, *self._keys}):
            self._remove_files(pid)

    def _is_abandoned(self, pid: int) -> bool:
        """Return whether a slave, not our child, is nobody's: its zygote took its status along."""
        return self._parents.get(pid) == _NO_ZYGOTE

    def _zygote_report(self, report: os.waitid_result) -> Iterator[ev.Event]:
        """Note what a zygote did; yield its remaining reports if it has ended."""
        if report.si_code not in ENDS:
            if report.si_pid == self._server.pid:
                is_stopped = report.si_code in STOPS
                yield ev.SpawnDisabled(f"the zygote is stopped (pid {report.si_pid})" * is_stopped)
            return
        if report.si_pid == self._server.pid:
            self._server.ends[report.si_pid] = exit_reason(report)
            while events := self.receive():
                yield from events
        self._buried(report.si_pid)

    def _buried(self, zygote: int) -> None:
        """Have its forks ended that never connected: they are still in its session."""
        self._zygotes.discard(zygote)
        self._remove_files(zygote)
        self._over.add(zygote)
        # Its pid may be given to the next one.
        orphans = {pid: _NO_ZYGOTE for pid, parent in self._parents.items() if parent == zygote}
        self._parents.update(orphans)
        self._sweep_soon()

    def sweep(self) -> None:
        """End what slaves that ended lately have left behind.

        Once for many of them: each looks at all processes.
        """
        self.sweep_at = None
        self._end_families()

    def _end_families(self) -> None:
        if self._over:
            over, self._over = self._over, set()
            is_all_ours, self._is_all_ours = self._is_all_ours, True
            for pid in over:
                end_family(self._families.pop(pid, {}))
            end_sessions(over, is_ancestor=is_all_ours)

    def close(self) -> None:
        """End the zygotes, and whatever components started and left behind."""
        self._end_families()
        self._server.channel.close()
        self.former_zygotes.close()
        end_children()
        self._remove_files(self._server.pid)  # it may have been at its warm-up

    def _event(self, message: Mapping[str, Any]) -> ev.Event | None:
        if "forked" in message:
            self._spawned(message["forked"], message["pid"])
            return ev.SlaveForked(message["forked"], message["pid"])
        if "failed" in message:
            self._asked.pop(message["failed"], None)
            return ev.SlaveFailed(message["failed"], message["reason"])
        if "ended" in message:
            return self._ended(message["ended"], message["reason"])
        if "ready" in message:
            return ev.SpawnDisabled("")
        key = self._keys.get(message.get("halted", 0))
        return None if key is None else ev.SlaveStopped(key, message["is_halted"])

    def _event_of(self, report: os.waitid_result) -> ev.Event | None:
        if report.si_code in ENDS:
            return self._ended(report.si_pid, exit_reason(report))
        key = self._keys.get(report.si_pid)
        return None if key is None else ev.SlaveStopped(key, report.si_code in STOPS)

    def _spawned(self, key: int, pid: int) -> None:
        if self._asked.pop(key, None) is not None:
            self._parents[pid] = self._server.pid
            self._enter(key, pid)

    def _enter(self, key: int, pid: int) -> None:
        self._pids[key] = pid
        self._keys[pid] = key
        try:
            self._pidfds[key] = os.pidfd_open(pid)
        except ProcessLookupError:
            _log.debug("slave %d ended before it was known", key)
        except OSError as error:
            _log.error("slave %d cannot be watched: %s", key, error.strerror)

    def _ended(self, pid: int, why: str) -> ev.Event | None:
        key = self._keys.pop(pid, None)
        self.former_zygotes.ended(pid)
        if key is None:
            self._unreported.ended(pid, why)
        self._remove_files(pid)
        if key is None:
            return None
        fault.point("manager.heard_of_end")
        self._adopted.discard(key)
        self._halted.discard(key)
        self._is_all_ours &= self._parents.pop(pid, None) is not None
        del self._pids[key]
        self.distrust_pid(key)
        if pid in self._guests:
            self._guests.discard(pid)  # its orphans are not ours to end
        else:
            self._over.add(pid)
        self._sweep_soon()
        return ev.SlaveEnded(key, why)

    def _sweep_soon(self) -> None:
        now = time.monotonic()
        self._over_since = now if self.sweep_at is None else self._over_since
        self.sweep_at = min(now + _SWEEP_S, self._over_since + _SWEEP_WITHIN_S)

    def _remove_files(self, pid: int) -> None:
        """Remove what a process that was killed could not remove itself."""
        pattern = self.data_pattern
        remove_socket(of_pid(pattern, pid))
        remove_traces(pattern, pid)
        held = checkpoint_path(pattern, pid)
        for path in (held, f"{held}.new", of_pid(self._settings["zygote"], pid)):
            with suppress(FileNotFoundError):
                os.unlink(path)


def _some(event: ev.Event | None) -> list[ev.Event]:
    return [] if event is None else [event]
