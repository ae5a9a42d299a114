"""Connects a slave or an attached process to its manager, and to the next one after that.

When the manager is gone the process runs on, waits for the next one and reports what it holds.
Reports of that time are dropped: the next manager gets the whole state at once.

See decision 1.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol

from rtkit import fault
from rtkit.container.control_channel import ControlChannel
from rtkit.deployment.message import Message
from rtkit.errors import Malformed
from rtkit.link import unix
from rtkit.logs.late import late

PROTOCOL = 3
"""Version of the messages between manager and slaves."""

LEAVES = "leaves"
"""Key of the last message of an attached process."""

_SEEK_S, _EAGER_SEEK_S, _EAGER_FOR_S = 0.1, 0.02, 2.0
"""How often the next manager is looked for [s], and how often and for how long at first: it is
mostly started at once, and has to wait for all that look."""

_LEISURE_S = 30.0
"""How long nothing is received until there is leisure for other things [s]."""

_log = late(__name__)


class Ending(Protocol):
    """Source of the request that the process ends."""

    def fileno(self) -> int:
        """Return the descriptor that turns readable, for selectors."""

    def has_come(self) -> bool:
        """Return whether the end was requested; empty the descriptor that has become readable."""


class ManagerConnection:
    """Connection of process `name` to whatever manager listens at `path`, until `ending`.

    `at_leisure` is called every now and then while nothing is to be done.
    """

    def __init__(
        self,
        path: str,
        name: str,
        ending: Ending,
        *,
        is_guest: bool = False,
        at_leisure: Callable[[], object] | None = None,
    ) -> None:
        self._at_leisure = at_leisure
        self._path = path
        self._name = name
        self._is_guest = is_guest
        self._channel: ControlChannel | None = None
        self._ending = ending
        self._is_over = False
        self._is_renewed = False

    @property
    def is_alone(self) -> bool:
        """Return whether there is no manager at present."""
        return self._channel is None

    def greet(self, key: int, manager: str) -> None:
        """Report for the first time, to the manager that had this slave forked.

        Keys of another one may be the same: `manager` tells them apart.

        Raises:
            OSError: It does not listen any more.
        """
        channel = _connect(self._path)
        channel.send({"hello": key, "of": manager, **self._identity()})
        self._channel = channel

    def visit(
        self, report_all: Callable[[Callable[[Message], object]], object], timeout_s: float
    ) -> None:
        """Attach to the manager, and report all that is held.

        Raises:
            OSError: No manager listens, or the report is not sent in time.
        """
        channel = _connect(self._path)
        sent = threading.Event()

        def introduce(held: Message) -> None:
            self._introduce(channel, held)
            sent.set()

        report_all(introduce)
        if not sent.wait(timeout_s):
            raise TimeoutError(f"not ready within {timeout_s:g} s")

    def renew(self) -> None:
        """Have all that is held reported anew, over another connection; from any thread."""
        channel = self._channel
        if channel is not None:
            self._is_renewed = True
            with contextlib.suppress(OSError):  # it is gone already
                channel.socket.shutdown(socket.SHUT_RDWR)

    def take_leave(self) -> None:
        """Tell the manager that this attached process leaves; no other one is looked for."""
        self._is_over = True
        self.send({LEAVES: True})

    def send(self, message: Message) -> None:
        """Report to the manager, if there is one."""
        channel = self._channel
        if channel is not None:
            with contextlib.suppress(OSError):  # `listen` notices that it is gone
                channel.send(message)

    def listen(
        self,
        put: Callable[[Message], object],
        report_all: Callable[[Callable[[Message], object]], object],
    ) -> None:
        """Pass on messages of managers, one after the other; return when the end was requested.

        Args:
            put: Takes a message of a manager.
            report_all: Calls its argument with everything that is held.
        """
        channel = self._channel
        while channel is not None:
            while self._receive(channel, put):
                pass
            channel.close()
            channel = None if self._is_over else self._seek(report_all)

    def _receive(self, channel: ControlChannel, put: Callable[[Message], object]) -> bool:
        """Hand messages to the container; False at the end, or when the manager is gone."""
        sources: list[Any] = [channel, self._ending]
        wait_s = None if self._at_leisure is None else _LEISURE_S
        ready: list[object] = select.select(sources, [], [], wait_s)[0]
        if not ready and self._at_leisure is not None:
            self._at_leisure()
        if self._ending in ready and self._shall_end():
            return False
        if channel not in ready:
            return True
        try:
            messages = channel.receive()
        except (Malformed, OSError) as error:
            _log().warning("the line to the manager is broken: %s", error)
            messages = None
        for message in messages or ():
            put(message)
        if messages is None:
            self._channel = None
        return messages is not None

    def _seek(self, report_all: Callable[..., object]) -> ControlChannel | None:
        """Wait for the next manager and report everything to it; None when the end came instead."""
        if not self._is_renewed:
            _log().warning("the manager is gone; waiting for the next one")
        self._is_renewed = False
        fault.point("slave.alone")
        eager_until = time.monotonic() + _EAGER_FOR_S
        while True:
            with contextlib.suppress(OSError):
                channel = _connect(self._path)
                fault.point("slave.connected")
                report_all(partial(self._introduce, channel))
                return channel
            pause_s = _EAGER_SEEK_S if time.monotonic() < eager_until else _SEEK_S
            if select.select([self._ending], [], [], pause_s)[0] and self._shall_end():
                return None

    def _introduce(self, channel: ControlChannel, held: Message) -> None:
        with contextlib.suppress(OSError):
            who = {"found": self._name, "guest": self._is_guest}
            channel.send({**who, **self._identity(), **held})
            self._channel = channel
            fault.point("slave.introduced")

    def _identity(self) -> dict[str, Any]:
        return {"pid": os.getpid(), "protocol": PROTOCOL}

    def _shall_end(self) -> bool:
        self._is_over |= self._ending.has_come()
        return self._is_over


def _connect(path: str) -> ControlChannel:
    return ControlChannel(unix.connect(path))
