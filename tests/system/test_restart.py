"""The manager is killed; its slaves are found again by the next one."""

from __future__ import annotations

import json
import os
import re
import select
import signal
from typing import Any

import pytest
from counting import CHECKER
from faultkit import Order, Points
from waiting import told_pid, until

MANAGER = "/localhost/manager.mgr"
COUNTER = '''
from rtkit.component import Component, OutPort, Time, TimedLong


class Counter(Component):
    """Count."""

    rate = 100.0
    out = OutPort(TimedLong)

    def on_activated(self, context):
        self.number = 0

    def on_execute(self, context):
        self.number += 1
        self.out.write(TimedLong(Time(0, 0), self.number))


def CounterInit(manager):
    manager.register_factory(Counter)
'''

DAEMON = """
import subprocess
from rtkit.component import Component


class Daemon(Component):
    def on_activated(self, context):
        subprocess.Popen(["sleep", "1000"], start_new_session=True)
        subprocess.Popen(["sh", "-c", "setsid sleep 1000 & exit"]).wait()


def DaemonInit(manager):
    manager.register_factory(Daemon)
"""

HANG = """
import time
from rtkit.component import Component


class Hang(Component):
    def on_initialize(self):
        time.sleep(1000)


def HangInit(manager):
    manager.register_factory(Hang)
"""


def parent_of(pid: int) -> int:
    return int(stat(pid)[1])


def state_of(pid: int) -> str:
    return stat(pid)[0]


def stat(pid: int) -> list[str]:
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        return file.read().rpartition(")")[2].split()


def go_on(shell: Any, zygote: int) -> None:
    """Continue a stopped zygote, and wait until the manager knows its children."""
    os.kill(zygote, signal.SIGCONT)
    until(lambda: state_of(zygote) == "S", "the zygote has told them")
    shell.run("rtls /localhost")  # answered after what was told before


def kill_manager(shell: Any) -> None:
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    pidfd = os.pidfd_open(pid)
    os.kill(pid, signal.SIGKILL)
    until(lambda: _has_ended(pidfd), "the end of the manager")
    os.close(pidfd)


def end_by(pid: int, number: signal.Signals) -> None:
    """End a process, and wait for its end."""
    ended = os.pidfd_open(pid)
    os.kill(pid, number)
    assert select.select([ended], [], [], 10.0)[0]
    os.close(ended)


def _has_ended(pidfd: int) -> bool:
    try:
        signal.pidfd_send_signal(pidfd, 0)
    except ProcessLookupError:
        return True
    return False


def count(shell: Any) -> tuple[int, int]:
    """Return the last number that arrived and how many were missed."""
    file = shell.folder / "count"
    if not file.exists():
        return 0, 0
    last, gaps = map(int, file.read_text().split())
    return last, gaps


@pytest.fixture
def pair(manager: Any) -> Any:
    """Two slaves, one of which counts what the other sends."""
    (manager.modules / "Counter.py").write_text(COUNTER)
    (manager.modules / "Checker.py").write_text(CHECKER)
    manager.ok(
        f"rtmgr {MANAGER} -c 'Counter?instance_name=A&manager_name=a'"
        " -c 'Checker?instance_name=B&manager_name=b'"
    )
    manager.ok(
        "rtcon /localhost/A.rtc:out /localhost/B.rtc:into -i wire -p dataport.buffer.length=100000"
    )
    manager.ok("rtact /localhost/B.rtc /localhost/A.rtc")
    until(lambda: count(manager)[0] > 10, "the first numbers")
    return manager


def test_a_killed_manager_stops_no_component_and_loses_no_message(pair: Any) -> None:
    before = pair.ok("rtls -lR /localhost")
    slaves = [told_pid(pair, name) for name in "ab"]
    kill_manager(pair)
    last, _ = count(pair)
    until(lambda: count(pair)[0] > last + 20, "numbers without a manager")
    pair.ok("rtmgr start")
    assert pair.ok("rtls -lR /localhost") == before
    assert [told_pid(pair, name) for name in "ab"] == slaves
    last, _ = count(pair)
    until(lambda: count(pair)[0] > last + 20, "numbers under the next manager")
    assert count(pair)[1] == 0


def test_the_next_manager_is_in_charge(pair: Any) -> None:
    kill_manager(pair)
    pair.ok("rtmgr start")
    pair.ok("rtdeact /localhost/A.rtc")
    pair.ok("rtdis /localhost/A.rtc:out -i wire")
    pair.ok(f"rtmgr {MANAGER} -d A -c 'Counter?instance_name=C&manager_name=b'")
    assert pair.ok("rtls /localhost").split() == ["B.rtc", "C.rtc", "manager.mgr/"]


def test_the_end_of_a_found_slave_is_told_with_its_reason(pair: Any) -> None:
    slave = told_pid(pair, "a")
    kill_manager(pair)
    pair.ok("rtmgr start")
    os.kill(slave, signal.SIGSTOP)
    until(lambda: "(stopped)" in pair.ok("rtls -l /localhost"), "the stop")
    os.kill(slave, signal.SIGCONT)
    until(lambda: "(stopped)" not in pair.ok("rtls -l /localhost"), "the continuation")
    os.kill(slave, signal.SIGKILL)
    until(lambda: "*A.rtc  (signal 9)" in pair.ok("rtls -l /localhost"), "the zombie")


def test_slaves_that_ended_without_a_manager_are_reported_once(pair: Any) -> None:
    """The zygote knows how they ended; a slave that ended with its zygote is made again."""
    slave = told_pid(pair, "a")
    kill_manager(pair)
    end_by(slave, signal.SIGSEGV)
    pair.ok("rtmgr start")
    shown = pair.ok("rtls -l /localhost")
    assert "*A.rtc  (signal 11)" in shown
    assert "slave a ended while no manager ran: signal 11" in pair.log()
    slave = told_pid(pair, "b")
    zygote = parent_of(slave)
    kill_manager(pair)
    for pid in (zygote, slave):
        os.kill(pid, signal.SIGKILL)
    until(lambda: not os.path.exists(f"/proc/{slave}"), "its end")
    pair.ok("rtmgr start")
    shown = pair.ok("rtls -l /localhost")
    assert "*A.rtc  (signal 11)" in shown  # still
    assert "Active  1/0  1/0  0/0  0/0  B.rtc" in shown  # all ended with it: it is made again
    pair.ok("rtdel -z")
    assert pair.ok("rtls /localhost").split() == ["B.rtc", "manager.mgr/"]


@pytest.mark.parametrize("point", ["zygote.alone", "zygote.reaped", "zygote.accepted"])
def test_a_slow_zygote_still_tells_how_a_slave_ended(shell: Any, point: str) -> None:
    """Each delay is longer than a manager takes to start, and shorter than it waits."""
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    shell.ok("rtmgr start --allow-faults")
    for name in "ab":  # a zygote ends with its last child
        shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name={name}&manager_name={name}'")
    points.arm(Order(point, 1, "delay", "1.5"))
    slave = told_pid(shell, "a")
    kill_manager(shell)
    end_by(slave, signal.SIGSEGV)
    shell.ok("rtmgr start --allow-faults")
    assert points.has_struck(1)
    shown = shell.ok("rtls -l /localhost")
    assert "*a.rtc  (signal 11)" in shown
    assert shell.log().count("slave a ended while no manager ran: signal 11") == 1


@pytest.mark.parametrize("point", ["zygote.alone", "zygote.listening"])
def test_a_zygote_killed_as_it_is_left_alone_costs_no_slave(shell: Any, point: str) -> None:
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    shell.ok("rtmgr start --allow-faults")
    shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name=A&manager_name=a'")
    shell.ok("rtact /localhost/A.rtc")
    points.arm(Order(point, 1))
    slave = told_pid(shell, "a")
    kill_manager(shell)
    assert points.has_struck(1)
    shell.ok("rtmgr start --allow-faults")
    until(lambda: "A.rtc" in shell.ok("rtls /localhost"), "the slave's return")
    assert told_pid(shell, "a") == slave
    assert "Active" in shell.ok("rtcat /localhost/A.rtc")


def test_an_end_that_the_manager_did_not_live_to_hear_is_told_the_next_one(shell: Any) -> None:
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    shell.ok("rtmgr start --allow-faults")
    for name in "ab":  # a zygote ends with its last child
        shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name={name}&manager_name={name}'")
    slave = told_pid(shell, "a")
    points.arm(Order("zygote.reaped", 1, "delay", "1.5"))
    os.kill(slave, signal.SIGSEGV)
    until(lambda: points.has_struck(1), "the end is noticed, but not reported")
    kill_manager(shell)
    shell.ok("rtmgr start --allow-faults")
    assert "*a.rtc  (signal 11)" in shell.ok("rtls -l /localhost")


def test_a_zygote_is_found_by_no_manager_of_its_own(shell: Any) -> None:
    """It listens from its start; its path goes with it, also when it is killed."""
    shell.ok("rtmgr start")
    shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name=A&manager_name=a'")
    (path,) = (shell.folder / "run").glob("*.zygote")
    kill_manager(shell)
    shell.ok("rtmgr start")
    listening = lambda: [*(shell.folder / "run").glob("*.zygote")]  # noqa: E731
    until(lambda: len(listening()) == 2, "the next zygote")
    assert path.exists()
    os.kill(int(path.name.split(".")[-2]), signal.SIGKILL)
    shell.ok("rtmgr stop")
    assert not listening()


def test_a_stopped_zygote_does_not_hold_up_the_next_manager(shell: Any) -> None:
    shell.ok("rtmgr start")
    shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name=A&manager_name=a'")
    slave = told_pid(shell, "a")
    zygote = parent_of(slave)
    kill_manager(shell)
    os.kill(zygote, signal.SIGSTOP)
    try:
        shell.ok("rtmgr start")
        assert shell.ok("rtls /localhost").split() == ["A.rtc", "manager.mgr/"]
        assert told_pid(shell, "a") == slave, "it is taken up, not made again"
    finally:
        go_on(shell, zygote)
    os.kill(slave, signal.SIGKILL)
    until(lambda: "*A.rtc  (signal 9)" in shell.ok("rtls -l /localhost"), "the zombie")


def test_a_zygote_found_late_says_how_a_slave_ended(shell: Any) -> None:
    """The manager hears of the end at once, but waits for the reason that the zygote knows."""
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    shell.ok("rtmgr start --allow-faults")
    for name in "ab":  # a zygote ends with its last child
        shell.ok(f"rtmgr {MANAGER} -c 'ConsoleIn?instance_name={name}&manager_name={name}'")
    slave = told_pid(shell, "a")
    zygote = parent_of(slave)
    kill_manager(shell)
    os.kill(zygote, signal.SIGSTOP)
    try:
        shell.ok("rtmgr start --allow-faults")
    finally:
        go_on(shell, zygote)
    points.arm(Order("zygote.reaped", 1, "delay", "1.5"))
    os.kill(slave, signal.SIGKILL)
    until(lambda: points.has_struck(1), "the zygote's look")
    until(lambda: "*a.rtc" in shell.ok("rtls -l /localhost"), "the end")
    assert "*a.rtc  (signal 9)" in shell.ok("rtls -l /localhost")


@pytest.mark.parametrize("is_zygote_killed", [False, True])
def test_a_stopped_slave_is_shown_and_comes_back(pair: Any, is_zygote_killed: bool) -> None:
    before = pair.ok("rtls -lR /localhost")
    slave = told_pid(pair, "a")
    zygote = parent_of(slave)
    kill_manager(pair)
    os.kill(slave, signal.SIGSTOP)
    if is_zygote_killed:
        os.kill(zygote, signal.SIGKILL)
    pair.ok("rtmgr start")
    shown = pair.ok("rtls -lR /localhost")
    assert "A.rtc  (stopped)" in shown
    assert "a.mgr  (stopped)" in shown
    assert "1/1" in next(line for line in shown.splitlines() if "B.rtc" in line)
    assert "it is stopped" in pair.run("rtdeact /localhost/A.rtc").err
    os.kill(slave, signal.SIGCONT)
    until(lambda: pair.ok("rtls -lR /localhost") == before, "its return")
    last, _ = count(pair)
    until(lambda: count(pair)[0] > last + 20, "numbers")
    assert count(pair)[1] == 0
    pair.ok("rtdeact /localhost/A.rtc")
    os.kill(slave, signal.SIGKILL)
    why = "exit status unknown" if is_zygote_killed else "signal 9"
    until(lambda: f"*A.rtc  ({why})" in pair.ok("rtls -l /localhost"), "the zombie")


@pytest.mark.parametrize("end", ["rtexit --force /localhost/manager.mgr/b.mgr", "rtmgr stop"])
def test_a_slave_that_hangs_over_a_restart_can_be_ended(pair: Any, end: str) -> None:
    """One that hangs while it makes another component, and one that is stopped."""
    (pair.modules / "Hang.py").write_text(HANG)
    pair.run(f"rtmgr {MANAGER} --timeout 0.3 -c 'Hang?instance_name=H&manager_name=b'")
    slaves = [told_pid(pair, name) for name in "ab"]
    kill_manager(pair)
    os.kill(slaves[0], signal.SIGSTOP)
    pair.ok("rtmgr start")
    shown = pair.ok("rtls -lR /localhost")
    assert re.search(r"B\.rtc +\(does not answer\)", shown), shown
    assert re.search(r"b\.mgr +\(does not answer", shown), shown
    pair.run(end)
    until(lambda: not os.path.exists(f"/proc/{slaves[1]}"), "its end")
    if "rtexit" in end:
        assert "B.rtc" not in pair.ok("rtls /localhost")
        pair.ok("rtexit --force /localhost/manager.mgr/a.mgr")
    assert not os.path.exists(f"/proc/{slaves[0]}")


def test_manager_and_zygote_killed(pair: Any) -> None:
    slave = told_pid(pair, "a")
    zygote = parent_of(slave)
    kill_manager(pair)
    os.kill(zygote, signal.SIGKILL)
    pair.ok("rtmgr start")
    until(lambda: "A.rtc" in pair.ok("rtls /localhost"), "the slaves' return")
    os.kill(slave, signal.SIGSTOP)
    until(lambda: "(stopped)" in pair.ok("rtls -l /localhost"), "the stop")
    os.kill(slave, signal.SIGCONT)
    until(lambda: "(stopped)" not in pair.ok("rtls -l /localhost"), "the continuation")
    os.kill(slave, signal.SIGKILL)
    until(lambda: "*A.rtc  (exit status unknown)" in pair.ok("rtls -l /localhost"), "the zombie")


@pytest.mark.timeout(300)
def test_five_managers_one_after_the_other(pair: Any) -> None:
    for _ in range(5):
        kill_manager(pair)
        pair.ok("rtmgr start")
        assert pair.ok("rtls /localhost").split() == ["A.rtc", "B.rtc", "manager.mgr/"]
    assert count(pair)[1] == 0


def test_what_was_left_is_ended_by_a_stop_at_once(pair: Any) -> None:
    kill_manager(pair)
    pair.ok("rtmgr start")
    pair.ok("rtmgr stop")
    assert list((pair.folder / "run").iterdir()) == []


def test_a_stop_ends_what_a_killed_manager_left(pair: Any) -> None:
    """Also what the components had started, in sessions of their own."""
    (pair.modules / "Daemon.py").write_text(DAEMON)
    pair.ok(f"rtmgr {MANAGER} -c 'Daemon?instance_name=D&manager_name=d'")
    pair.ok("rtact /localhost/D.rtc")
    kill_manager(pair)
    status, out, err = pair.run("rtmgr stop")
    ended = "manager 'manager' had been killed; what it left was ended (3 slaves)"
    told = f"rtmgr: {ended}; what it kept for its next start is removed\n"
    assert (status, out, err) == (0, "", told)
    assert list((pair.folder / "run").iterdir()) == []
    assert pair.run("rtmgr stop").status == 1


def test_a_slave_that_waits_for_a_manager_ends_with_all_that_it_started(pair: Any) -> None:
    (pair.modules / "Daemon.py").write_text(DAEMON)
    pair.ok(f"rtmgr {MANAGER} -c 'Daemon?instance_name=D&manager_name=d'")
    pair.ok("rtact /localhost/D.rtc")
    slaves = [told_pid(pair, name) for name in "abd"]
    kill_manager(pair)
    for pid in slaves:
        os.kill(pid, signal.SIGTERM)
