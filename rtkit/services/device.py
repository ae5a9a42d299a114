"""Reads a device file on a thread, again when it is plugged again: terminals, input devices."""

from __future__ import annotations

import os
import select
import stat
import termios
import threading
import tty
from collections.abc import Callable
from time import gmtime, monotonic, strftime, time

LOOK_S = 0.2
"""How often a device that is not there is looked for [s]."""
_PIECE = 1 << 16


class SilenceLimit:
    """Limit of the silence of what should send without being asked.

    Args:
        limit_s: How long it may be silent [s]; 0: for ever.
    """

    def __init__(self, limit_s: float) -> None:
        self._limit_s = limit_s
        self.end()

    def end(self) -> None:
        """Take note that something was received now."""
        self._received, self._since = monotonic(), time()

    def left_s(self) -> float | None:
        """Return how long it may still be silent [s]; None: for ever, or it is too long already."""
        left_s = self._received + self._limit_s - monotonic()
        return left_s if left_s > 0 else None

    def state(self) -> str:
        """Return ``ready``, or ``silent since TIME`` (UTC) where that is too long."""
        if not self._limit_s or self.left_s():
            return "ready"
        return f"silent since {strftime('%Y-%m-%dT%H:%M:%SZ', gmtime(self._since))}"


class Device:
    """Reader of a device, until `close`; whatever it calls, it calls on its own thread.

    Args:
        path: Of the device; a pipe or an ordinary file will do.
        take: Is given the bytes that came; returns False where they are nothing that ends a
            silence. A ValueError that it raises tells that they make no sense: the device is
            closed, and opened anew.
        report: Is given the state: ``ready``, ``ended`` at the end of an ordinary file,
            ``waiting: why`` or ``silent since TIME``; only when it is another one.
        baud: Of a serial line; 0 leaves it as it is.
        opened: Is given the descriptor of the open device, before anything is read.
        silence_s: How long the device may send nothing before it is called silent [s]; 0: for ever.
    """

    def __init__(
        self,
        path: str,
        take: Callable[[bytes], object],
        report: Callable[[str], object],
        baud: int = 0,
        opened: Callable[[int], object] = lambda descriptor: None,
        silence_s: float = 0.0,
    ) -> None:
        self._path, self._take, self._report = path, take, report
        self._baud, self._opened = baud, opened
        self._silence = SilenceLimit(silence_s)
        self._state = ""
        self._wake, self._stop = os.pipe()
        self._thread = threading.Thread(target=self._run, name=f"device {path}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Read no more; on return nothing is called any more."""
        os.close(self._stop)
        self._thread.join()
        os.close(self._wake)

    def _run(self) -> None:
        while True:
            try:
                wait_s = self._read()
            except (OSError, ValueError, termios.error) as error:
                text = getattr(error, "strerror", None) or (error.args or ("",))[-1]
                self._report_once(f"waiting: {self._path}: {text}")
                wait_s = LOOK_S
            if select.select([self._wake], [], [], wait_s)[0]:
                return

    def _read(self) -> float | None:
        """Read until the device has gone; return when to look again [s], None for never."""
        flags = os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC
        descriptor = os.open(self._path, flags)
        try:
            if os.isatty(descriptor):
                _make_raw(descriptor, self._baud)
            self._opened(descriptor)
            self._silence.end()
            while True:
                try:
                    data = os.read(descriptor, _PIECE)
                except BlockingIOError:
                    left_s = self._silence.left_s()  # before the state: then none is left out
                    self._report_once(self._silence.state())
                    if self._wake in select.select([descriptor, self._wake], [], [], left_s)[0]:
                        return 0.0
                    continue
                if not data:
                    break
                self._report_once(self._silence.state())
                if self._take(data) is not False:
                    self._silence.end()
                    self._report_once("ready")
            if stat.S_ISREG(os.fstat(descriptor).st_mode):
                self._report_once("ended")
                return None
            raise OSError(0, "unplugged")
        finally:
            os.close(descriptor)

    def _report_once(self, state: str) -> None:
        if state != self._state:
            self._state = state
            self._report(state)


def _make_raw(descriptor: int, baud: int) -> None:
    """Have a terminal hand on bytes as they come."""
    tty.setraw(descriptor)
    if baud:
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise ValueError(f"no such speed of a line: {baud} baud")
        settings = termios.tcgetattr(descriptor)
        settings[4] = settings[5] = speed
        termios.tcsetattr(descriptor, termios.TCSANOW, settings)
