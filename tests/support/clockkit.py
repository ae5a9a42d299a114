"""Shifts the wall clock of all processes of a shell; the machine's own clock stays as it is."""

from __future__ import annotations

import mmap
import os
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Any

_SOURCE = Path(__file__).with_name("jumping_clock.c")
_AHEAD = struct.Struct("=q")
YEAR_S = 365 * 86_400


def missing() -> str:
    """Return why no clock can jump here, empty if it can."""
    return "" if shutil.which("cc") else "there is no C compiler (cc)"


class WallClock:
    """The clock of whatever a shell starts from now on."""

    def __init__(self, shell: Any) -> None:
        library, file = shell.folder / "clock.so", shell.folder / "clock"
        build = ["cc", "-shared", "-fPIC", "-nostdlib", "-o", str(library), str(_SOURCE)]
        subprocess.run(build, check=True)
        file.write_bytes(bytes(_AHEAD.size))
        with open(file, "r+b") as stream:
            self._ahead = mmap.mmap(stream.fileno(), _AHEAD.size)
        shell.environment |= {"LD_PRELOAD": str(library), "RTKIT_TEST_CLOCK": str(file)}
        assert not os.environ.get("LD_PRELOAD"), "which would be lost"

    def jump(self, ahead_s: int) -> None:
        """Have the clock show so much more than it should [s], or less."""
        _AHEAD.pack_into(self._ahead, 0, ahead_s)
