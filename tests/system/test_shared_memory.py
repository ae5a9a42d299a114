"""No /dev/shm, or no room in it: large values are copied, none is lost, nobody dies of it."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import jsonrecords
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


def go_on(shell: Any) -> None:
    """Wait until more values have come: each that is lost, or comes broken, would end that."""
    file = Path(shell.environment["RTKIT_STATE_DIR"]) / "came"
    until = time.monotonic() + BOUND_S
    begin = end = None
    while begin is None or end < begin + MORE:
        assert time.monotonic() < until, shell.run("rtls -l /localhost").out + shell.log()
        text = file.read_text() if file.exists() else ""
        end = int(text) if text.strip() else 0
        begin = end if begin is None else begin
        time.sleep(0.01)


@pytest.mark.parametrize("options", ["size=64k", "ro"])
def test_shared_memory_that_cannot_be_had_from_the_start(shell: Any, options: str) -> None:
    with mountkit.small("/dev/shm", options) as prefix:
        shell.prefix = prefix
        bring_up(shell)
        go_on(shell)
        found = jsonrecords.checked(shell.ok("rtdoctor --json"))
        assert [each["severity"] for each in found if each["check"] == "links"] == ["warning"]
        shell.ok("rtmgr stop")


def test_shared_memory_that_fills_up_and_is_emptied(shell: Any) -> None:
    with mountkit.small("/dev/shm", "size=64m") as prefix:
        shell.prefix = prefix
        bring_up(shell)
        go_on(shell)
        within(prefix, "ls -s /dev/shm/*.zenoh | sort -n | tail -n 1 | grep -qE '^ *[0-9]{4}'")
        within(prefix, "cat /dev/zero >/dev/shm/stranger 2>/dev/null; test -s /dev/shm/stranger")
        go_on(shell)
        within(prefix, "rm /dev/shm/stranger")
        go_on(shell)
        shell.ok("rtmgr stop")


def within(prefix: list[str], line: str) -> None:
    """Run a line of shell where the small file system is seen."""
    subprocess.run([*prefix, "sh", "-c", line], check=True, env=dict(os.environ))


def test_nothing_stays_when_a_manager_was_stopped(shell: Any) -> None:
    """Neither what slaves held that ended in order, nor what one held that was killed."""
    with mountkit.small("/dev/shm", "size=500m") as prefix:
        shell.prefix = prefix
        bring_up(shell)
        go_on(shell)
        slave = told_pid(shell, "a")
        assert subprocess.run([*prefix, "ls", "/dev/shm"], capture_output=True, check=True).stdout
        os.kill(slave, signal.SIGKILL)
        shell.run("rtmgr stop")
        left = subprocess.run(
            [*prefix, "ls", "-l", "/dev/shm"], capture_output=True, text=True, check=True
        )
        assert left.stdout == "total 0\n"
