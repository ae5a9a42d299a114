"""Takes over the terminal for a live page, and restores it however the page ends."""

from __future__ import annotations

import os
import select
import signal
import sys
import termios
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from types import FrameType, TracebackType
from typing import Any, Self

from rtkit.cli.shared.signals import ResizeWakeup, resizing

_ENTER = "\x1b[?1049h\x1b[?25l\x1b[?7l\x1b[2J"
_LEAVE = "\x1b[?7h\x1b[?25h\x1b[?1049l"
_ENDS = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
_KEYS = {
    "\x1b[A": "up",
    "\x1bOA": "up",
    "\x1b[B": "down",
    "\x1bOB": "down",
    "\x1b[C": "right",
    "\x1bOC": "right",
    "\x1b[D": "left",
    "\x1bOD": "left",
    "\x1b[5~": "page up",
    "\x1b[6~": "page down",
    "\x1b[H": "home",
    "\x1b[F": "end",
}


class Screen:
    """The terminal on stdout, and its keyboard if stdin is one; leave it as a context manager.

    A signal that ends the process, or stops it (Ctrl-Z), finds the terminal as it was before.

    Attributes:
        wakeup: Set when there is something new to show; any thread may set it.
    """

    def __init__(self) -> None:
        self._open = ExitStack()
        self.wakeup = ResizeWakeup()
        self._open.callback(self.wakeup.close)
        self._disturbed = self._open.enter_context(resizing(is_terminal=True))
        self._out = sys.stdout.fileno()
        self._keyboard = (
            sys.stdin.fileno() if sys.stdin is not None and sys.stdin.isatty() else None
        )
        self._before: list[Any] | None = None
        self._shown: list[str] = []
        self._is_stale = False
        self._signals: dict[int, Any] = {}

    def __enter__(self) -> Self:
        for number in _ENDS:
            self._signals[number] = signal.signal(number, self._end)
        self._signals[signal.SIGTSTP] = signal.signal(signal.SIGTSTP, self._stop)
        self._take()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._give_back()
        for number, handler in self._signals.items():
            signal.signal(number, handler)
        self._open.close()

    @property
    def sources(self) -> list[int]:
        """Descriptors of which one is readable when there is something to draw, or a key."""
        keyboard = [] if self._keyboard is None else [self._keyboard]
        return [self.wakeup.fileno(), self._disturbed.fileno(), *keyboard]

    @property
    def size(self) -> tuple[int, int]:
        """Columns and lines."""
        size = os.get_terminal_size(self._out)
        return size.columns or 80, size.lines or 24

    def keys(self) -> list[str]:
        """Return the keys that were pressed; ``end of input`` when there will be none."""
        if self._keyboard is None or not select.select([self._keyboard], [], [], 0)[0]:
            return []
        text = os.read(self._keyboard, 1024).decode("utf-8", "replace")
        return keys_of(text) if text else ["end of input"]

    def hush(self) -> None:
        """Clear the wakeup event."""
        self.wakeup.take()
        self._is_stale |= self._disturbed.take()

    def show(self, lines: Sequence[str]) -> None:
        """Show these lines; only those that have changed are sent."""
        parts = []
        if self._is_stale:
            self._is_stale, self._shown = False, []
            parts.append("\x1b[2J")
        parts += [
            f"\x1b[{number};1H{line}\x1b[0m\x1b[K"
            for number, line in enumerate(lines, 1)
            if number > len(self._shown) or line != self._shown[number - 1]
        ]
        if len(lines) < len(self._shown):
            parts.append(f"\x1b[{len(lines) + 1};1H\x1b[J")
        self._shown = list(lines)
        self._write("".join(parts))

    def _write(self, text: str) -> None:
        data = text.encode("utf-8", "replace")
        while data:
            data = data[os.write(self._out, data) :]

    def _take(self) -> None:
        self._shown = []
        if self._keyboard is not None:
            self._before = termios.tcgetattr(self._keyboard)
            mode = termios.tcgetattr(self._keyboard)
            mode[3] &= ~(termios.ICANON | termios.ECHO)
            termios.tcsetattr(self._keyboard, termios.TCSADRAIN, mode)
        self._write(_ENTER)

    def _give_back(self) -> None:
        with suppress(OSError):  # the terminal may be gone
            self._write(_LEAVE)
        if self._keyboard is not None and self._before is not None:
            with suppress(termios.error):
                termios.tcsetattr(self._keyboard, termios.TCSADRAIN, self._before)
        self._before = None

    def _end(self, number: int, _frame: FrameType | None) -> None:
        self._give_back()
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)

    def _stop(self, number: int, _frame: FrameType | None) -> None:
        self._give_back()
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
        # Here it goes on, after a SIGCONT.
        signal.signal(number, self._stop)
        self._take()
        self._disturbed.ring()


def keys_of(text: str) -> list[str]:
    """Return the keys that a terminal sent: letters as they are, others by name."""
    keys = []
    while text:
        sequence = next((each for each in _KEYS if text.startswith(each)), "")
        keys.append(_KEYS.get(sequence, text[0]))
        text = text[len(sequence) or 1 :]
    return keys
