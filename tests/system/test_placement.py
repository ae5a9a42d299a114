"""Placement over hosts: where components go, why not, and where they stay."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from placekit import TYPES, free_profile
from shells import Shell
from waiting import until

pytestmark = [
    NEEDS_HOSTS,
    pytest.mark.timeout(240),  # rtkit is made on two bare hosts, on a busy machine
]


hosts = hosts_named("robot1", "robot2")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell whose manager is linked to two hosts; robot2 has the tag arm."""
    with linked(commands, hosts) as shell:
        shell.ok(f"rthost add --force robot2 root@{hosts[1].address} --tag arm")
        yield shell


@pytest.fixture
def shell(fleet: Shell) -> Iterator[Shell]:
    """The same; all components are ended afterwards."""
    yield fleet
    for host in ("localhost", "robot1", "robot2"):
        for name in TYPES:
            fleet.run(f"rtexit /{host}/{name}.rtc")


def homes(shell: Shell) -> dict[str, str]:
    """Return the host of each component."""
    found = {}
    for host in ("localhost", "robot1", "robot2"):
        for line in shell.ok(f"rtls /{host}").split():
            if line.endswith(".rtc"):
                found[line.removesuffix(".rtc")] = host
    return found


def test_components_go_where_their_requirements_are_met_and_stay(
    shell: Shell, hosts: list[FarHost]
) -> None:
    hosts[0].write("/tmp/camera", "")
    file = free_profile(
        shell.folder / "free.xml",
        In1={"device": "/tmp/cam*"},
        Out1={"tags": "arm"},
        Out2={"not_with": "Out1", "with": "In1"},
    )
    assert shell.run(f"rtapply {file}").status == 0
    assert homes(shell) == {"In1": "robot1", "Out1": "robot2", "Out2": "robot1"}
    assert shell.run(f"rtplan --detailed-exitcode {file}").status == 0
    shell.ok(f"rtcheck {file}")
    saved = shell.ok("rtcryo --all /robot1 /robot2")
    assert 'rtsExt:name="rtkit.place.tags" rtsExt:value="arm"' in saved
    # The camera is plugged in elsewhere, where Out2 may not be, which is to be with In1.
    hosts[0].run("rm", "/tmp/camera")
    hosts[1].write("/tmp/camera", "")
    until(lambda: "comes back with it" in shell.ok("rtls -l /robot1"), "the end of In1")
    assert shell.run(f"rtplan {file}").err == (
        "rtplan: no place for In1 and Out1 and Out2 together: Out2 is to be in the process of In1;"
        " Out2 is not to be on the host of Out1; localhost: no /tmp/cam* (In1), lacks tag arm"
        " (Out1); robot1: no /tmp/cam* (In1), lacks tag arm (Out1);"
        " In1 is a zombie on robot1 (no /tmp/cam*)\n"
    )
    hosts[1].run("rm", "/tmp/camera")
    (shell.folder / "here").write_text("")
    moved = file.replace("free.xml", "moved.xml")
    text = Path(file).read_text().replace("/tmp/cam*", str(shell.folder / "here"))
    Path(moved).write_text(text)
    # The manager there has ended In1 with its camera, and would make it again: it is not doubled.
    refused = shell.run(f"rtapply {moved}").err
    assert refused == (
        "rtapply: In1 is a zombie on robot1 (no /tmp/cam*);"
        " rtexit /robot1/In1.rtc or rtdel /robot1/In1.rtc ends it first\n"
    )
    shell.ok("rtexit /robot1/In1.rtc")
    assert shell.run(f"rtapply {moved}").status == 0
    assert homes(shell) == {"In1": "localhost", "Out1": "robot2", "Out2": "localhost"}
    assert "w1" in shell.ok("rtcat -ll /localhost/In1.rtc")
    assert shell.run(f"rtstop {moved}").status == 0
    assert shell.run(f"rtteardown --exit {moved}").status == 0
    assert homes(shell) == {}


def test_what_was_made_by_hand_moves_without_a_create_string(shell: Shell) -> None:
    file = Path(free_profile(shell.folder / "bare.xml", In1={"tags": "arm"}))
    file.write_text(file.read_text().replace("rtkit.create", "of.another"))
    shell.ok("rtmgr -c 'ConsoleIn?instance_name=In1' /robot1/manager.mgr")
    assert shell.run(f"rtapply {file}").status == 0
    assert homes(shell) == {"In1": "robot2"}
    assert shell.run(f"rtplan --detailed-exitcode {file}").status == 0
    shell.ok("rtexit /robot2/In1.rtc")


def test_what_waits_for_its_device_ends_with_its_system(shell: Shell, hosts: list[FarHost]) -> None:
    hosts[0].write("/tmp/lamp", "")
    file = free_profile(shell.folder / "lamp.xml", In1={"device": "/tmp/lamp"})
    assert shell.run(f"rtapply {file}").status == 0
    hosts[0].run("rm", "/tmp/lamp")
    until(lambda: "comes back with it" in shell.ok("rtls -l /robot1"), "the end of In1")
    why = "missing: /robot1/In1.rtc (zombie: no /tmp/lamp)"
    assert why in shell.run(f"rtcheck {file}").err
    assert "at path /robot1/In1.rtc" in shell.ok(f"rtteardown --dry-run --exit {file}")
    shell.ok(f"rtteardown --exit {file}")
    assert "In1" not in shell.ok("rtls -l /robot1")
    hosts[0].write("/tmp/lamp", "")
    assert shell.run(f"rtapply {file}").status == 0
    assert homes(shell) == {"In1": "robot1"}


def test_what_has_no_place_is_told_with_a_reason_for_each_host(
    shell: Shell, hosts: list[FarHost]
) -> None:
    file = free_profile(shell.folder / "none.xml", In1={"tags": "camera", "memory": "900T"})
    told = shell.run(f"rtapply --exit-detail {file}")
    assert told.status == 7
    assert told.err.startswith("rtapply: no place for In1: ")
    assert "localhost: " in told.err
    assert homes(shell) == {}
    file = free_profile(
        shell.folder / "device.xml",
        In1={"device": "video77", "hosts": "robot1,robot2"},
    )
    told = shell.run(f"rtplan {file}")
    assert told.err == (
        "rtplan: no place for In1: robot1: no /dev/video77; robot2: no /dev/video77\n"
    )


def test_an_optional_component_without_a_place_is_left_out(shell: Shell) -> None:
    file = free_profile(shell.folder / "some.xml", "Out1", In1={}, Out1={"tags": "wings"})
    done = shell.run(f"rtapply {file}")
    assert done.status == 0
    assert "no place for Out1: localhost: lacks tag wings" in done.err
    assert homes(shell) == {"In1": "localhost"}


def test_a_host_that_cannot_be_reached_is_not_taken_for_empty(
    shell: Shell, hosts: list[FarHost]
) -> None:
    file = free_profile(shell.folder / "cut.xml", In1={"hosts": "robot1"})
    assert shell.run(f"rtapply {file}").status == 0
    cut(shell, hosts[0])
    try:
        told = shell.run(f"rtplan {file}")
        assert told.status == 1
        assert "In1 may live on robot1: host robot1 cannot be reached: " in told.err
        assert "(rtmgr stop --host robot1 gives it up)" in told.err
    finally:
        linked_again(shell, hosts[0])
    assert homes(shell) == {"In1": "robot1"}
    assert shell.run(f"rtplan --detailed-exitcode {file}").status == 0
