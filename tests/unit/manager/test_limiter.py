"""What a limiter sees of real processes, which are small ones."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator

import pytest

from rtkit.deployment.limits import NO_LIMITS, SlaveLimits
from rtkit.manager.limits import limiter as module
from rtkit.manager.limits.limiter import Limiter
from rtkit.manager.limits.usage import proportional_memory, tree_usage

MIB = 1 << 20
Start = Callable[[str], "subprocess.Popen[str]"]


@pytest.fixture(autouse=True)
def no_groups(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "control_groups", lambda: None)


@pytest.fixture
def start() -> Iterator[Start]:
    """Start programs that print when they have done what they are to do, and then wait."""
    begun: list[subprocess.Popen[str]] = []

    def start(code: str) -> subprocess.Popen[str]:
        text = f"import os, sys\n{code}\nprint('there', flush=True)\nsys.stdin.read()"
        pipe = subprocess.PIPE
        process = subprocess.Popen([sys.executable, "-c", text], stdin=pipe, stdout=pipe, text=True)
        begun.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "there\n"
        return process

    yield start
    for process in begun:
        process.communicate(timeout=30.0)


def reached(pid: int, limits: SlaveLimits) -> str:
    limiter = Limiter()
    limiter.limit(1, pid, limits)
    told = [event.why for event in limiter.look()]
    return told[0] if told else ""


def test_memory_is_that_of_all_processes(start: Start) -> None:
    code = """kept = bytearray(b'x') * (60 << 20)
read, write = os.pipe()
if not os.fork():
    more = bytearray(b'x') * (60 << 20)
    os.write(write, b'x')
    sys.stdin.read()
    os._exit(0)
os.read(read, 1)"""
    pid = start(code).pid
    assert reached(pid, SlaveLimits(memory=100 * MIB)).startswith(
        "memory limit of 100 MiB reached ("
    )
    assert not reached(pid, SlaveLimits(memory=400 * MIB))


def test_what_processes_share_counts_once(start: Start) -> None:
    """Four of 60 MiB that is the same are no 240 MiB."""
    code = """kept = bytearray(b'x') * (60 << 20)
for _ in range(3):
    if not os.fork():
        sys.stdin.read()
        os._exit(0)"""
    pid = start(code).pid
    used = tree_usage(pid)
    assert len(used.pids) == 4
    assert used.memory > 240 * MIB > 120 * MIB > proportional_memory(used.pids)
    assert not reached(pid, SlaveLimits(memory=150 * MIB))
    assert reached(pid, SlaveLimits(memory=40 * MIB))


def test_processes_and_descriptors_are_counted(start: Start) -> None:
    code = """files = [open('/dev/null') for _ in range(50)]
for _ in range(3):
    if not os.fork():
        sys.stdin.read()
        os._exit(0)"""
    pid = start(code).pid
    assert not reached(pid, SlaveLimits(processes=4, descriptors=100))
    assert reached(pid, SlaveLimits(processes=3)) == "limit of 3 processes reached (4)"
    assert reached(pid, SlaveLimits(descriptors=50)).startswith(
        "limit of 50 descriptors reached (5"
    )


def test_the_kernel_holds_what_runs_away_with_room_above(start: Start) -> None:
    pid = start("").pid
    before = [
        resource.prlimit(pid, what) for what in (resource.RLIMIT_DATA, resource.RLIMIT_NOFILE)
    ]
    limiter = Limiter()
    limiter.limit(1, pid, SlaveLimits(memory=100 * MIB, descriptors=20))
    (data, data_hard), (files, files_hard) = (
        resource.prlimit(pid, what) for what in (resource.RLIMIT_DATA, resource.RLIMIT_NOFILE)
    )
    assert 600 * MIB < data < 1000 * MIB
    assert files == 84
    assert (data_hard, files_hard) == (before[0][1], before[1][1])
    limiter.limit(1, pid, NO_LIMITS)
    assert resource.prlimit(pid, resource.RLIMIT_DATA) == before[0]
    assert limiter.look_at == float("inf")


def test_a_limit_is_told_once_and_again_when_it_changes(start: Start) -> None:
    pid = start("").pid
    limiter = Limiter()
    limiter.limit(1, pid, SlaveLimits(memory=MIB))
    assert len(limiter.look()) == 1
    assert limiter.look() == []
    limiter.limit(1, pid, SlaveLimits(memory=2 * MIB))
    limiter.forget(1)
    assert limiter.look_at == float("inf")


def test_a_process_that_has_ended_reaches_nothing() -> None:
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    assert not reached(
        process.pid, SlaveLimits(memory=MIB, processes=1, descriptors=1, processor=0.1)
    )


def test_the_share_is_the_mean_of_the_window() -> None:
    times: deque[tuple[float, float]] = deque()
    shares = [module._share(times, n * 0.5, n * 0.4) for n in range(11)]
    assert shares[:10] == [0.0] * 10
    assert shares[10] == pytest.approx(0.8)
    for n in range(11, 21):
        share = module._share(times, n * 0.5, 4.0)  # at rest since
    assert share == 0.0


def test_time_of_children_that_were_waited_for_counts(start: Start) -> None:
    code = """import time
if not os.fork():
    while time.process_time() < 0.2:
        pass
    os._exit(0)
os.wait()"""
    assert tree_usage(start(code).pid).cpu_s >= 0.15  # in ticks


@pytest.mark.parametrize(
    ("reason", "last", "told"),
    [
        ("signal 9", "", "signal 9"),
        ("exit status 1", "MemoryError", "exit status 1"),
        (
            "signal 6",
            "memory allocation of 99 bytes failed",
            "memory limit of 1 MiB reached (signal 6: memory allocation of 99 bytes failed)",
        ),
    ],
)
def test_an_abort_for_want_of_memory_is_the_limit(reason: str, last: str, told: str) -> None:
    limiter = Limiter()
    limiter.limit(1, os.getpid(), NO_LIMITS)
    assert limiter.reason(1, reason, last) == reason
    limiter._slaves[1] = module._Limited(os.getpid(), SlaveLimits(memory=MIB))
    assert limiter.reason(1, reason, last) == told


def test_it_looks_often_only_at_what_can_run_away(start: Start) -> None:
    pid = start("").pid
    for limits, often_s in (
        (SlaveLimits(processor=4096), 0.5),
        (SlaveLimits(memory=1 << 50), 0.05),
    ):
        limiter = Limiter()
        limiter.limit(1, pid, limits)
        began = time.monotonic()
        assert limiter.look() == []
        assert began + often_s <= limiter.look_at <= time.monotonic() + often_s
