"""What is left of slaves is found where it can be: below this process, or anywhere."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from waiting import until

from rtkit.container import orphans
from rtkit.container.orphans import (
    MARK,
    Adopted,
    become_subreaper,
    end_family,
    end_orphans,
    end_sessions,
    family,
    reap_orphans,
)

SLAVE = """
import os, subprocess, sys
kinds = {
    "same": dict(),
    "own": dict(start_new_session=True, env={**os.environ, "%s": str(os.getpid())}),
}
left = subprocess.Popen(["sh", "-c", "sleep 60 & echo $!; wait"], stdout=subprocess.PIPE, text=True,
                        **kinds[sys.argv[1]])
print(left.pid, left.stdout.readline().strip(), flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def _heir() -> Iterator[None]:
    become_subreaper()
    yield
    import ctypes

    ctypes.CDLL(None).prctl(36, 0, 0, 0, 0)


def slave(kind: str) -> tuple[int, list[int]]:
    """Return the pid of a slave that has ended, and of the shell and its child that are left."""
    process = subprocess.Popen(
        [sys.executable, "-c", SLAVE % MARK, kind],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout is not None
    left = [int(word) for word in process.stdout.readline().split()]
    process.communicate()
    return process.pid, left


def is_alive(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("is_ancestor", [True, False])
@pytest.mark.parametrize("has_lists", [True, False])
def test_the_session_of_a_slave_is_ended(
    is_ancestor: bool, has_lists: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if not has_lists:
        exists = os.path.exists
        monkeypatch.setattr(
            orphans.os.path, "exists", lambda path: "children" not in path and exists(path)
        )
    pid, left = slave("same")
    assert all(map(is_alive, left))
    end_sessions({pid}, is_ancestor=is_ancestor)
    for each in left:
        os.waitid(os.P_PID, each, os.WEXITED)  # it has become our child, and ends
    assert not any(map(is_alive, left))


@pytest.mark.parametrize("is_ancestor", [True, False])
def test_an_orphan_that_bears_the_mark_is_ended_with_its_group(is_ancestor: bool) -> None:
    pid, (shell, sleep) = slave("own")
    end_sessions({pid}, is_ancestor=is_ancestor)
    for each in (shell, sleep):  # they are of one process group
        os.waitid(os.P_PID, each, os.WEXITED)


def test_orphans_are_reaped_but_for_those_that_somebody_waits_for() -> None:
    reap_orphans(())  # what other tests left
    _, left = slave("same")
    for each in left:
        os.kill(each, signal.SIGKILL)
    started = subprocess.Popen(["true"])
    for each in (*left, started.pid):
        os.waitid(os.P_PID, each, os.WEXITED | os.WNOWAIT)
    assert sorted(reap_orphans(())) == sorted(left)
    assert started.wait() == 0


def test_what_a_child_left_behind_is_ended_whatever_it_hides_from() -> None:
    hidden = "import os; os.setsid(); os.fork() and os._exit(0); os.setsid(); print(os.getpid(), "
    hidden += "flush=True); os.execve('/bin/sleep', ['sleep', '60'], {})"
    command = [sys.executable, "-c", f"import os\nif os.fork() == 0: {hidden}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        left = int(child.stdout.readline())
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
        comm = Path(f"/proc/{left}/comm")
        until(lambda: comm.read_text() == "sleep\n", "it has told its pid and not begun yet")
        kept = subprocess.Popen(["sleep", "60"])
        assert (left, "sleep") in end_orphans({child.pid, kept.pid})
    os.waitid(os.P_PID, left, os.WEXITED)
    assert is_alive(kept.pid)
    kept.kill()
    kept.wait()


def test_a_family_is_ended_and_no_stranger_with_a_pid_of_it() -> None:
    pid, (shell, sleep) = slave("same")
    known = family(os.getpid())
    assert {shell, sleep} <= known.keys()
    end_family({shell: known[shell], sleep: known[sleep] + 1})
    os.waitid(os.P_PID, shell, os.WEXITED)
    assert is_alive(sleep)
    end_family({sleep: known[sleep], pid: 1})
    os.waitid(os.P_PID, sleep, os.WEXITED)


def test_adopted_ones_are_reaped_once_nobody_else_has_done_so() -> None:
    _, left = slave("same")
    for each in left:
        os.kill(each, signal.SIGKILL)
        os.waitid(os.P_PID, each, os.WEXITED | os.WNOWAIT)
    adopted = Adopted()
    adopted.look()
    assert all(os.path.exists(f"/proc/{each}") for each in left)
    adopted.look()
    assert not any(os.path.exists(f"/proc/{each}") for each in left)


def test_who_has_no_children_is_not_looked_through() -> None:
    """Each slave ends so; ten of them read nothing of /proc."""
    script = (
        "from rtkit.container import orphans\n"
        "orphans._children = None\n"
        "orphans.end_children()\n"
        "print('none')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("none\n", "")
