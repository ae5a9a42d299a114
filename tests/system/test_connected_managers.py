"""Connections between two managers of this host: made, broken by any death, met again, removed."""

from __future__ import annotations

import json
import os
import signal
from typing import Any

import pytest
from counting import CHECKER, COUNTER
from faultkit import Order, Points
from waiting import until

HERE, THERE = "/localhost/A.rtc", "/localhost/m1.mgr/B.rtc"


def kill(shell: Any, name: str) -> None:
    pid = json.loads(shell.ok(f"rtmgr status --json {name}"))["pid"]
    os.kill(pid, signal.SIGKILL)
    until(lambda: shell.run(f"rtmgr status {name}").status == 1, "the end of the manager")


def count(shell: Any) -> tuple[int, int]:
    """Return the last number that arrived and how many were missed."""
    file = shell.folder / "count"
    last, gaps = map(int, file.read_text().split()) if file.exists() else (0, 0)
    return last, gaps


def half(shell: Any, path: str) -> str | None:
    """Return why only half of the connection is there; "" if it is whole, None if it is not."""
    (facts,) = (json.loads(line) for line in shell.ok(f"rtcat --json {path}").splitlines())
    found = [each.get("trouble", "") for each in facts["connectors"]]
    return found[0] if found else None


def awaited(shell: Any, path: str, text: str | None) -> None:
    until(lambda: half(shell, path) == text, f"{text!r} at {path}, not {half(shell, path)!r}")


def flowing(shell: Any) -> None:
    last, _ = count(shell)
    until(lambda: count(shell)[0] > last + 5, "numbers")


@pytest.fixture
def joined(manager: Any) -> Any:
    """A slave of each of two managers, one of which counts what the other sends."""
    (manager.modules / "Counter.py").write_text(COUNTER)
    (manager.modules / "Checker.py").write_text(CHECKER)
    manager.ok("rtmgr start m1")
    create = "Counter?instance_name=A&manager_name=a"
    manager.ok(f"rtmgr /localhost/manager.mgr -c '{create}'")
    create = "Checker?instance_name=B&manager_name=b&rtkit.restart=on-failure"
    manager.ok(f"rtmgr /localhost/m1.mgr -c '{create}'")
    manager.ok(f"rtcon -i wire -p dataport.buffer.length=100000 {THERE}:into {HERE}:out")
    manager.ok(f"rtact {HERE}")
    manager.ok(f"rtact {THERE}")
    flowing(manager)
    return manager


def test_managers_die_in_any_order_no_value_is_lost_and_they_meet_again(joined: Any) -> None:
    shown = joined.ok(f"rtcat -l {HERE}:out")
    assert " +Connected to  /localhost/m1.mgr/B.rtc:into\n" in shown
    for dead in (["m1"], ["manager"], ["m1", "manager"], ["manager", "m1"]):
        for name in dead:
            kill(joined, name)
        if dead == ["m1"]:
            awaited(joined, HERE, "manager m1 is not running")
            assert "half: manager m1 is not running\n" in joined.ok(f"rtcat -l {HERE}:out")
            why = "half a connection at out: manager m1 is not running"
            assert why in joined.ok("rtls -l /localhost")
        if dead == ["manager"]:
            awaited(joined, THERE, "manager manager is not running")
        flowing(joined)
        for name in dead:
            joined.ok(f"rtmgr start {name}")
        awaited(joined, HERE, "")
        awaited(joined, THERE, "")
        flowing(joined)
    assert count(joined)[1] == 0


def test_a_component_that_its_policy_makes_again_is_joined_again(joined: Any) -> None:
    (slave,) = joined.ok("rtcat --json /localhost/m1.mgr/b.mgr").splitlines()
    os.kill(json.loads(slave)["pid"], signal.SIGKILL)
    awaited(joined, HERE, "")
    flowing(joined)


def test_either_end_disconnects_and_who_is_away_follows(joined: Any) -> None:
    joined.ok(f"rtdis {THERE}")
    assert half(joined, HERE) is None
    joined.ok(f"rtcon -i wire {HERE}:out {THERE}:into")
    kill(joined, "m1")
    told = joined.run(f"rtdis {HERE}:out {THERE}:into")
    assert told.status == 0
    assert "manager m1 is not running; the other half of connection wire is removed" in told.err
    joined.ok("rtmgr start m1")
    until(lambda: half(joined, THERE) is None, "the removal of the other half")


def test_a_component_that_is_ended_takes_the_other_half_along(joined: Any) -> None:
    kill(joined, "m1")
    ended = joined.run(f"rtexit {HERE}")
    note = "rtexit: note: other halves of its connections go when m1 is back\n"
    assert ended == (0, "", note)
    joined.ok("rtmgr start m1")
    until(lambda: half(joined, THERE) is None, "the removal of the other half")


def test_who_is_stopped_forgets_and_the_other_half_says_so(joined: Any) -> None:
    joined.ok("rtmgr stop m1")
    awaited(joined, HERE, "manager m1 is not running")
    joined.ok("rtmgr start m1")
    awaited(joined, HERE, "manager m1 has begun anew, and does not know it")
    joined.ok("rtmgr restart manager")
    awaited(joined, HERE, "manager m1 has begun anew, and does not know it")
    joined.ok(f"rtdis {HERE}")
    assert half(joined, HERE) is None


@pytest.mark.parametrize(
    "order",
    [
        Order("manager.asking_peer", 1),  # the coordinator, before it asks
        Order("manager.recording", 1),  # the peer, which has made its half
        Order("manager.recording", 2),  # the coordinator, when both ends are joined
        Order("holder.found_end", 1),  # the slave that joins
    ],
    ids=str,
)
def test_who_is_killed_in_the_making_leaves_all_nothing_or_why(shell: Any, order: Order) -> None:
    points = Points(shell.folder / "points")
    shell.environment.update(points.variable)
    for name, type_, instance in (("manager", "In", "A"), ("m1", "Out", "B")):
        shell.ok(f"rtmgr start --allow-faults {name}")
        create = f"Console{type_}?instance_name={instance}&manager_name=s"
        shell.ok(f"rtmgr /localhost/{name}.mgr -c '{create}'")
    points.arm(order)
    made = shell.run(f"rtcon -i wire {HERE}:out {THERE}:in")
    assert points.has_struck(1)
    points.disarm()
    assert made.status != 0
    for name in ("manager", "m1"):
        if shell.run(f"rtmgr status {name}").status != 0:
            shell.ok(f"rtmgr start --allow-faults {name}")

    def shown(path: str) -> str | None:
        found = shell.run(f"rtcat --json {path}")
        if found.status != 0:  # its slave was killed, and it is shown as dead
            return None
        (each,) = json.loads(found.out)["connectors"] or [{"trouble": None}]
        return each.get("trouble", "")

    def agree() -> bool:
        halves = [shown(f"{HERE}:out"), shown(f"{THERE}:in")]
        return halves in ([None, None], ["", ""])

    until(agree, "one of both managers is wrong")
