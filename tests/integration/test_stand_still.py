"""Everything is stopped for a while and goes on: a direct link loses nothing, and still lives."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from rtkit.link import zenoh

RECEIVE = """
import sys
from rtkit.link import zenoh
from rtkit.link.local.streams import LocalStreams
folder, lease = sys.argv[1], float(sys.argv[2])
zenoh.LEASE_S = lease
streams = LocalStreams(folder + "/a")
endpoint, _ = streams.receive("rtd/t/h/w", lambda value: print(value.decode(), flush=True))
print(endpoint, flush=True)
sys.stdin.read()
streams.close()
"""
SEND = """
import sys
from rtkit.link import zenoh
from rtkit.link.local.streams import LocalStreams
folder, lease, endpoint = sys.argv[1], float(sys.argv[2]), sys.argv[3]
zenoh.LEASE_S = lease
streams = LocalStreams(folder + "/b")
outlet = streams.send(endpoint, "rtd/t/h/w", 10.0)
print("ready", flush=True)
for line in sys.stdin:
    outlet.put(line.strip().encode())
streams.close()
"""


class Link:
    """Two processes with a direct link between them."""

    def __init__(self, folder: str, lease_s: float) -> None:
        self.receiver = _started(RECEIVE, folder, str(lease_s))
        endpoint = self.receiver.stdout.readline().strip()  # type: ignore[union-attr]
        self.sender = _started(SEND, folder, str(lease_s), endpoint)
        assert self.sender.stdout.readline() == "ready\n"  # type: ignore[union-attr]

    def put(self, value: str) -> None:
        """Have a value sent."""
        self.sender.stdin.write(f"{value}\n")  # type: ignore[union-attr]
        self.sender.stdin.flush()  # type: ignore[union-attr]

    def stand_still(self, time_s: float) -> None:
        """Stop both processes for a while; let go on first who finds that time has passed."""
        for process in (self.sender, self.receiver):
            process.send_signal(signal.SIGSTOP)
        time.sleep(time_s)
        for process in (self.sender, self.receiver):
            process.send_signal(signal.SIGCONT)

    def come(self, count: int) -> list[str]:
        """Wait for values."""
        return [self.receiver.stdout.readline().strip() for _ in range(count)]  # type: ignore[union-attr]


def _started(code: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


@contextmanager
def linked(lease_s: float) -> Iterator[Link]:
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        link = Link(folder, lease_s)
        try:
            yield link
        finally:
            for process in (link.sender, link.receiver):
                process.kill()
                process.wait()


def lost_in(lease_s: float, stall_s: float) -> bool:
    """Whether what is sent right after a stand-still does not arrive."""
    with linked(lease_s) as link:
        link.put("before")
        assert link.come(1) == ["before"]
        link.stand_still(stall_s)
        link.put("after")
        link.sender.communicate()  # it ends when all is sent
        return "after" not in link.receiver.communicate()[0]


def test_the_lease_outlasts_what_is_promised() -> None:
    assert zenoh.LEASE_S >= 600.0


@pytest.mark.campaign
def test_a_stand_still_of_thirty_seconds_costs_no_value() -> None:
    assert not lost_in(zenoh.LEASE_S, 30.0)
