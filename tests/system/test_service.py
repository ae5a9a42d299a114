"""A manager as a service: what it tells its service manager, and when."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from faultkit import Order, Points
from notifykit import ServiceManager
from waiting import told_pid

from rtkit.tree.connect import connect

MANAGER = "/localhost/manager.mgr"
WATCHDOG_S = 0.6
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture
def systemd(shell: Any) -> Iterator[ServiceManager]:
    service_manager = ServiceManager(shell.folder / "notify", WATCHDOG_S)
    shell.environment.update(service_manager.environment)
    yield service_manager
    service_manager.close()


@pytest.fixture
def points(shell: Any) -> Points:
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    return points


@pytest.fixture
def start(shell: Any) -> Iterator[Start]:
    """Start a manager in the foreground; it is ended with the test."""
    started: list[subprocess.Popen[str]] = []

    def run(options: str = "--allow-faults") -> subprocess.Popen[str]:
        started.append(shell.open(f"rtmgr run {options}"))
        return started[-1]

    yield run
    for process in started:
        process.kill()
    shell.run("rtmgr stop")


def environment_of(pid: int) -> str:
    return Path(f"/proc/{pid}/environ").read_text()


def test_a_service_tells_of_its_whole_life(
    shell: Any, systemd: ServiceManager, start: Start
) -> None:
    process = start()
    ready = systemd.until("READY")
    assert ready["MAINPID"] == str(process.pid)
    assert ready["STATUS"] == "0 components, 0 slaves"
    # Ready means that it answers: nobody has to wait for it now.
    shell.ok(f"rtmgr -c ConsoleIn -c ConsoleOut?manager_name=s {MANAGER}")
    shell.ok("rtact /localhost/ConsoleIn0.rtc")
    systemd.until("STATUS", "2 components, 1 slave")
    systemd.until("WATCHDOG", "1")
    os.kill(slave := told_pid(shell, "s"), 0)
    assert "NOTIFY_SOCKET" not in environment_of(slave), "a slave could send in its name"
    # It starts anew in the same process, and is ready again when all is there again.
    systemd.forget()
    before = shell.ok("rtls -lR /localhost")
    shell.ok("rtmgr restart")
    assert int(systemd.until("RELOADING")["MONOTONIC_USEC"]) > 0
    assert systemd.until("READY")["STATUS"] == "2 components, 1 slave"
    systemd.until("WATCHDOG", "1")
    assert shell.ok("rtls -lR /localhost") == before
    assert shell.ok("rtmgr restart --forget") == ""
    assert systemd.until("READY")["STATUS"] == "0 components, 0 slaves"
    process.send_signal(signal.SIGTERM)
    systemd.until("STOPPING", "1")
    assert process.wait(20) == 0


def test_what_a_service_is_stopped_with_keeps_what_it_holds(
    shell: Any, systemd: ServiceManager, start: Start
) -> None:
    process = start()
    systemd.until("READY")
    shell.ok(f"rtmgr -c ConsoleIn?manager_name=s {MANAGER}")
    shell.ok("rtmgr stop --keep")
    assert process.wait(20) == 0
    status, _, err = shell.run("rtmgr stop --keep")
    assert (status, "is not running" in err) == (1, True)
    process = start()
    assert systemd.until("READY")["STATUS"] == "1 component, 1 slave"
    shell.ok("rtmgr stop")
    assert process.wait(20) == 0
    start()
    assert systemd.until("READY")["STATUS"] == "0 components, 0 slaves"


def test_slaves_are_found_by_the_manager_that_systemd_starts_next(
    shell: Any, systemd: ServiceManager, start: Start
) -> None:
    process = start()
    systemd.until("READY")
    shell.ok(f"rtmgr -c ConsoleIn?manager_name=s {MANAGER}")
    slave = told_pid(shell, "s")
    process.kill()
    process.wait()
    start()
    assert systemd.until("READY")["STATUS"] == "1 component, 1 slave"
    assert told_pid(shell, "s") == slave


def test_it_is_not_ready_before_it_answers(
    shell: Any, systemd: ServiceManager, start: Start, points: Points
) -> None:
    """The first question comes from itself, at its own socket; the answer is what it waits for."""
    points.arm(Order("duty.request", 1, "delay", "1"))
    start()
    assert points.has_struck(1)
    while (notice := systemd.receive(0.5)) is not None:
        assert "READY" not in notice
    systemd.until("READY")
    shell.ok("rtls /localhost")


def test_a_loop_that_is_stuck_stops_the_heartbeats(
    shell: Any,
    systemd: ServiceManager,
    start: Start,
    points: Points,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    start()
    systemd.until("READY")
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, shell.environment[key])
    with connect() as tree:
        points.arm(Order("duty.request", 1, "delay", str(4 * WATCHDOG_S)))
        asking = threading.Thread(target=tree.get, args=("manager.pid",))
        asking.start()
        assert points.has_struck(1)
        systemd.forget()
        assert systemd.receive(2 * WATCHDOG_S) is None
        asking.join()
    systemd.until("WATCHDOG")


@pytest.mark.parametrize(
    "variables",
    [
        {"NOTIFY_SOCKET": "/nowhere/notify"},
        {"WATCHDOG_PID": "1"},
        {"WATCHDOG_USEC": "soon"},
        {"NOTIFY_SOCKET": "vsock:2:1234"},
    ],
)
def test_nobody_to_tell_is_no_reason_to_end(
    shell: Any, systemd: ServiceManager, start: Start, variables: dict[str, str]
) -> None:
    shell.environment.update(variables)
    process = start()
    while shell.run("rtls /localhost").status:
        assert process.poll() is None
    if "NOTIFY_SOCKET" not in variables:
        systemd.until("READY")
        shell.ok(f"rtmgr -c ConsoleIn {MANAGER}")
        shell.ok("rtmgr stop")
        systemd.until("STOPPING")
        assert all("WATCHDOG" not in notice for notice in systemd.notices)
