"""Stands for systemd at the other end of ``NOTIFY_SOCKET``: receives what a service tells it."""

from __future__ import annotations

import socket
import time
from pathlib import Path

from waiting import BOUND_S

Notice = dict[str, str]
"""One datagram: its lines, ``KEY=VALUE``."""


class ServiceManager:
    """A datagram socket, and the datagrams that came in.

    Attributes:
        environment: What a service is started with.
    """

    def __init__(self, path: Path, watchdog_s: float = 0.0) -> None:
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(path))
        self.environment = {"NOTIFY_SOCKET": str(path)}
        if watchdog_s:
            self.environment["WATCHDOG_USEC"] = str(int(watchdog_s * 1e6))
        self.notices: list[Notice] = []

    def receive(self, timeout_s: float = BOUND_S) -> Notice | None:
        """Return the next notice; None if none comes in time."""
        self._socket.settimeout(max(timeout_s, 1e-6))
        try:
            text = self._socket.recv(65536).decode()
        except TimeoutError:
            return None
        notice = dict(line.partition("=")[::2] for line in text.splitlines())
        self.notices.append(notice)
        return notice

    def until(self, key: str, value: str | None = None) -> Notice:
        """Return the next notice with this key, and this value if one is named."""
        deadline = time.monotonic() + BOUND_S
        while time.monotonic() < deadline:
            notice = self.receive(deadline - time.monotonic())
            if notice and key in notice and value in (None, notice[key]):
                return notice
        raise AssertionError(f"no {key}={value}, only {self.notices}")

    def forget(self) -> None:
        """Take no notice of what has come so far."""
        while self.receive(0.0) is not None:
            continue
        self.notices.clear()

    def close(self) -> None:
        self._socket.close()
