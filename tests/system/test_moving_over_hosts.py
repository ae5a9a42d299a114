"""A component moves to another host and back while values go through it; none is lost."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from counting import CHECKER, COUNTER, RELAY
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from shells import Shell
from waiting import until

pytestmark = NEEDS_HOSTS
HERE, THERE = "/localhost/Relay0.rtc", "/robot1/Relay0.rtc"
POLICY = (
    "-p dataport.subscription_type=flush -p dataport.buffer.write.full_policy=block"
    " -p dataport.buffer.write.timeout=5 -p dataport.buffer.length=1000"
)


hosts = hosts_named("robot1")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """Numbers go from a source through a relay to a receiver, all of them here."""
    with linked(commands, hosts) as shell:
        hosts[0].write("/root/Relay.py", RELAY)
        for kind, text in (("Counter", COUNTER), ("Relay", RELAY), ("Checker", CHECKER)):
            (shell.modules / f"{kind}.py").write_text(text)
            shell.ok(f"rtmgr -c {kind}?manager_name={kind.lower()} /localhost/manager.mgr")
        shell.ok(f"rtcon -i one {POLICY} /localhost/Counter0.rtc:out {HERE}:into")
        shell.ok(f"rtcon -i two {POLICY} {HERE}:out /localhost/Checker0.rtc:into")
        for kind in ("Checker", "Relay", "Counter"):
            shell.ok(f"rtact /localhost/{kind}0.rtc")
        yield shell


def numbers(fleet: Shell) -> tuple[int, int]:
    file = fleet.folder / "count"
    last, gaps = file.read_text().split() if file.exists() else ("0", "0")
    return int(last), int(gaps)


def flowing(fleet: Shell) -> None:
    before = numbers(fleet)[0]
    until(lambda: numbers(fleet)[0] > before + 20, "numbers")


def test_a_component_moves_between_hosts_and_no_value_is_lost(fleet: Shell) -> None:
    assert "create Relay0 on manager@robot1 in slave arm" in fleet.ok(
        f"rtmove -n {HERE} /robot1/manager.mgr/arm.mgr"
    )
    flowing(fleet)
    for path, target, other in (
        (HERE, "/robot1/manager.mgr/arm.mgr", THERE),
        (THERE, "/robot1/manager.mgr", THERE),
        (THERE, "/localhost/manager.mgr/relay.mgr", HERE),
    ):
        told = fleet.run(f"rtmove {path} {target}")
        assert told.status == 0, told.err
        assert fleet.ok("rtfind -un Relay0.rtc /") == f"{other}\n"
        flowing(fleet)
    assert numbers(fleet)[1] == 0


def test_a_host_that_is_not_there_is_named_and_nothing_moves(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    assert fleet.run(f"rtmove {HERE} /robot9/manager.mgr").err == (
        "rtmove: /robot9/manager.mgr: no such host: robot9 (did you mean robot1?)\n"
    )
    cut(fleet, hosts[0])
    told = fleet.run(f"rtmove {HERE} /robot1/manager.mgr")
    assert told.status == 1
    assert "host robot1 cannot be reached: " in told.err
    flowing(fleet)
    linked_again(fleet, hosts[0])
    told = fleet.run("rtmove /localhost/Counter0.rtc /robot1/manager.mgr")
    assert told.status == 1  # its module is only here
    assert "impossible: Counter0" in told.err
    flowing(fleet)
    assert numbers(fleet)[1] == 0
