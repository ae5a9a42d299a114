"""Plans carried out at a manager that is reached over mutual TLS; their lock."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator

import pytest
from forked import Commands
from robotkit import Robot, opened_robot
from waiting import until

from rtkit.property.messages import DONE

LEASE = "%40x%2Flease"


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    with opened_robot(commands) as robot:
        with robot.usual():
            assert robot.by("owner1", "rtcryo --all -o saved.xml") == (0, "", "")
        yield robot


def _holder(id: str, command: str = "rtapply") -> str:
    who = {"id": id, "command": command, "user": "root", "host": "laptop", "pid": os.getpid()}
    return json.dumps({"take": {**who, "since": 0.0}})


def _has_lock(robot: Robot) -> str:
    with robot.connected("anna") as client:
        return str(client.ask(LEASE).value())


def test_a_plan_is_made_and_carried_out(robot: Robot) -> None:
    assert robot.by("owner1", "rtmgr -d ConsoleOut0 AT/manager.mgr").err == ""
    with robot.usual():
        plan = robot.by("owner1", "rtplan saved.xml")
        assert "create ConsoleOut0" in plan.out
        for who, why in (
            ("anna", "anna (viewer) may not take the lock of plans: it takes operator"),
            ("bert", "bert (operator) may not look for modules: it takes administrator"),
        ):
            done = robot.by(who, "rtapply saved.xml")
            assert done.status == 1
            assert f"denied: {why}" in done.err
            assert "in use" not in done.err
        done = robot.by("owner1", "rtapply saved.xml")
        assert done.status == 0, done.err
        assert robot.by("anna", "rtcheck saved.xml").status == 0
        done = robot.by("owner1", "rtteardown --exit saved.xml")
        assert done.status == 0, done.err
        assert robot.by("owner1", "rtresurrect saved.xml").status == 0
    assert _has_lock(robot) == ""


def test_a_lock_ends_with_the_connection_of_its_holder(robot: Robot) -> None:
    with robot.connected("bert") as mine:
        assert mine.ask(LEASE, _holder("one", "rtapply\x1b[31m")) == DONE._replace(payload="")
        shown = json.loads(_has_lock(robot))
        assert (shown["user"], shown["host"]) == ("bert at 127.0.0.1", "robot1")
        assert shown["command"] == "rtapply?[31m"
        assert shown["pid"] != os.getpid()
        with robot.connected("bert") as other:
            assert "bert at 127.0.0.1" in str(other.ask(LEASE, _holder("two")).payload)
            done = other.ask(LEASE, json.dumps({"give": "one"}))
            assert (done.payload, done.error) == ("no such lock of this client", "refused")
            assert _has_lock(robot)
        with robot.usual():
            done = robot.by("owner1", "rtapply saved.xml")
        assert (done.status, done.out) == (1, "")
        assert "is in use by rtapply?[31m (bert at 127.0.0.1" in done.err
    until(lambda: _has_lock(robot) == "", "the lock ends with the connection")


def test_a_lock_is_of_no_other_holder_by_any_spelling(robot: Robot) -> None:
    """A holder that the client names itself would have it for ever."""
    forged = _holder("x")
    for target in (f"{LEASE}%3Fid%3Dab-1", f"{LEASE}?id=ab-1", "%40x%2flease%3fid%3d1"):
        with robot.connected("bert") as client:
            taken = client.ask(target, forged)
            lock = client.ask(LEASE).payload
            assert taken.error or "bert at " in str(lock), target
        until(lambda: _has_lock(robot) == "", "it ends with the connection")


def test_locks_of_one_client_are_few(robot: Robot) -> None:
    with robot.connected("bert") as client:
        assert client.ask(LEASE, _holder("x" * 1000)).error == "refused"
        for text in ("[]", '{"take": 1}', "{" * 9000, '{"take": {"id": "a"}}'):
            assert client.ask(LEASE, text).error == "malformed"
        assert client.ask(LEASE, _holder("one")).error == ""
        assert client.ask(LEASE, json.dumps({"give": "one"})).error == ""
        assert _has_lock(robot) == ""


def test_a_command_that_is_killed_leaves_no_lock(robot: Robot) -> None:
    begin = (
        "import signal; from rtkit.tree.plan_locks import PlanLocks; "
        "from rtkit.tree.connect import connect; "
        "locks = PlanLocks('mine', 0, print); locks.take(connect()); "
        "print('taken', flush=True); signal.pause(); "
    )
    with robot.usual(), robot.keys_of("bert"):
        process = robot.shell.open("rtls", begin)
    assert process.stdout is not None
    assert process.stdout.readline() == "taken\n"
    assert json.loads(_has_lock(robot))["command"] == "mine"
    process.kill()
    until(lambda: _has_lock(robot) == "", "the lock ends with the process of its holder")
