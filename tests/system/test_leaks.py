"""Components come and go for a long time; nothing of them stays in the manager, or in a slave."""

from __future__ import annotations

from typing import Any

import pytest
from leakkit import grown, held

from rtkit.deployment.actions import ActivateSet, ChangeState, Connect, Create, Delete, Disconnect
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect


def lives(number: int) -> list[Any]:
    """Return what makes a component beside others, one by itself, and ends both again."""
    stays, comes, goes = "Stays", f"Comes{number}", f"Goes{number}"
    wires = [
        ConnectorProfile(f"{number}a", "a", (PortRef(comes, "out"), PortRef(stays, "in"))),
        ConnectorProfile(f"{number}b", "b", (PortRef(goes, "out"), PortRef(stays, "in"))),
    ]
    return [
        Create(f"ConsoleIn?instance_name={comes}&manager_name=s"),
        Create(f"ConsoleIn?instance_name={goes}&manager_name=t{number}"),
        *map(Connect, wires),
        *(ChangeState(each, "0", Transition.ACTIVATE) for each in (stays, comes, goes)),
        ActivateSet(comes, "default"),
        Disconnect(f"{number}a"),
        *(ChangeState(each, "0", Transition.DEACTIVATE) for each in (stays, goes)),
        *map(Delete, (goes, comes)),
    ]


def come_and_go(tree: Tree, times: int) -> None:
    """Do that, and compare what manager and slave hold after the first and the last time."""
    for result in tree.apply([Create("ConsoleOut?instance_name=Stays&manager_name=s")]):
        result.raise_for_error()
    pids = {process.name: process.pid for process in tree.snapshot().processes}
    before = {}
    for number in range(times + 1):
        for result in tree.apply(lives(number), timeout_s=60.0):
            result.raise_for_error()
        if not number:
            before = {name: held(pid) for name, pid in pids.items()}
    more = {name: grown(pid, before[name]) for name, pid in pids.items()}
    assert not any(more.values()), more


def test_components_that_come_and_go_leave_nothing(tree: Tree) -> None:
    come_and_go(tree, 12)


@pytest.mark.campaign
@pytest.mark.timeout(900)
def test_components_that_come_and_go_two_hundred_times(tree: Tree) -> None:
    come_and_go(tree, 200)


def test_clients_that_come_and_go_leave_nothing(manager: Any, tree: Tree) -> None:
    pid = tree.listing().pid
    ask_and_leave(manager)
    before = held(pid)
    for _ in range(10):
        ask_and_leave(manager)
    assert not grown(pid, before)


def ask_and_leave(manager: Any) -> None:
    """Ask, be refused, and hang up."""
    with connect() as tree:
        (refused,) = tree.apply([Create("NoSuchThing")])
        assert not refused.ok
