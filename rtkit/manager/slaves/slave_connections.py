"""Slave connections of a manager, and those to zygotes: accepts, greets, passes on, hangs up.

Every connection is a private unix socket in the manager's selector. Messages that come in lead to
events for the core; slaves that an earlier manager left are admitted with the components that they
hold.
"""

from __future__ import annotations

import logging
import selectors
import socket
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from rtkit.container.control_channel import ControlChannel
from rtkit.container.manager_connection import LEAVES, PROTOCOL
from rtkit.errors import Malformed
from rtkit.link import unix
from rtkit.link.spare_descriptor import SpareDescriptor
from rtkit.manager.core import events as ev
from rtkit.manager.core.adoption import SETTLE_S
from rtkit.manager.slaves.slave_supervisor import SlaveSupervisor

_log = logging.getLogger(__name__)
_READ, _WRITE = selectors.EVENT_READ, selectors.EVENT_WRITE


class SlaveConnections:
    """Slave connections of one manager; `handle` takes the events that come of them."""

    def __init__(
        self,
        selector: selectors.BaseSelector,
        listener: socket.socket,
        slave_supervisor: SlaveSupervisor,
        handle: Callable[[ev.Event], object],
    ) -> None:
        self._selector = selector
        self._slave_supervisor = slave_supervisor
        self._handle = handle
        self._channels: dict[int, ControlChannel] = {}
        self._found: dict[int, ControlChannel] = {}
        self._settled: Callable[[], object] | None = None
        self._settle_by = 0.0
        self._spare = SpareDescriptor()
        slave_supervisor.unwatch = self._unwatch
        self._register(listener, lambda _mask: self._accept(listener))
        self._register(slave_supervisor, lambda _mask: self._on_supervisor_message())

    def close(self) -> None:
        """Hang up on everybody."""
        for channel in self._channels.values():
            channel.close()
        self._spare.close()

    def _register(self, source: Any, react: Callable[[int], object]) -> None:
        self._selector.register(source, _READ, react)

    def send(self, key: int, message: Mapping[str, Any]) -> None:
        """Send a message to the container of a slave."""
        channel = self._channels.get(key)
        if channel is None:
            return
        try:
            channel.send(message)
        except OSError as error:
            is_guest = self._slave_supervisor.is_guest(key)  # it may leave at any time
            _log.log(
                logging.DEBUG if is_guest else logging.WARNING,
                "cannot send to slave %d: %s",
                key,
                error,
            )
            return
        if channel.has_backlog:
            self._selector.modify(channel, _READ | _WRITE, partial(self._exchange, key, channel))

    def _accept(self, listener: socket.socket) -> None:
        try:
            connection, _ = listener.accept()
        except BlockingIOError:
            return
        except OSError as error:
            _log.error("no slave can connect: %s", error.strerror)
            try:
                self._spare.turn_away(listener)
            except OSError as again:
                _log.error("cannot even refuse it: %s", again.strerror)
            return
        connection.setblocking(False)
        channel = ControlChannel(connection)
        self._register(channel, lambda _mask: self._greet(channel))

    def _greet(self, channel: ControlChannel) -> None:
        """Take the first message of a connection: a hello, or what a slave that was left holds."""
        messages = self._received(channel)
        if messages is None:
            self._hang_up(channel)
            return
        if not messages:
            return
        first, *others = messages
        key = self._admit(channel, first)
        if key is None:
            _log.warning("a connection that is no slave of ours was refused")
            self._hang_up(channel)
            return
        for message in others:
            self._handle(ev.ContainerReported(key, message))

    def _admit(self, channel: ControlChannel, first: Mapping[str, Any]) -> int | None:
        """Let a slave in; return its key, None when it is none."""
        key: Any = first.get("hello")
        pid: Any = first.get("pid")
        if first.get("protocol") != PROTOCOL or not isinstance(pid, int):
            return None
        if self._slave_supervisor.expects(key, pid, first.get("of")) and key not in self._channels:
            self._take_in(key, channel)
            self._handle(ev.SlaveForked(key, pid))
            self._handle(ev.SlaveReady(key))
            return int(key)
        name: Any = first.get("found")
        if not isinstance(name, str) or unix.pid_of(channel.socket) != pid:
            return None
        self._find_former_zygotes()
        self._found[pid] = channel
        components, connectors = first.get("components"), first.get("wires")
        is_guest = first.get("guest") is True
        asked, configured = first.get("asked"), first.get("configured")
        self._handle(
            ev.SlaveFound(pid, name, components, connectors, is_guest, "", asked, configured)
        )
        is_refused = self._found.pop(pid, None) is not None
        return None if is_refused else next(k for k, c in self._channels.items() if c is channel)

    def _take_in(self, key: int, channel: ControlChannel) -> None:
        self._channels[key] = channel
        self._selector.modify(channel, _READ, partial(self._exchange, key, channel))

    def adopt(self, key: int, pid: int, *, is_guest: bool = False) -> None:
        """Keep the connection of a found slave, or of an attached process, under its key."""
        channel = self._found.pop(pid, None)
        if channel is not None:
            self.drop(key)  # the connection that it had before
            self._take_in(key, channel)
        pidfd = self._slave_supervisor.adopt(key, pid, is_guest=is_guest)
        if channel is not None and channel.is_over:
            # It ended before: whoever has that pid may be another.
            self._slave_supervisor.distrust_pid(key)
        elif pidfd is not None:
            self._watch(key, pidfd)
        self.check_settled()

    def _watch(self, key: int, pidfd: int) -> None:
        """Notice the end of a slave whose parent is gone from its pidfd."""
        self._register(pidfd, lambda _mask: self._vanished(key, pidfd))

    def _unwatch(self, pidfd: int) -> None:
        """Watch a pidfd no more: the zygote of its process may have told the end."""
        if pidfd in self._selector.get_map():
            self._selector.unregister(pidfd)

    def _vanished(self, key: int, pidfd: int) -> None:
        if self._slave_supervisor.pidfd_of(key) != pidfd:
            return  # it said just before that it leaves, and both were ready in one turn
        self._unwatch(pidfd)
        if self._slave_supervisor.is_orphan(key):  # else its zygote, found since, says the reason
            self._lost(key)

    def _lost(self, key: int) -> None:
        event = self._slave_supervisor.lost(key)
        if event is not None:
            self._handle(event)

    # processes of earlier managers

    @property
    def deadline(self) -> float | None:
        """Return when to `check_settled` at the latest, monotonic [s]."""
        return self._settle_by if self._settled is not None else None

    def settle(self, settled: Callable[[], object]) -> None:
        """Call `settled` when the slaves of earlier managers are back, or their time is up."""
        self._find_former_zygotes()
        self._slave_supervisor.look_for_absent()  # before it is asked whether all are back
        self._settled = settled
        self._settle_by = time.monotonic() + SETTLE_S
        self.check_settled()

    def _find_former_zygotes(self) -> None:
        for former_zygote in self._slave_supervisor.former_zygotes.find():
            self._register(former_zygote, partial(self._on_former_zygote_message, former_zygote))
            self._on_former_zygote_message(former_zygote)

    def _on_former_zygote_message(self, former_zygote: ControlChannel, _mask: int = 0) -> None:
        events = self._slave_supervisor.events_from(former_zygote)
        if events is None:
            self._selector.unregister(former_zygote)
            for key, pidfd in self._slave_supervisor.orphans():
                self._watch(key, pidfd)
            if self._settled is not None:  # nobody reports any more who is to come back
                self._slave_supervisor.look_for_absent()
        for event in events or ():
            self._handle(event)
        self.check_settled()

    def check_settled(self) -> None:
        """See whether all that was left is back, or its time is up."""
        settled = self._settled
        if settled is None:
            return
        if time.monotonic() >= self._settle_by or self._slave_supervisor.is_complete:
            self._settled = None
            for event in list(self._slave_supervisor.absent()):
                self._handle(event)
            settled()

    def _exchange(self, key: int, channel: ControlChannel, mask: int) -> None:
        if self._channels.get(key) is not channel:
            return  # its slave's end was reported just before
        if mask & _WRITE:
            self._flush(key, channel)
        if not mask & _READ:
            return
        messages = self._received(channel)
        if messages is None:
            self.drop(key)
            if self._slave_supervisor.is_unwatched(key):
                self._lost(key)
            return
        for message in messages:
            if LEAVES in message and self._slave_supervisor.is_guest(key):
                self._left(key)
                return
            self._handle(ev.ContainerReported(key, message))

    def _left(self, key: int) -> None:
        """Forget an attached process that leaves; it may live on, as that of a notebook does."""
        self.drop(key)
        self._lost(key)

    def _flush(self, key: int, channel: ControlChannel) -> None:
        try:
            channel.flush()
        except OSError as error:
            _log.warning("cannot send to slave %d: %s", key, error)
            channel.forget_backlog()
        if not channel.has_backlog:
            self._selector.modify(channel, _READ, partial(self._exchange, key, channel))

    def _received(self, channel: ControlChannel) -> list[Mapping[str, Any]] | None:
        try:
            return channel.receive()
        except (Malformed, OSError) as error:
            _log.warning("a slave's connection is broken: %s", error)
            return None

    def drop(self, key: int) -> None:
        """Close the connection of a slave that ended; a child of it may hold the other end."""
        channel = self._channels.pop(key, None)
        if channel is not None:
            self._hang_up(channel)

    def _hang_up(self, channel: ControlChannel) -> None:
        self._selector.unregister(channel)
        channel.close()

    def _on_supervisor_message(self) -> None:
        events = self._slave_supervisor.receive()
        if events is None:
            self._selector.unregister(self._slave_supervisor)
            events = self._slave_supervisor.on_zygote_exit()
        for event in events:
            self._handle(event)

    def restart_zygote(self) -> None:
        """Start the next zygote."""
        self._slave_supervisor.restart()
        self._register(self._slave_supervisor, lambda _mask: self._on_supervisor_message())
