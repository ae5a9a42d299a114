"""Terminal of a component: a pseudo-terminal, of which this process keeps both ends.

So it outlives managers and whoever looks at it. A thread passes on what is typed, and takes what
the terminal echoes; what the component prints is on its screen too.
"""

from __future__ import annotations

import fcntl
import io
import os
import select
import struct
import termios
from collections.abc import Callable
from contextlib import suppress
from threading import Lock
from typing import TYPE_CHECKING

from rtkit.component.contexts.input_wait import (
    InputEnded,
    allow_input,
    begin_wait,
    check_input,
    end_wait,
    ended_by,
    leave_input,
    wait_of,
)
from rtkit.component.contexts.waiting import waiting_for_people
from rtkit.link.threads import start_thread
from rtkit.link.wakeup import Wakeup

if TYPE_CHECKING:
    from _typeshed import WriteableBuffer

_MOST_SHOWN = 1 << 16
"""How much of what was shown last is kept [bytes]."""
_TAIL = 2048
"""How much of it whoever attaches sees at first, from the beginning of a line on [bytes]."""
_MOST_TYPED = 1 << 16
"""How much may wait to be passed on [bytes]."""
_BRIEF_S = 0.05
"""A wait that is shorter is not told anybody [s]."""
_CHUNK = 4096
_IUTF8 = 0o040000  # of Linux; `termios` does not name it


class ComponentTerminal:
    """Terminal of one component.

    Args:
        instance: The component.
        changed: Called when it begins, or ceases, to wait for input; on any thread.
        shown: Called when there is something new, or something was read; on any thread.

    Attributes:
        stdin: Stream of what is typed, as text.
        end: Number of bytes that were shown so far.
    """

    def __init__(
        self, instance: str, changed: Callable[[], object], shown: Callable[[], object]
    ) -> None:
        self._instance = instance
        self._changed = changed
        self._shown = shown
        self._master, self.descriptor = os.openpty()
        _prepare(self.descriptor)
        flags = os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC
        # Another description: components may want to wait at theirs.
        self._own = os.open(os.ttyname(self.descriptor), flags)
        os.set_blocking(self._master, False)
        self.stdin = io.TextIOWrapper(
            io.BufferedReader(_Input(self)), encoding="utf-8", errors="replace"
        )
        self.end = 0
        self._lock = Lock()
        self._echo = Lock()
        self._screen = bytearray()
        self._typed = bytearray()
        self._wakeup = Wakeup()
        self._leave = Wakeup()
        self._readers = 0
        self._is_closed = False
        ended_by(instance, self._leave)
        start_thread(self._pass_on, f"terminal {instance}")

    # what is shown

    def show(self, data: bytes) -> None:
        """Show something, from any thread."""
        with self._lock:
            self._screen += data
            self.end += len(data)
            del self._screen[: max(0, len(self._screen) - _MOST_SHOWN)]
        self._shown()

    def show_text(self, text: str) -> None:
        """Show what the component printed, after what the terminal has echoed until now."""
        self._take_echo()
        self.show(text.replace("\n", "\r\n").encode("utf-8", "backslashreplace"))

    def since(self, begin: int) -> bytes:
        """Return what was shown since; for no place of this terminal the last lines."""
        with self._lock:
            if not 0 <= begin <= self.end:
                tail = bytes(self._screen[-_TAIL:])
                is_whole = len(tail) == len(self._screen)
                return tail if is_whole else tail[tail.find(b"\n") + 1 :]
            return bytes(self._screen[max(0, len(self._screen) - (self.end - begin)) :])

    # what is typed

    def take(self, data: bytes) -> bool:
        """Take what somebody types, from any thread; False where too much waits already."""
        with self._lock:
            if len(self._typed) + len(data) > _MOST_TYPED or self._is_closed:
                return False
            self._typed += data
        self._wakeup.ring()
        return True

    @property
    def unread(self) -> int:
        """Size of what was typed and the component has not read yet, in whole lines [bytes]."""
        with self._lock:
            if self._is_closed:
                return 0
            # What was written to the other end arrives later, but not later than a look at it.
            _polling(self._own).poll(0)
            (waiting,) = struct.unpack("i", fcntl.ioctl(self._own, termios.FIONREAD, b"\0" * 4))
            return int(waiting) + len(self._typed)

    def resize(self, lines: int, columns: int) -> None:
        """Have another size [characters]."""
        with self._echo:
            if self._master >= 0:
                size = struct.pack("HHHH", lines, columns, 0, 0)
                fcntl.ioctl(self._master, termios.TIOCSWINSZ, size)

    @property
    def wait(self) -> str:
        """``waiting for input since 12:00:00``; empty where it does not wait."""
        return wait_of(self._instance)

    # the component's side

    def read_into(self, buffer: WriteableBuffer) -> int:
        """Read what was typed; wait until something was.

        Raises:
            InputEnded: The component is to be deactivated or ended.
        """
        with self._lock:
            if self._is_closed:
                raise InputEnded(f"{self._instance} has ended")
            self._readers += 1
        try:
            while True:
                self._await()
                with suppress(BlockingIOError):  # another thread was quicker
                    count = os.readv(self._own, [buffer])
                    self._shown()
                    return count
        finally:
            self._let_go()

    def _await(self) -> None:
        """Wait until there is something to read."""
        check_input(self._instance)
        poll = _polling(self._own, self._leave.fileno())
        if not poll.poll(0):
            with waiting_for_people():
                if not poll.poll(_BRIEF_S * 1000):
                    self._await_long(poll)
        check_input(self._instance)

    def _await_long(self, poll: select.poll) -> None:
        """Wait, and tell so."""
        begin_wait(self._instance)
        self._changed()
        self._shown()
        try:
            poll.poll()
        finally:
            end_wait(self._instance)
            self._changed()

    # the end

    def close(self) -> None:
        """End all waits, and the terminal when nobody reads from it any more."""
        leave_input(self._instance)
        with self._lock:
            self._is_closed = True
            self._readers += 1
        self._wakeup.ring()
        self._let_go()
        self._shown()

    def _let_go(self) -> None:
        with self._lock:
            self._readers -= 1
            is_last = self._is_closed and not self._readers
        if is_last:
            ended_by(self._instance, None)
            allow_input(self._instance)
            self._leave.close()
            for descriptor in (self.descriptor, self._own):
                os.close(descriptor)

    def _pass_on(self) -> None:
        """Pass on what is typed, and take what the terminal echoes, until it is closed."""
        poll = _polling(self._wakeup.fileno())
        while not self._is_closed:
            is_typed = select.POLLOUT if self._typed else 0
            poll.register(self._master, select.POLLIN | is_typed)
            poll.poll()
            self._wakeup.hush()
            self._take_echo()
            with suppress(OSError), self._lock:  # there is no room, or it has been closed
                while self._typed:
                    count = os.write(self._master, self._typed[:_CHUNK])
                    del self._typed[:count]
        self._wakeup.close()
        with self._echo:
            os.close(self._master)
            self._master = -1

    def _take_echo(self) -> None:
        with self._echo, suppress(OSError):  # that was all, or it has been closed
            while self._master >= 0 and (data := os.read(self._master, _CHUNK)):
                self.show(data)


class _Input(io.RawIOBase):
    """Stream of what is typed at a terminal, as bytes."""

    def __init__(self, terminal: ComponentTerminal) -> None:
        self._terminal = terminal

    def readable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._terminal.descriptor

    def isatty(self) -> bool:
        return True

    def readinto(self, buffer: WriteableBuffer, /) -> int:
        return self._terminal.read_into(buffer)


def _polling(*descriptors: int) -> select.poll:
    """Return what polls descriptors for something to read; each thread needs its own."""
    poll = select.poll()
    for each in descriptors:
        poll.register(each, select.POLLIN)
    return poll


def _prepare(descriptor: int) -> None:
    """Have a terminal know that characters may be several bytes, and hold no output (Ctrl-S)."""
    mode = termios.tcgetattr(descriptor)
    mode[0] = (mode[0] | _IUTF8) & ~termios.IXON
    termios.tcsetattr(descriptor, termios.TCSANOW, mode)
