"""Large values travel in memory without a name: no /dev/shm is needed, and nothing stays."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import mountkit
import pytest
from waiting import told_pid

MODULE = '''
import os
from rtkit.component import Component, InPort, OutPort, Time, TimedLong, TimedOctetSeq

SIZE = 1_000_000


class Large(Component):
    """Send a large value for each number that comes; send on the number of each that came whole."""

    rate = 200.0
    out = OutPort(TimedOctetSeq)
    into = InPort(TimedOctetSeq)
    came = OutPort(TimedLong)
    wanted = InPort(TimedLong)
    number = 0

    def on_activated(self, context):
        if "source" in self.options:
            self.send(0)

    def send(self, number):
        self.out.write(TimedOctetSeq(Time(), bytes([number % 251]) * SIZE))

    def on_execute(self, context):
        for value in self.wanted.read_all():
            self.send(value.data)
        for value in self.into.read_all():
            if bytes(value.data) != bytes([self.number % 251]) * SIZE:
                raise ValueError(f"{self.number}: {len(value.data)} bytes")
            self.number += 1
            with open(os.environ["RTKIT_STATE_DIR"] + "/came", "w") as file:
                file.write(f"{self.number:9}")
            self.came.write(TimedLong(Time(), self.number))


def LargeInit(manager):
    manager.register_factory(Large)
'''
VIEWS = """
import os
from dataclasses import dataclass
import numpy as np
from numpy.typing import NDArray
from rtkit.component import Component, InPort, OutPort

SIZE = 200_000


@dataclass(frozen=True, slots=True)
class Picture:
    pixels: NDArray[np.uint8]


class Writer(Component):
    rate = 100.0
    out = OutPort(Picture)
    number = 0

    def on_execute(self, context):
        for _ in range(20):
            self.out.write(Picture(np.full(SIZE, self.number % 251, np.uint8)))
            self.number += 1


class Holder(Component):
    rate = 200.0
    into = InPort(Picture)
    count = 0

    def on_activated(self, context):
        self.kept = []

    def on_execute(self, context):
        for value in self.into.read_all():
            self.count += 1
            if len(self.kept) < 3:
                self.kept.append((int(value.pixels[0]), value.pixels[10:]))
        right = all((pixels == number).all() for number, pixels in self.kept)
        with open(os.environ["RTKIT_STATE_DIR"] + "/came", "w") as file:
            file.write(f"{self.count if right else -1:9}")


def ViewsInit(manager):
    manager.register_factory(Writer)
    manager.register_factory(Holder)
"""
BOUND_S = 25.0
MORE = 15

pytestmark = pytest.mark.skipif(bool(mountkit.missing()), reason=mountkit.missing())


def bring_up(shell: Any) -> None:
    """Have two slaves, one of which sends the next large value when the last one has come."""
    (shell.modules / "Large.py").write_text(MODULE)
    shell.ok("rtmgr start")
    shell.ok(
        "rtmgr /localhost/manager.mgr -c 'Large?instance_name=A&manager_name=a&source=1'"
        " -c 'Large?instance_name=B&manager_name=b'"
    )
    lossless = "-p dataport.buffer.write.full_policy=block"
    shell.ok(f"rtcon /localhost/A.rtc:out /localhost/B.rtc:into {lossless}")
    shell.ok(f"rtcon /localhost/B.rtc:came /localhost/A.rtc:wanted {lossless}")
    shell.ok("rtact /localhost/B.rtc /localhost/A.rtc")


def go_on(shell: Any, more: int = MORE) -> None:
    """Wait until more values have come: each that is lost, or comes broken, would end that."""
    file = Path(shell.environment["RTKIT_STATE_DIR"]) / "came"
    until = time.monotonic() + BOUND_S
    begin = end = None
    while begin is None or end < begin + more:
        assert time.monotonic() < until, shell.run("rtls -l /localhost").out + shell.log()
        text = file.read_text() if file.exists() else ""
        end = int(text) if text.strip() else 0
        begin = end if begin is None else begin
        time.sleep(0.01)


@pytest.mark.parametrize("options", ["size=64k", "ro"])
def test_no_folder_of_shared_memory_is_needed(shell: Any, options: str) -> None:
    """Nothing lies in it, so nothing of it stays when a slave is killed."""
    with mountkit.small("/dev/shm", options) as prefix:
        shell.prefix = prefix
        bring_up(shell)
        go_on(shell)
        os.kill(told_pid(shell, "a"), signal.SIGKILL)
        shell.run("rtmgr stop")
        left = subprocess.run(
            [*prefix, "ls", "-l", "/dev/shm"], capture_output=True, text=True, check=True
        )
        assert left.stdout == "total 0\n"


def test_memory_is_bounded_by_what_is_on_its_way(shell: Any) -> None:
    """However many large values were sent, and though their reader is killed and comes again."""
    bring_up(shell)
    go_on(shell)
    sender = told_pid(shell, "a")
    before = shared_of(sender)
    for _ in range(3):
        go_on(shell)
    assert shared_of(sender) <= before + 2 * (1 << 20)
    shell.ok("rtmgr stop")


def test_views_of_values_outlive_their_writer(shell: Any) -> None:
    """Thousands more are sent while a reader holds three; then either end is killed."""
    (shell.modules / "Views.py").write_text(VIEWS)
    shell.ok("rtmgr start")
    shell.ok(
        "rtmgr /localhost/manager.mgr -l Views.py:ViewsInit"
        " -c 'Writer?instance_name=W&manager_name=a'"
        " -c 'Holder?instance_name=H&manager_name=b'"
    )
    shell.ok("rtcon /localhost/W.rtc:out /localhost/H.rtc:into")
    shell.ok("rtact /localhost/H.rtc /localhost/W.rtc")
    writer, holder = told_pid(shell, "a"), told_pid(shell, "b")
    go_on(shell, 2000)
    assert shared_of(writer) < 20 * 250_000
    os.kill(writer, signal.SIGKILL)
    file = Path(shell.environment["RTKIT_STATE_DIR"]) / "came"
    file.unlink()
    until = time.monotonic() + BOUND_S
    while not (file.exists() and file.read_text().strip()):
        assert time.monotonic() < until
        time.sleep(0.01)
    assert int(file.read_text()) >= 2000  # -1 where what it holds has changed
    os.kill(holder, signal.SIGKILL)
    shell.ok("rtmgr stop")


def shared_of(pid: int) -> int:
    """Return the size of the shared memory that a process has made [bytes]."""
    files = [each for each in Path(f"/proc/{pid}/fd").iterdir() if "memfd:" in os.readlink(each)]
    sizes = {file.stat().st_ino: file.stat().st_size for file in files}
    assert sizes
    return sum(sizes.values())
