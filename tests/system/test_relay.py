"""The far end of a link: what it says, passes, and ends."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from rtkit.hosts.relay import READY


@pytest.fixture
def started(manager: Any) -> Iterator[Any]:
    """What starts a relay to the manager of this host, and returns it with its id."""
    with ExitStack() as stack:

        def start(*words: str) -> tuple[subprocess.Popen[bytes], int]:
            line = [sys.executable, "-m", "rtkit.hosts.relay", "manager", *words]
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
            relay = stack.enter_context(
                subprocess.Popen(line, env=manager.environment, bufsize=0, **pipes)
            )
            stack.callback(relay.kill)
            assert relay.stdout is not None
            empty, pid, ready = (relay.stdout.readline() for _ in range(3))
            assert (empty, ready) == (b"\n", f"{READY}\n".encode())
            return relay, int(pid)

        yield start


def test_a_relay_ends_the_one_of_the_link_before(started: Any) -> None:
    (former, pid), (other, _) = started(), started()
    assert former.pid == pid
    later, _ = started(str(pid))
    assert former.wait(30) < 0
    assert (other.poll(), later.poll()) == (None, None)


def test_another_process_that_has_its_id_by_now_is_left_alone(started: Any) -> None:
    with subprocess.Popen(["sleep", "60"]) as stranger:
        relay, _ = started(str(stranger.pid))
        assert (stranger.poll(), relay.poll()) == (None, None)
        stranger.kill()
    started(str(stranger.pid))  # nobody has it
