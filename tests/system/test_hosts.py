"""Other hosts: known by names, reached over SSH, made ready, linked, and seen in one tree."""

from __future__ import annotations

import json
import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from farkit import FarHost, far_hosts
from fleetkit import NEEDS_HOSTS, accept_key, give_home, hosts_named, linked
from forked import Commands
from shells import Outcome, Shell
from waiting import has_ended, until

pytestmark = NEEDS_HOSTS


hosts = hosts_named("robot1", "robot2")


@pytest.fixture
def known(shell: Shell, hosts: list[FarHost]) -> Shell:
    """A shell that knows both hosts, and their keys."""
    give_home(shell, hosts)
    for host in hosts:
        shell.ok(f"rthost add {host.name} root@{host.address}")
        accept_key(shell, host.name)
    return shell


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell whose manager is linked to both hosts."""
    with linked(commands, hosts) as shell:
        yield shell


def test_a_host_whose_key_is_not_known_is_told_nothing(shell: Shell, hosts: list[FarHost]) -> None:
    give_home(shell, hosts)
    shell.ok(f"rthost add robot1 root@{hosts[0].address}")
    told = shell.run("rthost check robot1")
    assert told.status == 1
    assert "is not known: ssh-ed25519 SHA256:" in told.err
    assert shell.run("rthost accept robot1 SHA256:another").status == 1
    assert shell.run("rtmgr start --host robot1").status == 1
    shell.ok("rtmgr stop")


def test_a_changed_key_is_refused(known: Shell, hosts: list[FarHost]) -> None:
    file = known.folder / "home" / ".ssh" / "known_hosts"
    one = hosts[0]
    lines = file.read_text().splitlines()
    key = "AAAAC3NzaC1lZDI1NTE5AAAAIOIwvWTeRY1vm8bPqRtX5bYkYnZg7h7jCFzrD9H8Tz2W"
    file.write_text(f"{one.address} ssh-ed25519 {key}\n{lines[2]}\n")
    told = known.run("rthost check robot1")
    assert told.status == 1
    assert "its key has changed" in told.err
    assert known.run("rthost check robot2").status == 0
    shown = told.err.split("changed: ssh-ed25519 ")[1].split(",")[0]
    assert "its key has changed" in known.run(f"rthost accept robot1 {shown}").err


def test_check_tells_what_a_host_is_and_changes_nothing_there(
    known: Shell, hosts: list[FarHost]
) -> None:
    records = jsonrecords.checked(known.ok("rthost check --json"))
    assert {jsonrecords.kind_of(each) for each in records} == {"host-check"}
    assert [each["hostname"] for each in records] == ["robot1", "robot2"]
    assert all(abs(each["clock_offset_s"]) <= each["clock_bound_s"] + 1e-3 for each in records)
    assert all(each["round_trip_s"] < 0.03 for each in records)
    assert not [each["obstacles"] for each in records if each["obstacles"]]


def test_hosts_are_listed_as_they_stand_in_the_inventory(shell: Shell) -> None:
    give_home(shell, [])
    shell.ok("rthost add arm pi@arm.local:2222 --tag gpu --tag big")
    assert shell.run("rthost add arm other").status == 1
    shell.ok("rthost add arm pi@[fe80::1]:22 --force")
    assert shell.run("rthost add 'a/b' x").status == 1
    assert shell.run("rthost add localhost x").status == 1
    (shell.folder / "hosts.toml").write_text('[cart]\naddress = "10.0.0.9"\n')
    jsonrecords.checked(shell.ok("rthost list --json"))
    shown = shell.ok("rthost list")
    assert "pi@[fe80::1]:22" in shown
    assert "cart" in shown
    told = shell.run("rthost remove cart")
    assert "it stands in" in told.err
    shell.ok("rthost remove arm")
    (shell.folder / "hosts.toml").write_text('[cart]\nadress = "10.0.0.9"\n')
    assert "did you mean address" in shell.run("rthost list").err


def test_a_bare_host_is_made_ready_linked_and_used_from_here(fleet: Shell) -> None:
    assert {"robot1/", "robot2/"} <= {*fleet.ok("rtls /").split()}
    fleet.ok("rtmgr -c ConsoleIn -c ConsoleOut /robot1/manager.mgr")
    fleet.ok("rtcon /robot1/ConsoleIn0.rtc:out /robot1/ConsoleOut0.rtc:in")
    fleet.ok("rtact /robot1/ConsoleIn0.rtc /robot1/ConsoleOut0.rtc")
    assert "Active  1/1" in fleet.ok("rtls -l /robot1")
    assert fleet.ok("rtls /robot2").split() == ["manager.mgr/"]
    paths = [json.loads(line)["path"] for line in fleet.ok("rtls --json /robot1").splitlines()]
    assert "/robot1/ConsoleIn0.rtc" in paths
    assert "  robot1/ConsoleIn0.rtc  " in fleet.ok("rtmgr -r /robot1/manager.mgr")
    fleet.ok("rtmgr -d ConsoleIn0 -d ConsoleOut0 /robot1/manager.mgr")


def test_start_is_done_once_however_often_it_is_asked_for(fleet: Shell) -> None:
    told = fleet.run("rtmgr start --host robot1 -v")
    assert told.out == "robot1: linked, manager ran already\n"
    steps = ("connecting", "checking", "choosing wheels", "starting its manager", "linking")
    assert told.err.splitlines() == [f"robot1: {each}" for each in (*steps, "linked")]


def test_who_is_linked_commands_nobody_here(fleet: Shell, hosts: list[FarHost]) -> None:
    far = hosts[0]
    python = "/root/.local/share/rtkit/current/bin/python"
    near = os.uname().nodename
    script = (
        "import rtkit.tree.connect as c; t = c.connect();"
        f"t._service = t._service.replace('/robot1/', '/{near}/');"
        "t.timeout_s = 1.0; print(t.get('manager.pid'))"
    )
    asked = f'env RTKIT_HOSTNAME=robot1 {python} -c "{script}" 2>&1 | tail -n 1'
    assert "nobody answers" in far.run("sh", "-c", asked)


def test_a_cut_link_is_told_at_once_and_heals(fleet: Shell, hosts: list[FarHost]) -> None:
    def is_linked() -> bool:
        rows = [json.loads(line) for line in fleet.ok("rthost list --json").splitlines()]
        return bool(next(row for row in rows if row["name"] == "robot2")["is_linked"])

    hosts[1].link("down")
    until(lambda: not is_linked(), "the link is lost")
    told = fleet.run("rtls /robot2")
    assert told.status == 1
    assert "host robot2 cannot be reached" in told.err
    assert fleet.run("rtls -R /").status == 1
    fleet.ok("rtls /robot1")
    hosts[1].link("up")
    until(is_linked, "the link is there again")
    fleet.ok("rtls /robot2")


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("rtls /robot1/m2.mgr", "leads to its manager manager"),
    ],
)
def test_what_is_not_yet_possible_on_another_host_is_said(
    fleet: Shell, line: str, why: str
) -> None:
    told = fleet.run(line)
    assert told.status == 1
    assert why in told.err
    assert "robot1" in told.err


def test_logs_of_hosts_are_merged(fleet: Shell) -> None:
    for host in ("localhost", "robot1"):
        fleet.ok(f"rtmgr -c ConsoleIn /{host}/manager.mgr")
    shown = [json.loads(line) for line in fleet.ok("rtvlog --json --no-follow /").splitlines()]
    assert {"localhost", "robot1", "robot2"} <= {record["host"] for record in shown}
    assert [each["time"] for each in shown] == sorted(each["time"] for each in shown)
    assert fleet.ok("rtvlog --no-follow /robot1/manager.mgr")
    for host in ("localhost", "robot1"):
        fleet.ok(f"rtmgr -d ConsoleIn0 /{host}/manager.mgr")


def test_a_host_is_shown_as_a_whole_by_what_looks_on(fleet: Shell) -> None:
    fleet.ok("rtmgr -c ConsoleIn /robot1/manager.mgr")
    assert "1 component" in fleet.ok("rttop /robot1 -n 1")
    fleet.ok("rtmgr -d ConsoleIn0 /robot1/manager.mgr")


def _link(fleet: Shell, host: str) -> dict[str, Any]:
    return dict(json.loads(((fleet.folder / "run") / f"{host}.link").read_text()))


def test_a_link_whose_process_stands_still_says_so_and_heals(fleet: Shell) -> None:
    pid = _link(fleet, "robot1")["pid"]
    os.kill(pid, signal.SIGSTOP)
    try:
        told = fleet.run("rtls /robot1")
        assert "the process of the link was stopped by a signal" in told.err
        time.sleep(2.0)  # longer than the routers keep who is silent
    finally:
        os.kill(pid, signal.SIGCONT)
    until(lambda: fleet.run("rtls /robot1").status == 0, "the link is there again")


def test_a_link_ends_with_its_manager_and_comes_back_with_it(fleet: Shell) -> None:
    pid = _link(fleet, "robot1")["pid"]
    os.kill(int(fleet.ok("rtget /localhost/manager.mgr/pid")), signal.SIGKILL)
    until(lambda: has_ended(pid), "the link has ended")
    assert not [*(fleet.folder / "run").glob("*.link"), *(fleet.folder / "run").glob("*.tunnel")]
    fleet.ok("rtmgr start")
    until(lambda: fleet.run("rtls /robot1").status == 0, "the link is there again")
    until(lambda: fleet.run("rtls /robot2").status == 0, "the link is there again")


def test_a_host_is_linked_by_one_manager_here(fleet: Shell) -> None:
    fleet.ok("rtmgr start -a m2")
    told = as_manager(fleet, "m2", "rtmgr start --host robot1")
    hint = "RTKIT_MANAGER=manager rtmgr stop --host robot1 ends both"
    why = f"robot1: manager manager of this host has the link to it ({hint})"
    assert (told.status, told.err) == (1, f"rtmgr: {why}\n")

    # One that was away gives way to who has linked the host meanwhile.
    pid = _link(fleet, "robot1")["pid"]
    os.kill(int(fleet.ok("rtget /localhost/manager.mgr/pid")), signal.SIGKILL)
    until(lambda: has_ended(pid), "the link has ended")
    assert as_manager(fleet, "m2", "rtmgr start --host robot1").status == 0
    pid = _link(fleet, "robot1")["pid"]
    fleet.ok("rtmgr start")
    until(lambda: fleet.run("rtls /robot2").status == 0, "the other link is there again")
    assert fleet.ok("rtget /localhost/manager.mgr/get_hosts") == "robot2\n"
    link = _link(fleet, "robot1")
    assert (link["manager"], link["pid"]) == ("m2", pid)
    fleet.ok("rtls /robot1")

    assert as_manager(fleet, "m2", "rtmgr stop --host robot1").status == 0
    fleet.ok("rtmgr stop m2")
    fleet.ok("rtmgr start --host robot1")


def as_manager(fleet: Shell, manager: str, line: str) -> Outcome:
    """Run a command with another manager as the usual one."""
    fleet.environment["RTKIT_MANAGER"] = manager
    try:
        return fleet.run(line)
    finally:
        del fleet.environment["RTKIT_MANAGER"]


def test_stop_ends_manager_and_link(known: Shell, fleet: Shell, hosts: list[FarHost]) -> None:
    fleet.ok("rtmgr stop --host robot2")
    assert "robot2/" not in fleet.ok("rtls /").split()
    assert "Link" not in fleet.ok("rthost check robot2")
    assert "daemon" not in hosts[1].run("sh", "-c", "cat /proc/*/cmdline | tr '\\0' ' '")
    fleet.ok("rtmgr start --host robot2")
    assert re.search(r"Link +linked", fleet.ok("rthost check robot2"))


def test_what_a_host_lacks_is_told_before_anything_is_sent(known: Shell, tmp_path: Path) -> None:
    with far_hosts(tmp_path, "small") as (small,):
        known.ok(f"rthost add small root@{small.address}")
        key = known.folder / "home" / ".ssh" / "id_ed25519"
        key.write_bytes(small.key.read_bytes())
        accept_key(known, "small")
        small.run("mount", "-o", "remount,size=20m", "/root")
        told = known.run("rtmgr start --host small")
        assert told.status == 1
        assert "MiB are free in /root" in told.err
        assert ".local" not in small.run("ls", "-A", "/root")
    known.ok("rtmgr stop")
