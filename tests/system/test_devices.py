"""Devices as facts: components end with them, wait, and are back with all they had."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from placekit import free_profile
from shells import Shell
from waiting import facts_of, until

from rtkit.deployment.facts import ComponentFacts
from rtkit.tree.client import Tree
from rtkit.tree.subscription import ManagerSubscription, TreeChange


@pytest.fixture
def device(manager: Shell) -> Path:
    """The device of In1, a terminal, behind a link in a folder of its own."""
    folder = manager.folder / "dev"
    folder.mkdir()
    plugged(folder / "cam0")
    return folder / "cam0"


def plugged(device: Path) -> None:
    """Have a device appear as udev does: a link to its node."""
    device.symlink_to("/dev/ptmx")


def system(shell: Shell) -> str:
    """Bring up a source that requires a device, and a sink; return the profile."""
    file = free_profile(
        shell.folder / "cam.xml", In1={"device": f"{shell.folder}/dev/cam*"}, Out1={}
    )
    path = Path(file)
    text = path.read_text().replace('"ConsoleIn"', '"ConsoleIn?manager_name=eyes"')
    path.write_text(text.replace('"ConsoleOut"', '"ConsoleOut?manager_name=mouth"'))
    assert shell.run(f"rtapply {file}").status == 0
    return file


def is_whole(tree: Tree) -> bool:
    told = tree.snapshot()
    states = {each.instance: each.state for each in told.components}
    return states == {"In1": "Active", "Out1": "Active"} and len(told.connectors) == 1


def living(tree: Tree) -> set[str]:
    return {each.name for each in tree.snapshot().processes if each.state == "up"}


def waits(tree: Tree) -> ComponentFacts | None:
    told = facts_of(tree, "In1")
    return told if told.zombie else None


def test_a_component_ends_with_its_device_and_is_back_with_it(
    manager: Shell, tree: Tree, device: Path
) -> None:
    file = system(manager)
    with ManagerSubscription(tree) as events:
        device.unlink()
        why = f"no {device.parent}/cam*"
        assert until(lambda: waits(tree), "the end of In1").zombie == why
        assert f"{why}, comes back with it" in manager.ok("rtls -l /localhost")
        until(lambda: "eyes" not in living(tree), "the end of its slave")
        told = manager.run(f"rtcheck {file}")
        assert told.status == 1
        plugged(device)
        until(lambda: is_whole(tree), "all to be back")
        found: list[str] = []
        while "DEVICE_APPEARED" not in found:
            changes = [each for each in events.wait() if isinstance(each, TreeChange)]
            found += [each.event for change in changes for each in change.user_events]
    assert "DEVICE_GONE" in found
    assert facts_of(tree, "In1").restart_status.why == why
    assert manager.run(f"rtplan --detailed-exitcode {file}").status == 0


def test_the_next_manager_waits_for_it_too(manager: Shell, tree: Tree, device: Path) -> None:
    system(manager)
    device.unlink()
    until(lambda: waits(tree), "the end of In1")
    os.kill(int(manager.ok("rtget /localhost/manager.mgr/pid")), signal.SIGKILL)
    until(lambda: manager.run("rtmgr status").status == 1, "the end of the manager")
    manager.ok("rtmgr start")
    assert f"no {device.parent}/cam*" in manager.ok("rtls -l /localhost")
    plugged(device)
    manager.ok("rtwait --timeout 20 /localhost/In1.rtc Active")


def test_another_device_under_its_name_is_another_one(
    manager: Shell, tree: Tree, device: Path
) -> None:
    system(manager)
    other = device.with_name("new")
    other.symlink_to("/dev/null")
    other.rename(device)
    until(lambda: facts_of(tree, "In1").restart_status.restarts == 1, "In1 to be made again")
    until(lambda: is_whole(tree), "all to be back")


def test_a_component_of_which_the_user_wants_no_more_does_not_come_back(
    manager: Shell, tree: Tree, device: Path
) -> None:
    system(manager)
    device.unlink()
    until(lambda: waits(tree), "the end of In1")
    manager.ok("rtexit /localhost/In1.rtc")
    plugged(device)
    assert tree.snapshot().component("In1") is None
