"""A host is cut off: each command names it at once and goes on with the rest."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
import rts_text
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from shells import Shell
from waiting import until

pytestmark = NEEDS_HOSTS
TYPE = "RTC:rtkit:example:{}:1.0"
WHY = "host robot1 cannot be reached: "
FILE = "three.xml"


hosts = hosts_named("robot1", "robot2")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A system with states over three hosts, one of which is cut off."""
    with linked(commands, hosts) as shell:
        (shell.folder / FILE).write_text(profile())
        assert shell.run(f"rtapply {FILE}").status == 0
        cut(shell, hosts[0])
        yield shell
        linked_again(shell, hosts[0])


def profile() -> str:
    """Return a system of a source here, and a sink on each robot."""
    places = (("ConsoleIn", "In1", "out", "localhost"), ("ConsoleOut", "Out1", "in", "robot1"))
    components = [
        rts_text.component(
            name, {"create": kind}, type_id=TYPE.format(kind), port=port, folder=folder, rate=10.0
        )
        for kind, name, port, folder in (*places, ("ConsoleOut", "Out2", "in", "robot2"))
    ]
    types = [TYPE.format(each) for each in ("ConsoleIn", "ConsoleOut")]
    wires = [rts_text.wire(f"w{n}", "In1.out", f"Out{n}.in", types) for n in (1, 2)]
    states = {"states": "off, run", "state.off": "*=Inactive", "state.run": "*=Active"}
    return rts_text.with_properties(rts_text.system("Three", *components, *wires), states)


@pytest.mark.parametrize(
    ("line", "shown"),
    [
        ("rtls -R /", "Out2.rtc"),
        ("rtfind / -n Out*", "/robot2/Out2.rtc"),
        ("rtplan {}", "kept: 2 managers, 2 components, 1 connection"),
        ("rtplan --detailed-exitcode {}", "nothing to do: what can be reached is as wanted"),
        ("rtapply --dry-run {}", "nothing to do"),
        ("rtcheck --json {}", "unreachable: /robot1/Out1.rtc"),
        ("rtstate {}", "state not known"),
        ("rtstate -g off --dry-run {}", "deactivate Out2"),
        ("rtstop --dry-run {}", "Deactivate /robot2/Out2.rtc"),
        ("rtteardown --dry-run {}", "with ID w2"),
        ("rtwatch -n 1 -t 0.1 /", ""),
    ],
)
def test_a_lost_host_is_named_and_the_rest_goes_on(fleet: Shell, line: str, shown: str) -> None:
    told = fleet.run(line.format(FILE))
    assert told.status == 1
    assert WHY in told.err
    assert shown in told.out
    assert "robot2" not in told.err


def test_what_is_on_a_lost_host_is_no_other_deviation(fleet: Shell) -> None:
    lines = fleet.run(f"rtcheck --json {FILE}").out.splitlines()
    (found,) = map(json.loads, lines)
    assert (found["path"], found["required"]) == ("/robot1/Out1.rtc", True)


@pytest.mark.parametrize("line", ["rtstatus --json", "rtdoctor --json"])
def test_the_links_of_a_manager_are_looked_at(fleet: Shell, line: str) -> None:
    told = fleet.run(line)
    assert told.status == 1
    assert "robot1" in told.out
    assert json.loads(told.out.splitlines()[0])


def test_a_saved_system_tells_what_leads_elsewhere(fleet: Shell) -> None:
    told = fleet.run("rtcryo")
    assert told.status == 0
    assert sorted(told.err.splitlines()) == [
        f"rtcryo: not saved, its other end is below /robot{n}/manager.mgr: w{n}" for n in (1, 2)
    ]


@pytest.mark.parametrize("word", ["rtapply", "rtstart", "rtresurrect", "rtstate -g off"])
def test_what_would_be_done_by_half_is_refused(fleet: Shell, word: str) -> None:
    told = fleet.run(f"{word} {FILE}")
    assert (told.status, told.out) == (1, "")
    assert "robot1" in told.err
    assert "Active" in fleet.ok("rtcat /robot2/Out2.rtc")


def test_a_watcher_hears_the_other_hosts(fleet: Shell) -> None:
    watcher = fleet.open("rtwatch -n 2 /")
    assert watcher.stderr is not None
    assert WHY in watcher.stderr.readline()
    fleet.ok("rtdeact /robot2/Out2.rtc")
    fleet.ok("rtact /robot2/Out2.rtc")
    told = fleet.end_of(watcher)
    assert told.status == 1
    assert told.out.count("/robot2/Out2.rtc 0 ") == 2


def test_a_system_over_hosts_is_led_from_state_to_state(fleet: Shell, hosts: list[FarHost]) -> None:
    linked_again(fleet, hosts[0])
    assert "* run" in fleet.ok(f"rtstate {FILE}")
    assert fleet.run(f"rtstate -g off {FILE}").status == 0
    assert "* off" in fleet.ok(f"rtstate {FILE}")
    assert "Inactive" in fleet.ok("rtcat /robot1/Out1.rtc")


def test_for_a_host_that_was_rebooted_what_is_applied_is_planned(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    linked_again(fleet, hosts[0])
    hosts[0].run("sh", "-c", "kill -9 -1")
    start = "rtmgr start --host robot1"
    until(lambda: start in fleet.run("rtls /robot1").err, "the end of the manager is known")
    assert start in fleet.run("rtdoctor").out
    assert start in fleet.ok("rthost check robot1")
    told = fleet.run(f"rtplan {FILE}")
    assert (told.status, "left out" in told.err) == (0, False)
    assert "create Out1" in told.out
    assert fleet.run(f"rtapply {FILE}").status == 0
    assert "Active" in fleet.ok("rtcat /robot1/Out1.rtc")
