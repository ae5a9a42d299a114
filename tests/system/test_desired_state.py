"""What was acknowledged is there again: after a kill, a loss of power, with a broken store."""

from __future__ import annotations

import json
import os
import select
import signal
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mountkit
import pytest
from faultkit import Order, Points
from waiting import until

MANAGER = "/localhost/manager.mgr"
ASIDE = "the damaged state store is kept aside: "


def pids(shell: Any) -> list[int]:
    """Return the manager and all that it started, the manager last."""
    manager = json.loads(shell.ok("rtmgr status --json"))["pid"]
    mine = f"RTKIT_RUNTIME_DIR={shell.folder}/run".encode()
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and int(entry.name) != manager:
            try:
                if mine in (entry / "environ").read_bytes().split(b"\0"):
                    found.append(int(entry.name))
            except OSError:
                continue
    return [*found, manager]


def kill(processes: list[int], number: int = signal.SIGKILL) -> None:
    """End processes, and wait until each has ended."""
    opened = []
    for pid in processes:
        try:
            opened.append(os.pidfd_open(pid))
        except ProcessLookupError:
            continue
    for pidfd in opened:
        try:
            signal.pidfd_send_signal(pidfd, number)
        except ProcessLookupError:
            continue
    for pidfd in opened:
        assert select.select([pidfd], [], [], 20.0)[0]
        os.close(pidfd)


def shown(shell: Any) -> tuple[str, str, str]:
    """Return all that is to be the same again."""
    gains = shell.ok("rtconf -l /localhost/C.rtc")
    return shell.ok("rtls -lR /localhost"), gains, shell.ok("rtcat -l /localhost/S.rtc:distance")


@pytest.fixture
def robot(manager: Any) -> Any:
    """Two slaves and the manager itself hold something that is connected, set and active."""
    manager.ok(
        f"rtmgr {MANAGER} -c 'Sensor?instance_name=S&manager_name=s'"
        " -c 'Controller?instance_name=C&manager_name=c' -c 'Motor?instance_name=M'"
    )
    manager.ok("rtcon /localhost/S.rtc:distance /localhost/C.rtc:distance -i wire")
    manager.ok("rtconf /localhost/C.rtc set gain 2.5")
    for words in ("copy default race gain=3", "copy race other", "remove other"):
        manager.ok(f"rtconf /localhost/C.rtc {words}")
    manager.ok("rtconf -s race /localhost/C.rtc act")
    assert set(manager.ok("rtconf /localhost/C.rtc").split()) == {"+default", "+race*"}
    manager.ok("rtact /localhost/S.rtc /localhost/C.rtc")
    return manager


def test_a_killed_manager_finds_the_living_and_makes_its_own_again(robot: Any) -> None:
    before, slaves = shown(robot), pids(robot)[:-1]
    kill(pids(robot)[-1:])
    robot.ok("rtmgr start")
    assert shown(robot) == before
    assert set(slaves) <= set(pids(robot))


def test_all_is_back_after_a_loss_of_power(robot: Any) -> None:
    """Also twice, also who was told to end meanwhile is not; and a stop is the end of it."""
    before = shown(robot)
    for _ in range(2):
        kill(pids(robot))
        robot.ok("rtmgr start")
        assert shown(robot) == before
    robot.ok(f"rtmgr {MANAGER} -d M")
    robot.ok("rtexit /localhost/S.rtc")
    robot.ok("rtdeact /localhost/C.rtc")
    kill(pids(robot))
    note = "manager 'manager' does not run, and has kept what it held"
    assert note in robot.run("rtdoctor").out
    robot.ok("rtmgr start")
    assert robot.ok("rtls /localhost").split() == ["C.rtc", "manager.mgr/"]
    assert "Inactive" in robot.ok("rtls -l /localhost/C.rtc")
    robot.ok("rtmgr stop")
    robot.ok("rtmgr start")
    assert robot.ok("rtls /localhost").split() == ["manager.mgr/"]


def test_the_end_of_the_machine_forgets_nothing_and_a_user_may(robot: Any) -> None:
    before = shown(robot)
    kill(pids(robot)[-1:], signal.SIGTERM)
    robot.ok("rtmgr start")
    assert shown(robot) == before
    kill(pids(robot))
    assert "is removed" in robot.run("rtmgr stop").err
    assert robot.run("rtmgr stop").status == 1
    robot.ok("rtmgr start")
    assert robot.ok("rtls /localhost").split() == ["manager.mgr/"]


def test_a_manager_killed_in_its_commit_or_while_it_restores_leaves_nothing_half(
    shell: Any,
) -> None:
    """A value holds or does not; what one manager has begun to make again the next one ends."""
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    start = "rtmgr start --allow-faults"
    shell.ok(start)
    shell.ok(f"rtmgr {MANAGER} -c 'Controller?instance_name=C&manager_name=c'")
    shell.ok("rtact /localhost/C.rtc")
    points.arm(Order("manager.recording", 1))
    assert shell.run("rtconf /localhost/C.rtc set gain 77").status == 1
    points.disarm()
    shell.ok(start)
    found = shell.ok("rtls -l /localhost"), shell.ok("rtconf /localhost/C.rtc get gain")
    for sent in (1, 2, 3):  # create, set, activate
        kill(pids(shell))
        points.arm(Order("manager.sending", sent))
        assert shell.run(start).status == 1, sent
        points.disarm()
        shell.ok(start)
        now = shell.ok("rtls -l /localhost"), shell.ok("rtconf /localhost/C.rtc get gain")
        assert now == found, sent


def test_restoring_can_be_declined(robot: Any) -> None:
    kill(pids(robot))
    status, _, err = robot.run("rtmgr start -o rtkit.restore:NO")
    path = f"{robot.folder}/state/manager.desired.unrestored-1"
    assert (status, err) == (
        0,
        f"rtmgr: warning: the unrestored state store is kept aside: {path}\n",
    )
    left = robot.ok("rtls /localhost").split()
    assert all(each.startswith("*") for each in left[:-1]), left  # how they ended is told
    assert os.path.exists(path)


def test_a_store_that_is_gone_or_a_link_is_told(robot: Any) -> None:
    path = f"{robot.folder}/state/manager.desired"
    kill(pids(robot))
    os.unlink(path)
    told = f"the state store was removed ({path}): only what lives is known"
    assert robot.run("rtmgr start") == (0, "", f"rtmgr: warning: {told}\n")
    assert told in robot.ok("rtls -l /localhost")
    robot.ok("rtmgr stop")
    target = robot.folder / "target"
    os.symlink(target, path)
    status, _, err = robot.run("rtmgr start")
    assert (status, f"{path} is a link, and not written through" in err) == (1, True), err
    assert not target.exists()
    os.unlink(path)
    assert robot.run("rtmgr start") == (0, "", "")


def _cut(path: str) -> None:
    os.truncate(path, 0)
    os.truncate(f"{path}-wal", 0)


def _rubbish(path: str) -> None:
    Path(path).write_text("rubbish\n" * 2000)
    os.unlink(f"{path}-wal")


def _other_form(path: str) -> None:
    with sqlite3.connect(path) as db:
        db.execute("pragma user_version = 0")
    db.close()


@pytest.mark.parametrize("damage", [_cut, _rubbish, _other_form])
def test_a_damaged_store_is_put_aside_and_made_anew_from_what_lives(
    robot: Any, damage: Callable[[str], None]
) -> None:
    """It is told at the start, in the log, by rtls and by rtdoctor; the next one is whole."""
    path = f"{robot.folder}/state/manager.desired"
    kill(pids(robot)[-1:])
    damage(path)
    status, _, err = robot.run("rtmgr start")
    assert status == 0
    assert err.startswith(f"rtmgr: warning: {ASIDE}{path}.damaged-1 (")
    assert ASIDE in robot.log()
    assert f"({ASIDE}" in robot.ok("rtls -l /localhost")
    assert f"{path}.damaged-1" in robot.run("rtdoctor").out
    assert robot.ok("rtls /localhost").split() == ["C.rtc", "S.rtc", "manager.mgr/"]
    before = shown(robot)[1:]
    kill(pids(robot))
    robot.ok("rtmgr start")
    assert shown(robot)[1:] == before
    assert robot.ok("rtls -l /localhost").count("Active ") == 2


def test_a_store_of_the_future_or_in_use_is_not_touched(robot: Any) -> None:
    path = f"{robot.folder}/state/manager.desired"
    kill(pids(robot))
    with sqlite3.connect(path) as db:
        db.execute("pragma user_version = 2")
    db.close()
    status, _, err = robot.run("rtmgr start")
    cure = "rtmgr start -o rtkit.restore:NO puts it aside and begins empty"
    told = f"a newer rtkit wrote the state store, {path} (version 2): use that one, or {cure}"
    assert (status, err) == (1, f"rtmgr: {told}\n")
    db = sqlite3.connect(path, isolation_level=None)
    db.execute("pragma user_version = 1")
    db.execute("begin exclusive")
    status, _, err = robot.run("rtmgr start")
    with open("/proc/self/comm", encoding="utf-8") as comm:
        whose = f"process {os.getpid()} ({comm.read().strip()})"
    cure = "stop that, or give this manager a RTKIT_STATE_DIR of its own"
    told = f"{whose} uses the state store, {path}; {cure}"
    assert (status, err) == (1, f"rtmgr: {told}\n")
    db.close()
    robot.ok("rtmgr start")
    assert robot.ok("rtls /localhost").split() == ["C.rtc", "M.rtc", "S.rtc", "manager.mgr/"]


def test_a_store_that_is_removed_under_a_living_manager_is_written_anew(robot: Any) -> None:
    path = f"{robot.folder}/state/manager.desired"
    os.unlink(path)
    robot.ok("rtconf /localhost/C.rtc set gain 3.5")
    told = f"  (the state store was removed ({path}); all is written anew)"
    before = shown(robot)
    assert told in before[0]
    kill(pids(robot))
    robot.ok("rtmgr start")
    assert shown(robot) == (before[0].replace(told, ""), *before[1:])


@pytest.mark.skipif(bool(mountkit.missing()), reason=mountkit.missing())
def test_what_cannot_be_recorded_is_refused_and_nothing_runs_worse(shell: Any) -> None:
    """The disk is full: what is new is refused and leaves nothing; with room again all goes on.

    What was done all the same is recorded then, though nobody asks for anything.
    """
    with mountkit.small(f"{shell.folder}/state", "size=256k") as prefix:
        shell.prefix = [*prefix]
        in_there = [*prefix, "sh", "-c"]
        shell.run_there = lambda line: os.spawnvp(os.P_WAIT, in_there[0], [*in_there, line])
        shell.run_there(f"chmod 700 {shell.folder}/state")
        shell.ok("rtmgr start")
        shell.ok(
            f"rtmgr {MANAGER} -c 'Sensor?instance_name=S&manager_name=s'"
            " -c 'Controller?instance_name=C&manager_name=c'"
        )
        shell.ok("rtact /localhost/S.rtc")
        shell.run_there(f"head -c 1000000 /dev/zero > {shell.folder}/state/full 2>/dev/null")
        status, _, err = shell.run("rtconf /localhost/C.rtc set gain 7")
        assert (status, "done all the same" in err) == (1, True), err
        shell.run_there(f"rm {shell.folder}/state/full")
        until(lambda: "cannot be recorded" not in shell.ok("rtls -l /localhost"), "room")
        kill(pids(shell))
        shell.ok("rtmgr start")
        assert shell.ok("rtconf /localhost/C.rtc get gain") == "7\n"
        shell.ok("rtexit /localhost/C.rtc")
        for number in (1, 2):
            # What is not the store's own any more after a failure is used up, too.
            full = f"{shell.folder}/state/full{number}"
            shell.run_there(f"head -c 1000000 /dev/zero > {full} 2>/dev/null")
            line = f"rtmgr {MANAGER} -c 'Sensor?instance_name=T{number}&manager_name=t'"
            status, _, err = shell.run(line)
            assert (status, "what is wished cannot be recorded: " in err) == (1, True), err
        assert shell.ok("rtls /localhost").split() == ["S.rtc", "manager.mgr/"]
        assert "Active" in shell.ok("rtls -l /localhost/S.rtc")
        assert "the desired state cannot be recorded" in shell.ok("rtls -l /localhost")
        status, _, err = shell.run("rtdeact /localhost/S.rtc")
        assert (status, "done all the same" in err) == (1, True), err
        assert "Inactive" in shell.ok("rtls -l /localhost/S.rtc")
        shell.run_there(f"rm {shell.folder}/state/full*")
        shell.ok(f"rtmgr {MANAGER} -c 'Sensor?instance_name=T&manager_name=t'")
        assert "cannot be recorded" not in shell.ok("rtls -l /localhost")
        kill(pids(shell))
        shell.ok("rtmgr start")
        assert shell.ok("rtls /localhost").split() == ["S.rtc", "T.rtc", "manager.mgr/"]
        assert "Inactive" in shell.ok("rtls -l /localhost/S.rtc")
        shell.ok("rtmgr stop")
