"""Shifts the wall clock of all processes of a shell; the machine's own clock stays as it is."""

from __future__ import annotations

import mmap
import os
import shutil
import struct
import subprocess
import time
from pathlib import Path
from typing import Any

_SOURCE = Path(__file__).with_name("jumping_clock.c")
_AHEAD = struct.Struct("=qqq")
YEAR_S = 365 * 86_400


def missing() -> str:
    """Return why no clock can jump here, empty if it can."""
    return "" if shutil.which("cc") else "there is no C compiler (cc)"


class WallClock:
    """The clock of whatever a shell starts from now on, or starts with some variables."""

    def __init__(self, shell: Any, variables: dict[str, str] | None = None) -> None:
        library, file = shell.folder / "clock.so", shell.folder / "clock"
        build = ["cc", "-shared", "-fPIC", "-nostdlib", "-o", str(library), str(_SOURCE)]
        subprocess.run(build, check=True)
        file.write_bytes(bytes(_AHEAD.size))
        with open(file, "r+b") as stream:
            self._ahead = mmap.mmap(stream.fileno(), _AHEAD.size)
        given = shell.environment if variables is None else variables
        given |= {"LD_PRELOAD": str(library), "RTKIT_TEST_CLOCK": str(file)}
        assert not os.environ.get("LD_PRELOAD"), "which would be lost"

    def jump(self, ahead_s: int) -> None:
        """Have the clock show so much more than it should [s], or less."""
        self.drift(ahead_s, 0)

    def drift(self, ahead_s: int, millionths: int) -> None:
        """Have the clock jump, and from now on run faster by some millionths."""
        self._since_s = time.monotonic()
        numbers = ahead_s, millionths, round(self._since_s * 1e9)
        self._by = ahead_s, millionths * 1e-6
        _AHEAD.pack_into(self._ahead, 0, *numbers)

    def right(self, shown_s: float) -> float:
        """Return the right time at which the clock showed a time, both [s since 1970]."""
        ahead_s, rate = self._by
        since_s = time.time() - (time.monotonic() - self._since_s)
        return since_s + (shown_s - ahead_s - since_s) / (1 + rate)
