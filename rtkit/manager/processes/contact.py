"""A slave's line to its manager: it hears, tells, and outlives the manager.

When the manager is gone the slave runs on, waits for the next one and tells it what it holds.
What there is to report meanwhile is dropped: the next manager gets the whole state at once.
"""

from __future__ import annotations

import contextlib
import logging
import os
import select
import signal
import socket
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from rtkit.errors import Malformed
from rtkit.manager.core.events import Message
from rtkit.manager.processes.wire import Channel

PROTOCOL = 2
"""Version of the messages between manager and slaves."""

_SEEK_S = 0.1
"""How often the next manager is looked for [s]."""

_log = logging.getLogger(__name__)


class Hearer(Protocol):
    """What a contact passes messages to: the holder."""

    def put(self, message: Message) -> None:
        """Take a message of the manager."""

    def tell_all(self, tell: Callable[[Message], object]) -> None:
        """Call `tell` with everything that is held."""


class Contact:
    """The line of the slave `name` to whatever manager listens at `path`."""

    def __init__(self, path: str, name: str) -> None:
        self._path = path
        self._name = name
        self._channel: Channel | None = None
        self._wake = _catch_term()
        self._has_term = False

    @property
    def is_alone(self) -> bool:
        """Whether there is no manager at present."""
        return self._channel is None

    def greet(self, key: int) -> None:
        """Report for the first time, to the manager that had this slave forked.

        Raises:
            OSError: It does not listen any more.
        """
        channel = _connect(self._path)
        channel.send({"hello": key, **self._identity()})
        self._channel = channel

    def send(self, message: Message) -> None:
        """Report to the manager, if there is one."""
        channel = self._channel
        if channel is not None:
            with contextlib.suppress(OSError):  # `listen` notices that it is gone
                channel.send(message)

    def listen(self, holder: Hearer) -> None:
        """Pass on what managers say, one after the other; return when a TERM came."""
        channel = self._channel
        while channel is not None:
            while self._hear(channel, holder):
                pass
            channel.close()
            channel = None if self._has_term else self._seek(holder)

    def _hear(self, channel: Channel, holder: Hearer) -> bool:
        """Hand the next messages to the holder; False when a TERM came or the manager is gone."""
        sources: list[Any] = [channel, self._wake]
        ready: list[object] = select.select(sources, [], [])[0]
        if self._wake in ready and self._is_term():
            return False
        if channel not in ready:
            return True
        try:
            messages = channel.receive()
        except (Malformed, OSError) as error:
            _log.warning("the line to the manager is broken: %s", error)
            messages = None
        for message in messages or ():
            holder.put(message)
        if messages is None:
            self._channel = None
        return messages is not None

    def _seek(self, holder: Hearer) -> Channel | None:
        """Wait for the next manager and tell it everything; None when a TERM came instead."""
        _log.warning("the manager is gone; waiting for the next one")
        while True:
            with contextlib.suppress(OSError):
                channel = _connect(self._path)
                holder.tell_all(partial(self._introduce, channel))
                return channel
            if select.select([self._wake], [], [], _SEEK_S)[0] and self._is_term():
                return None

    def _introduce(self, channel: Channel, held: Message) -> None:
        with contextlib.suppress(OSError):
            channel.send({"found": self._name, **self._identity(), **held})
            self._channel = channel

    def _identity(self) -> dict[str, Any]:
        return {"pid": os.getpid(), "protocol": PROTOCOL}

    def _is_term(self) -> bool:
        self._has_term |= signal.SIGTERM in os.read(self._wake, 4096)
        return self._has_term


def _connect(path: str) -> Channel:
    connection = socket.socket(socket.AF_UNIX)
    try:
        connection.connect(path)
    except OSError:
        connection.close()
        raise
    return Channel(connection)


def _catch_term() -> int:
    """Return a descriptor that turns readable at a TERM, whichever thread the kernel gives it to.

    A handler alone would run only when the main thread next leaves a wait of its own.
    """
    read, write = os.pipe()
    for descriptor in (read, write):
        os.set_blocking(descriptor, False)
    signal.signal(signal.SIGTERM, lambda *_: None)
    signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    return read
