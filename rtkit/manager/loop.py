"""The manager's loop thread: feeds the core with events and carries its instructions out."""

from __future__ import annotations

import logging
import os
import queue
import selectors
import signal
import socket
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

from rtkit.errors import Malformed, RtkitError
from rtkit.manager import events as ev
from rtkit.manager.core import Core
from rtkit.manager.holder import Holder
from rtkit.manager.nursery import Nursery
from rtkit.manager.requests import Desk
from rtkit.manager.slave import PROTOCOL
from rtkit.manager.wire import Channel
from rtkit.property.exchange import Request, failure

_log = logging.getLogger(__name__)
_READ, _WRITE = selectors.EVENT_READ, selectors.EVENT_WRITE
_HANDSHAKE_KEYS = {"hello", "pid", "protocol"}
_LONG_S = 3600.0
"""The longest sleep; a selector takes no arbitrarily long one [s]."""


class Loop:
    """Owns the core; everybody else only enqueues (`post`)."""

    def __init__(
        self, core: Core, holder: Holder, nursery: Nursery, listener: socket.socket
    ) -> None:
        self._core = core
        self._desk = Desk(core.state)
        self._holder = holder
        self._nursery = nursery
        self._inbox: queue.SimpleQueue[ev.Event | Request] = queue.SimpleQueue()
        self._channels: dict[int, Channel] = {}
        self._wake_at: float | None = None
        self._is_finished = False
        self._is_closed = False
        self._spare = os.open(os.devnull, os.O_RDONLY)
        self._selector = selectors.DefaultSelector()
        self._wake_read, self._wake_write = os.pipe()
        for descriptor in (self._wake_read, self._wake_write):
            os.set_blocking(descriptor, False)
        self._register(self._wake_read, lambda _mask: self._drain())
        self._register(listener, lambda _mask: self._accept(listener))
        self._register(nursery, lambda _mask: self._heard_nursery())

    @property
    def wake_descriptor(self) -> int:
        """Where a byte wakes the loop, for `signal.set_wakeup_fd`."""
        return self._wake_write

    def post(self, item: ev.Event | Request) -> None:
        """Hand in an event or a request, from any thread."""
        self._inbox.put(item)
        if not self._is_closed:
            with suppress(BlockingIOError):  # it is awake already
                os.write(self._wake_write, b"x")

    def run(self) -> None:
        """Work until the core says that all is done."""
        while not self._is_finished:
            for key, mask in self._selector.select(self._patience()):
                _guarded(key.data, mask)
            self._take_inbox()
            if self._wake_at is not None and time.monotonic() >= self._wake_at:
                self._wake_at = None
                self._handle(ev.Tick())

    def close(self) -> None:
        """Let go of all descriptors; what is posted from now on is not heard."""
        self._is_closed = True
        self._selector.close()
        for channel in self._channels.values():
            channel.close()
        for descriptor in (self._wake_read, self._wake_write, self._spare):
            os.close(descriptor)

    def _register(self, source: Any, react: Callable[[int], object]) -> None:
        self._selector.register(source, _READ, react)

    def _patience(self) -> float | None:
        if self._wake_at is None:
            return None
        return min(max(0.0, self._wake_at - time.monotonic()), _LONG_S)

    def _drain(self) -> None:
        os.read(self._wake_read, 4096)
        for event in self._nursery.reap():
            self._handle(event)

    def _take_inbox(self) -> None:
        while True:
            try:
                item = self._inbox.get_nowait()
            except queue.Empty:
                return
            if isinstance(item, Request):
                _guarded(self._serve, item)
            else:
                _guarded(self._handle, item)

    def _serve(self, request: Request) -> None:
        try:
            event = self._desk.take(request)
        except RtkitError as error:
            request.answer(failure(error))
        except Exception as bug:
            request.answer(failure(bug))
            raise
        else:
            if event is not None:
                self._handle(event)

    def _handle(self, event: ev.Event) -> None:
        try:
            instructions = self._core.handle(event, time.monotonic())
        except RtkitError as error:
            _log.warning("%s", error)
            return
        self._desk.forget_views()
        for instruction in instructions:
            _guarded(self._carry_out, instruction)
        if isinstance(event, ev.SlaveEnded):
            self._drop(event.key)

    def _carry_out(self, instruction: ev.Instruction) -> None:
        match instruction:
            case ev.SendToHolder(key, message):
                self._send(key, message)
            case ev.AnswerClient(answer, reply):
                answer(reply)
            case ev.SpawnSlave(key, name):
                self._nursery.fork(key, name)
            case ev.SignalSlave(key, number):
                self._nursery.signal(key, signal.Signals(number))
            case ev.WakeAt(moment):
                if self._wake_at is None or moment < self._wake_at:
                    self._wake_at = moment
            case ev.Finish():
                self._is_finished = True

    # slaves

    def _send(self, key: int, message: Mapping[str, Any]) -> None:
        if key == ev.OWN_PROCESS:
            self._holder.put(message)
            return
        channel = self._channels.get(key)
        if channel is None:
            return
        try:
            channel.send(message)
        except OSError as error:
            _log.warning("cannot send to slave %d: %s", key, error)
            return
        if channel.has_backlog:
            self._selector.modify(channel, _READ | _WRITE, self._reader(key, channel))

    def _accept(self, listener: socket.socket) -> None:
        try:
            connection, _ = listener.accept()
        except BlockingIOError:
            return
        except OSError as error:
            _log.error("no slave can connect: %s", error.strerror)
            self._turn_away(listener)
            return
        connection.setblocking(False)
        channel = Channel(connection)
        self._register(channel, lambda _mask: self._greet(channel))

    def _turn_away(self, listener: socket.socket) -> None:
        """Refuse who waits with the descriptor kept for this: else select would return for ever."""
        os.close(self._spare)
        try:
            listener.accept()[0].close()
        except OSError as error:
            _log.error("cannot even refuse it: %s", error.strerror)
        finally:
            self._spare = os.open(os.devnull, os.O_RDONLY)

    def _greet(self, channel: Channel) -> None:
        """Take the first message of a connection, which must be a hello."""
        messages = self._received(channel)
        if messages is None:
            self._hang_up(channel)
            return
        if not messages:
            return
        hello, *others = messages
        key: Any = hello.get("hello")
        is_known = set(hello) >= _HANDSHAKE_KEYS and self._nursery.expects(key, hello["pid"])
        if not is_known or key in self._channels:
            _log.warning("a connection that is no slave of ours was refused")
            self._hang_up(channel)
            return
        if hello["protocol"] != PROTOCOL:
            _log.warning("slave speaks protocol %s, not %s", hello["protocol"], PROTOCOL)
            self._hang_up(channel)
            return
        self._channels[key] = channel
        self._selector.modify(channel, _READ, self._reader(key, channel))
        self._handle(ev.SlaveForked(key, hello["pid"]))
        self._handle(ev.SlaveReady(key))
        for message in others:
            self._handle(ev.HolderSaid(key, message))

    def _reader(self, key: int, channel: Channel) -> Callable[[int], object]:
        return lambda mask: self._exchange(key, channel, mask)

    def _exchange(self, key: int, channel: Channel, mask: int) -> None:
        if mask & _WRITE:
            self._flush(key, channel)
        if not mask & _READ:
            return
        messages = self._received(channel)
        if messages is None:
            self._drop(key)
            return
        for message in messages:
            self._handle(ev.HolderSaid(key, message))

    def _flush(self, key: int, channel: Channel) -> None:
        try:
            channel.flush()
        except OSError as error:
            _log.warning("cannot send to slave %d: %s", key, error)
            channel.forget_backlog()
        if not channel.has_backlog:
            self._selector.modify(channel, _READ, self._reader(key, channel))

    def _received(self, channel: Channel) -> list[Mapping[str, Any]] | None:
        try:
            return channel.receive()
        except (Malformed, OSError) as error:
            _log.warning("a slave's connection is broken: %s", error)
            return None

    def _drop(self, key: int) -> None:
        """Close the connection of a slave that ended; a child of it may hold the other end."""
        channel = self._channels.pop(key, None)
        if channel is not None:
            self._hang_up(channel)

    def _hang_up(self, channel: Channel) -> None:
        self._selector.unregister(channel)
        channel.close()

    def _heard_nursery(self) -> None:
        events = self._nursery.receive()
        if events is None:
            self._selector.unregister(self._nursery)
            events = self._nursery.restart()
            self._register(self._nursery, lambda _mask: self._heard_nursery())
        for event in events:
            self._handle(event)


def _guarded(work: Callable[[Any], object], argument: Any) -> None:
    """Do one piece of work; a fault in it is logged, and ends neither the loop nor the rest."""
    try:
        work(argument)
    except Exception:
        _log.exception("fault in %s", getattr(work, "__qualname__", work))
