"""Simulates serial lines: two devices (real pseudo-terminals) and the cable between them.

The cable can damage what it carries; a device can be unplugged and plugged in again.
"""

from __future__ import annotations

import contextlib
import os
import random
import select
import shutil
import subprocess
import threading
import tty
from collections.abc import Callable
from pathlib import Path

EMBEDDED = Path(__file__).parents[2] / "examples" / "embedded"
Mangle = Callable[[bytes], bytes]
_PIECE = 4096
_MOST_HELD = 1 << 16


class Cable:
    """Two devices, `near` and `far`, and a thread that carries bytes from each to the other.

    Attributes:
        near: Path of a device.
        far: Path of the other.
        noise: Applied to each piece that is carried.
    """

    def __init__(self, folder: str, noise: Mangle = bytes) -> None:
        self.near = os.path.join(folder, "near")
        self.far = os.path.join(folder, "far")
        self.noise = noise
        self._masters: dict[str, int] = {}
        self._slaves: dict[str, int] = {}
        self._held: dict[str, bytearray] = {self.near: bytearray(), self.far: bytearray()}
        self._lock = threading.Lock()
        self._wake, self._waker = os.pipe()
        self._is_ended = False
        for path in (self.near, self.far):
            self.plug(path)
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def plug(self, path: str) -> None:
        """Have a device there."""
        master, slave = os.openpty()
        for each in (master, slave):
            tty.setraw(each)
        os.set_blocking(master, False)
        with self._lock:
            self._masters[path], self._slaves[path] = master, slave
            self._held[path].clear()
            os.symlink(os.ttyname(slave), path)
        os.write(self._waker, b"x")

    def unplug(self, path: str) -> None:
        """Have a device vanish, under whoever has it open."""
        with self._lock:
            os.unlink(path)
            os.close(self._masters.pop(path))
            os.close(self._slaves.pop(path))

    def close(self) -> None:
        """Take it all away."""
        self._is_ended = True
        os.write(self._waker, b"x")
        self._thread.join()
        for path in list(self._masters):
            self.unplug(path)
        os.close(self._wake)
        os.close(self._waker)

    def _other(self, path: str) -> str:
        return self.far if path == self.near else self.near

    def _carry(self) -> None:
        while not self._is_ended:
            with self._lock:
                poll = select.poll()
                poll.register(self._wake, select.POLLIN)
                for path, master in self._masters.items():
                    has_room = len(self._held[self._other(path)]) < _MOST_HELD
                    mask = (select.POLLIN if has_room else 0) | (
                        select.POLLOUT if self._held[path] else 0
                    )
                    poll.register(master, mask)
            poll.poll(20)
            with self._lock, contextlib.suppress(BlockingIOError, OSError):
                if select.select([self._wake], [], [], 0)[0]:
                    os.read(self._wake, 100)
                for path in list(self._masters):
                    self._move(path)

    def _move(self, path: str) -> None:
        """Take what a device sends, give it what is held for it."""
        other, master = self._held[self._other(path)], self._masters[path]
        if len(other) < _MOST_HELD and select.select([master], [], [], 0)[0]:
            other += self.noise(os.read(master, _PIECE))
        held = self._held[path]
        if held and select.select([], [master], [], 0)[1]:
            del held[: os.write(master, held[:_PIECE])]


def build_device(folder: Path) -> Path:
    """Copy the example of a small device to a folder, and build it there; return the folder."""
    for path in (*EMBEDDED.glob("*.[ch]"), EMBEDDED / "Makefile"):
        shutil.copy(path, folder)
    subprocess.run(["make", "-s", "device"], cwd=folder, check=True, timeout=60)
    return folder


def noise(seed: int, one_in: int) -> Mangle:
    """Return what damages one line in so many: bytes turned, lost, put in, ends of lines too."""
    chance = random.Random(seed)

    def damage(line: bytes) -> bytes:
        at = chance.randrange(len(line))
        kind = chance.randrange(5)
        if kind == 0:
            return line[:at] + bytes((line[at] ^ (1 << chance.randrange(8)),)) + line[at + 1 :]
        if kind == 1:
            return line[:at] + line[at + 1 :]
        if kind == 2:
            return line[:at] + chance.randbytes(chance.randrange(1, 5)) + line[at:]
        if kind == 3:
            return line[:at] + b"\n" + line[at:]
        return line[:-1]

    def mangle(data: bytes) -> bytes:
        lines = data.splitlines(keepends=True)
        return b"".join([each if chance.randrange(one_in) else damage(each) for each in lines])

    return mangle
