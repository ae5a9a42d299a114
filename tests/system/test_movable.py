"""Movable components: made elsewhere when their host is lost; there is one of each at the end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Iterator

import pytest
import rts_text
from counting import CHECKER as PLAIN_CHECKER
from counting import COUNTER
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from shells import Shell, processes_of
from waiting import until

pytestmark = NEEDS_HOSTS
FILE = "mov.xml"
OLD = 1_000_000
"""The number at which those begin to count that are made on robot1."""
CHECKER = PLAIN_CHECKER.replace(
    "self.last not in (0, value.data - 1)", f"self.last < {OLD} < value.data"
)
"""Counts, as gaps, how often an old number came after a new one."""
HERE, THERE = "/localhost/Num.rtc", "/robot1/Num.rtc"


hosts = hosts_named("robot1", "robot2")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    with linked(commands, hosts) as shell:
        give_modules(shell, hosts)
        (shell.folder / FILE).write_text(profile())
        yield shell
        linked_again(shell, *hosts)
        shell.run(f"rtteardown --exit {FILE}")


@pytest.fixture
def applied(fleet: Shell, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell whose system is as its profile says, and numbers of robot1 come here and there."""
    linked_again(fleet, *hosts)
    (fleet.folder / "count").unlink(missing_ok=True)
    hosts[1].run("rm", "-f", "/root/count")
    assert fleet.run(f"rtapply {FILE}").status == 0
    until(lambda: min(numbers(fleet, hosts)) > OLD, "numbers of robot1 come to both")
    yield fleet
    linked_again(fleet, *hosts)
    for other in {*fleet.folder.glob("*.xml")} - {fleet.folder / FILE}:
        fleet.run(f"rtteardown --exit {other.name}")  # what a test that failed has left
        other.unlink()


def give_modules(shell: Shell, hosts: list[FarHost]) -> None:
    (shell.modules / "Counter.py").write_text(COUNTER)
    (shell.modules / "Checker.py").write_text(CHECKER)
    for host in hosts:
        host.write("/root/Counter.py", COUNTER.replace("number = 0", f"number = {OLD}"))
        host.write("/root/Checker.py", CHECKER)


def profile(**policy: str) -> str:
    """Return a system whose source is movable, with a receiver here and one on robot2."""
    rows = (
        ("Counter", "Num", "out", "robot1", {"movable": "0.5", **policy}),
        ("Checker", "Near", "into", "localhost", {}),
        ("Checker", "Far", "into", "robot2", {}),
    )
    components = [
        rts_text.component(
            name,
            {"create": f"{kind}?manager_name={name.lower()}", **more},
            type_id=f"RTC:::{kind}:",
            port=port,
            folder=folder,
            rate=100.0,
        )
        for kind, name, port, folder, more in rows
    ]
    types = ["RTC:::Counter:", "RTC:::Checker:"]
    wires = [
        rts_text.wire(name.lower(), "Num.out", f"{name}.into", types) for name in ("Near", "Far")
    ]
    return rts_text.system("Moving", *components, *wires)


def numbers(fleet: Shell, hosts: list[FarHost]) -> list[int]:
    """Return the last numbers that came here and to robot2."""
    return [last for last, _ in counts(fleet, hosts)]


def counts(fleet: Shell, hosts: list[FarHost]) -> list[tuple[int, int]]:
    """Return the last numbers, and the gaps before them, here and on robot2."""
    try:
        texts = [(fleet.folder / "count").read_text(), hosts[1].read("/root/count")]
    except FileNotFoundError:
        return [(0, 0), (0, 0)]
    return [(int(last), int(gaps)) for last, gaps in map(str.split, texts)]


def places(fleet: Shell) -> list[str]:
    """Return where the movable component is."""
    return fleet.run("rtfind -un Num.rtc /").out.splitlines()


def moved(fleet: Shell, hosts: list[FarHost]) -> None:
    """Wait until there is one source, here, and its numbers come to both."""
    until(lambda: places(fleet) == [HERE], "there is one, here")
    until(lambda: all(0 < each < OLD for each in numbers(fleet, hosts)), "numbers of here come")


def ended_on_robot1(fleet: Shell) -> None:
    until(lambda: is_settled(fleet), "the owner has nothing left to do")
    assert "Num.rtc" not in fleet.ok("rtls /robot1")


def is_settled(fleet: Shell) -> bool:
    """Return whether no older one is left, and a plan led to where the components are."""
    (file,) = (fleet.folder / "state" / "owned").glob("[!.]*")  # not a draft of it
    owned = json.loads(file.read_text())
    return not owned.get("is_pending") and not owned["components"]["Num"].get("stale")


def trouble(fleet: Shell) -> str:
    (row,) = json.loads(fleet.run("rtstatus --json").out)["movable"]
    return str(row["why"])


def test_a_component_is_made_elsewhere_and_the_old_one_is_refused(
    applied: Shell, hosts: list[FarHost]
) -> None:
    cut(applied, hosts[0])
    moved(applied, hosts)
    assert trouble(applied) == "an older one may live in manager@robot1"
    assert "Num.rtc" in far(hosts[0], "rtls", "/localhost")  # both live
    log = hosts[0].run("sh", "-c", "cat /root/.local/state/rtkit/manager.log")
    assert "it owns Num: nothing is moved until it is back" in log
    before = counts(applied, hosts)

    linked_again(applied, hosts[0])
    ended_on_robot1(applied)
    assert places(applied) == [HERE]
    until(
        lambda: all(
            now > last + 50 for now, (last, _) in zip(numbers(applied, hosts), before, strict=True)
        ),
        "more numbers come",
    )
    assert [gaps for _, gaps in counts(applied, hosts)] == [gaps for _, gaps in before]


def test_a_second_one_of_the_name_is_refused(applied: Shell) -> None:
    told = applied.run("rtmgr -c Counter?instance_name=Num /robot2/manager.mgr")
    assert (told.status, "Num cannot be made here" in told.err) == (1, True)
    applied.ok("rtmgr -c Counter?instance_name=Other /robot2/manager.mgr")
    applied.ok("rtexit /robot2/Other.rtc")


def far(host: FarHost, *words: str) -> str:
    """Run a command at a host's own console."""
    name, *rest = words
    command = f"/root/.local/share/rtkit/current/bin/{name}"
    return host.run("env", f"RTKIT_HOSTNAME={host.name}", command, *rest)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_hosts_come_back_in_any_order(
    applied: Shell, hosts: list[FarHost], order: tuple[int, int]
) -> None:
    cut(applied, *hosts)
    until(lambda: HERE in places(applied), "it is made here")
    for number in order:
        linked_again(applied, hosts[number])
    ended_on_robot1(applied)
    moved(applied, hosts)


def test_a_stopped_system_stays_so_and_a_killed_owner_goes_on(
    applied: Shell, hosts: list[FarHost]
) -> None:
    assert applied.run(f"rtstop {FILE}").status == 0
    pids = subprocess.run(
        ["pgrep", "-f", "rtkit.api.owner_process"], capture_output=True, text=True, check=True
    )
    (own,) = {*map(int, pids.stdout.split())} & {*processes_of(applied.run_id)}
    os.kill(own, signal.SIGKILL)
    cut(applied, hosts[0])
    until(lambda: HERE in places(applied), "it is made here")
    assert "Inactive" in applied.ok(f"rtcat {HERE}")
    linked_again(applied, hosts[0])
    ended_on_robot1(applied)


def test_what_cannot_be_made_elsewhere_is_where_it_was(
    applied: Shell, hosts: list[FarHost]
) -> None:
    (applied.folder / "only.xml").write_text(profile().replace("Counter", "Only"))
    hosts[0].write("/root/Only.py", COUNTER.replace("Counter", "Only"))
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    assert applied.run("rtapply only.xml").status == 0
    cut(applied, hosts[0])
    until(lambda: trouble(applied).startswith("no place for Num: localhost: "), "it is told why")
    linked_again(applied, hosts[0])
    until(lambda: is_settled(applied), "the owner has nothing left to do")
    assert places(applied) == [THERE]
    applied.ok("rtcheck only.xml")
    assert applied.run("rtteardown --exit only.xml").status == 0


def test_only_a_host_that_meets_the_requirements_is_taken(
    applied: Shell, hosts: list[FarHost]
) -> None:
    for host in hosts:
        applied.ok(f"rthost add --force {host.name} root@{host.address} --tag arm")
    file = applied.folder / "arm.xml"
    file.write_text(profile(**{"movable": "0", "place.tags": "arm"}))
    assert applied.run("rtapply arm.xml").status == 0
    cut(applied, hosts[0])
    why = "no place for Num: localhost: lacks tag arm"
    until(lambda: why in trouble(applied), "it is told why it stays")
    assert places(applied) == []
    linked_again(applied, hosts[0])
    until(lambda: not trouble(applied), "it is where it was")
    assert places(applied) == [THERE]

    file.write_text(profile(**{"movable": "0 localhost robot2", "place.tags": "arm"}))
    assert applied.run("rtapply arm.xml").status == 0
    cut(applied, hosts[0])
    until(lambda: places(applied) == ["/robot2/Num.rtc"], "it is on the host with the tag")
    linked_again(applied, hosts[0])
    ended_on_robot1(applied)


def test_others_whose_host_is_open_stay_where_they_live(
    applied: Shell, hosts: list[FarHost]
) -> None:
    for host in hosts:
        applied.ok(f"rthost add --force {host.name} root@{host.address} --tag {host.name}")
    text = profile(**{"movable": "0", "place.not_with": "Far"})
    text = text.replace("robot2/Far.rtc", "*/Far.rtc")
    marks = ['rtkit.create" rtsExt:value="Checker?manager_name=far"/>', "rtkit.place.tags"]
    (applied.folder / "open.xml").write_text(
        text.replace(
            marks[0],
            f'{marks[0]}<rtsExt:Properties rtsExt:name="{marks[1]}" rtsExt:value="robot2"/>',
        )
    )
    assert applied.run("rtapply open.xml").status == 0
    cut(applied, hosts[0])
    moved(applied, hosts)
    linked_again(applied, hosts[0])
    ended_on_robot1(applied)


def test_while_the_owner_is_away_nothing_moves(applied: Shell, hosts: list[FarHost]) -> None:
    pid = int(applied.ok("rtget /localhost/manager.mgr/pid"))
    hosts[0].link("down")
    os.kill(pid, signal.SIGKILL)
    until(lambda: applied.run("rtmgr status").status == 1, "the end of the manager")
    assert "Num.rtc" not in far(hosts[1], "rtls", "/localhost")
    applied.ok("rtmgr start")
    until(lambda: HERE in places(applied), "the owner is back, and moves it")
    linked_again(applied, *hosts)
    ended_on_robot1(applied)
    moved(applied, hosts)


def test_a_component_moves_by_request_with_its_epoch(applied: Shell, hosts: list[FarHost]) -> None:
    assert applied.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    assert places(applied) == ["/robot2/Num.rtc"]
    cut(applied, hosts[1])
    until(lambda: HERE in places(applied), "it is made here")
    linked_again(applied, hosts[1])
    until(lambda: places(applied) == [HERE], "there is one again")
    moved(applied, hosts)


@pytest.mark.timeout(180)  # what it is provisioned with takes most of it
def test_a_host_that_was_powered_off_comes_back_bare(applied: Shell, hosts: list[FarHost]) -> None:
    hosts[0].power_off()
    moved(applied, hosts)
    hosts[0].power_on()
    give_modules(applied, hosts[:1])
    assert applied.run("rtmgr start --host robot1").status == 0
    ended_on_robot1(applied)
    assert places(applied) == [HERE]
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    assert applied.ok("rtget /localhost/manager.mgr/get_fences").strip() == ""


def test_applying_leads_it_back_and_there_is_one(applied: Shell, hosts: list[FarHost]) -> None:
    cut(applied, hosts[0])
    moved(applied, hosts)
    linked_again(applied, hosts[0])
    ended_on_robot1(applied)
    assert "delete Num" in applied.run(f"rtplan {FILE}").out
    assert applied.run(f"rtapply {FILE}").status == 0
    assert places(applied) == [THERE]
    until(lambda: min(numbers(applied, hosts)) > OLD, "numbers of robot1 come to both")
    assert applied.run(f"rtplan {FILE}").out.startswith("nothing to do")


def test_a_teardown_ends_what_was_moved_and_the_ownership(
    applied: Shell, hosts: list[FarHost]
) -> None:
    assert applied.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    told = applied.run(f"rtteardown --exit {FILE}")
    assert (told.status, told.err) == (0, "")
    assert places(applied) == []
    for place in ("/localhost", "/robot1", "/robot2"):
        assert applied.ok(f"rtget {place}/manager.mgr/get_fences").strip() == ""
    (applied.folder / "fixed.xml").write_text(profile().replace("rtkit.movable", "rtkit.x"))
    assert applied.run("rtapply fixed.xml").status == 0
    assert places(applied) == [THERE]
    assert applied.run("rtteardown --exit fixed.xml").status == 0


@pytest.fixture
def fixed(applied: Shell) -> Iterator[Shell]:
    """The same system, of which nothing is movable; it is ended afterwards."""
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    (applied.folder / "fixed.xml").write_text(profile().replace("rtkit.movable", "rtkit.x"))
    assert applied.run("rtapply fixed.xml").status == 0
    yield applied
    assert applied.run("rtteardown --exit fixed.xml").status == 0
    assert places(applied) == []


def test_what_was_moved_by_request_is_known_where_it_is(fixed: Shell) -> None:
    assert fixed.run(f"rtmove {THERE} /localhost/manager.mgr").status == 0
    assert fixed.run(f"rtmove {HERE} /robot2/manager.mgr").status == 0
    told = fixed.run("rtcheck fixed.xml")
    why = "/robot2/Num.rtc is not where it may be: the profile has it at /robot1/Num.rtc"
    assert (told.status, why in told.err) == (1, True)
    assert "at path /robot2/Num.rtc" in fixed.run("rtteardown --dry-run --exit fixed.xml").out
    assert fixed.run("rtresurrect fixed.xml").status == 0
    assert places(fixed) == ["/robot2/Num.rtc"]
    assert fixed.run("rtstop fixed.xml").status == 0
    assert "Inactive" in fixed.ok("rtcat /robot2/Num.rtc")
    assert fixed.run("rtapply fixed.xml").status == 0
    assert places(fixed) == [THERE]
    assert fixed.run("rtcheck fixed.xml").status == 0
    assert fixed.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    assert fixed.run("rtteardown --exit fixed.xml").status == 0
    assert places(fixed) == []


def test_no_second_one_is_made_of_what_was_moved_to_a_lost_host(
    fixed: Shell, hosts: list[FarHost]
) -> None:
    assert fixed.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    cut(fixed, hosts[1])
    why = "Num was moved, and may live at /robot2/Num.rtc: host robot2 cannot be reached: "
    for command in ("rtplan", "rtapply", "rtresurrect"):
        told = fixed.run(f"{command} fixed.xml")
        assert (told.status, why in told.err) == (1, True), command
        assert "(rtmgr stop --host robot2 gives it up)" in told.err
    assert places(fixed) == []
    told = fixed.run("rtcheck fixed.xml")
    assert "component unreachable: /robot2/Num.rtc" in told.err
    linked_again(fixed, hosts[1])
    assert places(fixed) == ["/robot2/Num.rtc"]
    assert fixed.run("rtapply fixed.xml").status == 0
    assert places(fixed) == [THERE]


def test_what_was_moved_is_made_again_when_its_host_was_given_up(fixed: Shell) -> None:
    assert fixed.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    assert fixed.run("rtmgr stop --host robot2").status == 0
    assert fixed.run("rtapply fixed.xml").status == 0
    assert places(fixed) == [THERE]


def test_a_teardown_names_an_older_one_on_a_lost_host(applied: Shell, hosts: list[FarHost]) -> None:
    cut(applied, hosts[0])
    moved(applied, hosts)
    told = applied.run(f"rtteardown --exit {FILE}")
    assert (told.status, f"{THERE}: an older one may live there" in told.err) == (1, True)
    assert places(applied) == []
    linked_again(applied, hosts[0])
    assert places(applied) == [THERE]
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    assert places(applied) == []


def test_applying_goes_on_over_what_a_lost_host_was_told(
    applied: Shell, hosts: list[FarHost]
) -> None:
    assert applied.run(f"rtmove {THERE} /robot2/manager.mgr").status == 0
    cut(applied, hosts[0])
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    assert places(applied) == []
    linked_again(applied, hosts[0])
    assert "robot2/manager" in applied.ok("rtget /robot1/manager.mgr/get_fences")
    assert applied.run(f"rtapply {FILE}").status == 0
    assert places(applied) == [THERE]


def test_no_second_one_is_made_when_its_owner_was_stopped(
    applied: Shell, hosts: list[FarHost]
) -> None:
    file = applied.folder / "owner.xml"
    assert applied.run(f"rtteardown --exit {FILE}").status == 0
    text = profile(movable="0 robot2")
    file.write_text(text.replace("robot2/Far", "localhost/Far"))  # nothing else leads to robot2
    assert applied.run("rtapply owner.xml").status == 0
    cut(applied, hosts[0])
    until(lambda: places(applied) == ["/robot2/Num.rtc"], "it is made on robot2")
    linked_again(applied, hosts[0])
    ended_on_robot1(applied)
    applied.ok("rtmgr stop")
    applied.ok("rtmgr start")
    for host in hosts:
        applied.ok(f"rtmgr start --host {host.name}")
    assert "delete Num" in applied.run("rtplan owner.xml").out
    assert applied.run("rtapply owner.xml").status == 0
    assert "Num.rtc" not in applied.ok("rtls /robot2")
    assert places(applied) == [THERE]
    assert applied.run("rtteardown --exit owner.xml").status == 0


def test_a_host_that_is_not_linked_is_named(applied: Shell) -> None:
    file = applied.folder / "named.xml"
    file.write_text(profile(movable="0.5 robot2 robot9"))
    why = "warning: Num: rtkit.movable: host robot9 is not known, and is left out"
    for command in ("rtplan", "rtcheck", "rtapply"):
        told = applied.run(f"{command} named.xml")
        assert (why in told.err, "robot2" in told.err) == (True, False), command
