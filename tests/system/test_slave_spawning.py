"""Slaves that do not come into the world, and zygotes that do not live."""

from __future__ import annotations

import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from faultkit import Order, Site
from waiting import until

from rtkit.deployment.actions import Create, Result
from rtkit.tree.client import Tree

BOUND_S = 30.0
DYING = """
import os
import sys

if "rtkit.manager.slaves.zygote" in sys.orig_argv and os.path.exists({flag!r}):
    os._exit(7)
"""


def create(tree: Tree, slave: str, timeout_s: float = BOUND_S) -> Result:
    (result,) = tree.apply([Create(f"ConsoleIn?manager_name={slave}")], timeout_s=timeout_s)
    return result


def forked_by(parent: int) -> list[int]:
    """Return the processes that a process has forked, also those that are stopped."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                state, of, *_ = (entry / "stat").read_text().rpartition(")")[2].split()
            except (FileNotFoundError, ProcessLookupError):
                continue
            if int(of) == parent and state != "Z":
                found.append(int(entry.name))
    return found


def zygote_of(tree: Tree) -> int:
    """Return the pid of the process that forks slaves."""
    slaves = {process.pid for process in tree.snapshot().processes}
    (pid,) = set(forked_by(tree.listing().pid)) - slaves
    return pid


@pytest.fixture
def site(shell: Any) -> Site:
    site = Site(shell)
    site.start()
    return site


def test_a_slave_that_ends_or_hangs_before_its_hello(site: Site) -> None:
    stopped = "slave {} was stopped before it was ready, and is ended"
    late = "slave {} did not start in time"
    expected = {
        "kill": "slave {} ended: signal 9",
        "raise EIO": r"slave {} ended: exit status 1; its last words: .*Input/output error",
        "stop": stopped,
        "delay 1000": late,
    }
    with site.tree() as tree:
        until(lambda: create(tree, "first").ok, "a zygote that is ready")
        zygote = zygote_of(tree)
        before = forked_by(zygote)
        for point in ("slave.begun", "slave.greeting"):
            for number, (how, why) in enumerate(expected.items()):
                action, _, argument = how.partition(" ")
                site.points.arm(Order(point, 1, action, argument))
                name = f"s{number}"
                result = create(tree, name, 0.5 if why is late else BOUND_S)
                assert re.fullmatch(why.format(name), result.why), (point, how)
                until(lambda: forked_by(zygote) == before, f"the end of {how} at {point}")
        site.points.disarm()
        until(lambda: [each[0] for each in tree.listing().slaves] == ["first"], "the listing")
        assert create(tree, "s0").ok


@pytest.mark.parametrize("point", ["zygote.forked", "zygote.told"])
def test_who_is_not_born_when_its_zygote_dies_ends_with_it(site: Site, point: str) -> None:
    with site.tree() as tree:
        until(lambda: create(tree, "first").ok, "a zygote that is ready")
        site.points.arm(Order(point, 1), Order("slave.begun", 1, "delay", "1000"))
        result = create(tree, "s")
        assert re.search(r"the zygote ended: signal 9|slave s ended: signal 9", result.why), result
        first, manager = tree.listing().slaves[0][0], tree.listing().pid
        site.points.disarm()
        assert create(tree, "t").ok
        named = {process.pid for process in tree.snapshot().processes}
        until(lambda: len(set(forked_by(manager)) - named) == 1, "nobody but the zygote")
        assert first == "first"


def test_a_zygote_that_dies_at_each_start_is_started_less_and_less_often(shell: Any) -> None:
    flag = shell.folder / "dying"
    (shell.folder / "usercustomize").mkdir()
    (shell.folder / "usercustomize" / "sitecustomize.py").write_text(DYING.format(flag=str(flag)))
    path = shell.environment["PYTHONPATH"]
    shell.environment["PYTHONPATH"] = f"{shell.folder}/usercustomize:{path}"
    flag.touch()
    shell.ok("rtmgr start")
    trouble = r"no slave can be started: the zygote ended: exit status 7, \d+ times in succession"
    until(lambda: re.search(trouble, shell.run("rtls -l /localhost").out), "a remark")
    assert re.search(trouble, shell.ok("rtcat /localhost/manager.mgr"))
    line = "rtmgr /localhost/manager.mgr -c 'ConsoleIn?manager_name=s'"
    status, _, err = shell.run(line)
    assert status == 1
    assert re.search(rf"{trouble}; started again at [\d:]+", err), err
    starts = shell.log().count("the zygote ended: exit status 7")
    assert 2 <= starts < 12, starts
    flag.unlink()
    until(lambda: shell.run(line).status == 0, "a slave")
    assert "no slave can be started" not in shell.ok("rtls -l /localhost")


def test_a_fork_that_hangs_when_manager_and_zygote_die_is_ended_by_the_next(site: Site) -> None:
    with site.tree() as tree:
        until(lambda: create(tree, "first").ok, "a zygote that is ready")
        zygote, manager = zygote_of(tree), tree.listing().pid
        known = set(forked_by(zygote))
        site.points.arm(Order("slave.begun", 1, "delay", "1000"))
        with site.shell.open("rtmgr /localhost/manager.mgr -c 'ConsoleIn?manager_name=s'") as made:
            assert site.points.has_struck(1)
            (lost,) = set(forked_by(zygote)) - known
            for pid in (manager, zygote):
                os.kill(pid, signal.SIGKILL)
            assert made.wait(timeout=BOUND_S) == 1
    site.points.disarm()
    assert os.path.exists(f"/proc/{lost}")
    site.start()
    until(lambda: not os.path.exists(f"/proc/{lost}"), "its end")
    assert f"said nothing was ended: pid {lost}" in site.shell.log()
    with site.tree() as tree:
        assert [each[0] for each in tree.listing().slaves] == ["first"]
