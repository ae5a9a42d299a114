"""Connections between managers of different hosts: made, cut off, met again, removed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest
from counting import CHECKER, COUNTER
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from shells import Shell
from terminal import opened
from waiting import until

pytestmark = NEEDS_HOSTS
OUT, FAR_INTO = "/localhost/A.rtc:out", "/robot1/B.rtc:into"
FAR_OUT, INTO = "/robot1/C.rtc:out", "/localhost/D.rtc:into"
OTHER = "/robot2/E.rtc:into"


hosts = hosts_named("robot1", "robot2")


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A sender and a receiver here and on robot1, a receiver on robot2; nothing is connected."""
    with linked(commands, hosts) as shell:
        for name, text in (("Counter", COUNTER), ("Checker", CHECKER)):
            (shell.modules / f"{name}.py").write_text(text)
            for host in hosts:
                host.write(f"/root/{name}.py", text)
        for kind, path in (
            ("Counter", OUT),
            ("Checker", FAR_INTO),
            ("Counter", FAR_OUT),
            ("Checker", INTO),
            ("Checker", OTHER),
        ):
            _, host, rest = path.split("/")
            name = rest[0]
            create = f"{kind}?instance_name={name}&manager_name={name.lower()}"
            shell.ok(f"rtmgr /{host}/manager.mgr -c '{create}&rtkit.restart=on-failure'")
            shell.ok(f"rtact /{host}/{name}.rtc")
        yield shell


@pytest.fixture
def joined(fleet: Shell, hosts: list[FarHost]) -> Iterator[Shell]:
    """Numbers go from here to robot1 and from there to here."""
    fleet.ok(f"rtcon -i there {OUT} {FAR_INTO}")
    fleet.ok(f"rtcon -i back {INTO} {FAR_OUT}")
    flowing(fleet, hosts)
    yield fleet
    linked_again(fleet, *hosts)
    for id, path in (("there", OUT), ("back", INTO)):
        fleet.run(f"rtdis -i {id} {path}")


def counts(fleet: Shell, hosts: list[FarHost]) -> list[tuple[int, int]]:
    """Return the last number that came, and the gaps before it, here and on each host."""
    texts = [(fleet.folder / "count").read_text(), *(host.read("/root/count") for host in hosts)]
    return [(int(last), int(gaps)) for last, gaps in map(str.split, texts)]


def flowing(fleet: Shell, hosts: list[FarHost], places: tuple[int, ...] = (0, 1)) -> None:
    """Wait until numbers come here (0) and on robot1 (1), or elsewhere."""
    before = counts(fleet, hosts)

    def have_come() -> bool:
        now = counts(fleet, hosts)
        return all(now[place][0] > before[place][0] + 5 for place in places)

    until(have_come, f"numbers at {places}")


def half(fleet: Shell, path: str, id: str) -> str | None:
    """Return why only half of a connection is there; "" if it is whole, None if it is not."""
    component = path.partition(":")[0]
    (facts,) = (json.loads(line) for line in fleet.ok(f"rtcat --json {component}").splitlines())
    found = [each.get("trouble", "") for each in facts["connectors"] if each["connector_id"] == id]
    return found[0] if found else None


def awaited(fleet: Shell, path: str, id: str, text: str | None) -> None:
    def has_come() -> bool:
        found = half(fleet, path, id)
        return found == text if not text or found is None else text in found

    until(has_come, f"{text!r} at {path}")


def kill_near(fleet: Shell) -> None:
    pid = int(fleet.ok("rtget /localhost/manager.mgr/pid"))
    os.kill(pid, signal.SIGKILL)
    until(lambda: fleet.run("rtmgr status").status == 1, "the end of the manager")


def test_values_go_both_ways_and_each_end_shows_the_other(joined: Shell) -> None:
    here = os.uname().nodename
    assert " +Connected to  /robot1/manager.mgr/B.rtc:into\n" in joined.ok(f"rtcat -l {OUT}")
    assert f" +Connected to  /{here}/manager.mgr/A.rtc:out\n" in joined.ok(f"rtcat -l {FAR_INTO}")
    again = joined.run(f"rtcon -d {OUT} {FAR_INTO}")
    assert "An identical connection already exists" in again.err
    joined.ok(f"rtdis {FAR_INTO} {OUT}")
    assert half(joined, OUT, "there") is None
    assert half(joined, FAR_INTO, "there") is None


def test_a_cut_off_host_is_named_and_values_go_on_when_it_is_back(
    joined: Shell, hosts: list[FarHost]
) -> None:
    cut(joined, hosts[0])
    why = "host robot1 cannot be reached: "
    awaited(joined, OUT, "there", why)
    awaited(joined, INTO, "back", why)
    assert f"half: {why}" in joined.ok(f"rtcat -l {OUT}")
    assert f"half a connection at out: {why}" in joined.ok("rtls -l /localhost")
    linked_again(joined, hosts[0])
    for path, id in ((OUT, "there"), (INTO, "back"), (FAR_INTO, "there"), (FAR_OUT, "back")):
        awaited(joined, path, id, "")
    flowing(joined, hosts)


def test_what_is_removed_while_a_host_is_away_goes_there_later(
    joined: Shell, hosts: list[FarHost]
) -> None:
    cut(joined, hosts[0])
    told = joined.run(f"rtdis -i there {OUT}")
    assert told.status == 0
    assert "the other half of connection there is removed when it is back" in told.err
    kill_near(joined)
    joined.ok("rtmgr start")
    linked_again(joined, hosts[0])
    awaited(joined, FAR_INTO, "there", None)
    awaited(joined, FAR_OUT, "back", "")


@pytest.mark.parametrize("order", ["near", "far", "near far", "far near"])
def test_managers_die_in_any_order_and_meet_again(
    joined: Shell, hosts: list[FarHost], order: str
) -> None:
    far = joined.ok("rtget /robot1/manager.mgr/pid").strip()
    for name in order.split():
        if name == "near":
            kill_near(joined)
        else:
            hosts[0].run("kill", "-9", far)
    if order == "far":
        awaited(joined, OUT, "there", "host robot1 cannot be reached: ")
    if "near" in order:
        joined.ok("rtmgr start")
    if "far" in order:
        joined.ok("rtmgr start --host robot1")
    linked_again(joined, hosts[0])
    for path, id in ((OUT, "there"), (INTO, "back"), (FAR_INTO, "there"), (FAR_OUT, "back")):
        awaited(joined, path, id, "")
    flowing(joined, hosts)


def test_a_component_made_again_is_joined_again(joined: Shell, hosts: list[FarHost]) -> None:
    found = lambda: hosts[0].run("sh", "-c", "pgrep -x 'rtkit b' || true").strip()  # noqa: E731
    before = found()
    hosts[0].run("kill", "-9", before)
    until(lambda: found() not in ("", before), "the receiver made again")
    awaited(joined, OUT, "there", "")
    flowing(joined, hosts)


def test_two_robots_are_joined_through_here(fleet: Shell, hosts: list[FarHost]) -> None:
    fleet.ok(f"rtcon -i across {FAR_OUT} {OTHER}")
    flowing(fleet, hosts, (2,))
    assert " +Connected to  /robot2/manager.mgr/E.rtc:into\n" in fleet.ok(f"rtcat -l {FAR_OUT}")
    assert 'connectorId="across"' in fleet.ok("rtcryo /robot1 /robot2")
    cut(fleet, hosts[1])
    why = "host robot2 cannot be reached: it, or the host that links both, is away"
    awaited(fleet, FAR_OUT, "across", why)
    linked_again(fleet, hosts[1])
    awaited(fleet, FAR_OUT, "across", "")
    flowing(fleet, hosts, (2,))
    fleet.ok(f"rtdis {FAR_OUT} {OTHER}")
    assert half(fleet, OTHER, "across") is None


def test_a_link_ends_alone_and_the_manager_there_runs_on(fleet: Shell) -> None:
    pid = fleet.ok("rtget /robot2/manager.mgr/pid")
    fleet.ok("rtset /localhost/manager.mgr/unlink_host robot2")
    assert fleet.run("rtls /robot2").status == 1
    assert "robot2" in fleet.ok("rthost list")
    fleet.ok("rtmgr start --host robot2")
    assert fleet.ok("rtget /robot2/manager.mgr/pid") == pid


def test_one_command_reads_ports_of_several_hosts(fleet: Shell) -> None:
    rows = map(json.loads, fleet.ok(f"rtprint --json -n 60 {OUT} {FAR_OUT}").splitlines())
    clocks = {each["ports"][0]: each["clock"]["host"] for each in rows}
    assert clocks == {OUT: os.uname().nodename, FAR_OUT: "robot1"}
    assert fleet.run(f"rtlog -f both.mcap -t 1 {FAR_OUT} {OUT}").status == 0
    shown = fleet.ok("rtlog -d -f both.mcap")
    assert "A_out" in shown
    assert "C_out" in shown
    twice = fleet.run(f"rtprint -n 1 {OUT}.same {FAR_OUT}.same")
    assert twice.err == "rtprint: stream same has ports at two managers\n"
    late = fleet.run(f"rtlog -f late.mcap {FAR_OUT} /localhost/*:out")
    why = "a pattern is followed at one manager: the other ports are at others"
    assert (late.status, why in late.err) == (1, True)
    script = (
        "import rtkit\n"
        "with rtkit.connect() as tree:\n"
        f"    got = tree.values('{OUT}', '{FAR_OUT}', number=60)\n"
        "    print(sorted({each.port for each in got}))\n"
    )
    (fleet.folder / "both.py").write_text(script)
    command = [sys.executable, fleet.folder / "both.py"]
    told = subprocess.check_output(command, env=fleet.environment, text=True)
    assert told == f"{sorted([OUT, FAR_OUT])}\n"


def test_scripts_go_by_the_paths_of_commands(fleet: Shell) -> None:
    script = (
        "import rtkit\n"
        "with rtkit.connect() as tree:\n"
        "    print(*tree.ls('/'), *tree.ls('/robot1'))\n"
        "    tree.deactivate('/robot1/C.rtc')\n"
        "    print(tree.component('/robot1/C.rtc').state)\n"
        "    tree.activate('/robot1/C.rtc')\n"
        f"    tree.connect('{FAR_OUT}', '{INTO}')\n"
        f"    print(tree.disconnect('{INTO}', '{FAR_OUT}'))\n"
        f"    print(tree.read('{FAR_OUT}').data > 0)\n"
        "    path = tree.led_to('/robot1').create('Counter')\n"
        "    print(path)\n"
        "    tree.delete(path)\n"
        "    tree.ls('/robot7')\n"
    )
    (fleet.folder / "script.py").write_text(script)
    command = [sys.executable, fleet.folder / "script.py"]
    told = subprocess.run(command, env=fleet.environment, capture_output=True, text=True)
    names = [*fleet.ok("rtls /").split(), *fleet.ok("rtls /robot1").split()]
    listed = [each.rstrip("/") for each in names]
    made = "/robot1/Counter0.rtc"
    assert told.stdout.splitlines() == [" ".join(listed), "Inactive", "1", "True", made], (
        told.stderr
    )
    assert "/robot7: no such host: robot7" in told.stderr


def test_nobody_is_connected_who_does_not_expect_it(fleet: Shell, hosts: list[FarHost]) -> None:
    near = os.uname().nodename
    script = (
        "from rtkit.tree.connect import connect\n"
        "from rtkit.deployment.actions import Connect\n"
        "from rtkit.rtc.profiles import ConnectorProfile, PortRef\n"
        f"ends = (PortRef('C', 'out'), PortRef('{near}/manager.mgr/D', 'into'))\n"
        "made = ConnectorProfile('own', 'own', ends, {'dataport.dataflow_type': 'push'})\n"
        "print(connect().apply([Connect(made)])[0].why)\n"
    )
    python = "/root/.local/share/rtkit/current/bin/python"
    told = hosts[0].run("env", "RTKIT_HOSTNAME=robot1", python, "-c", script)
    assert any(why in told for why in ("cannot be reached", "nobody here expects"))
    fleet.ok(f"rtcon -i known {FAR_OUT} {INTO}")
    told = hosts[0].run("env", "RTKIT_HOSTNAME=robot1", python, "-c", script)
    assert "nobody here expects connection own" in told
    fleet.ok(f"rtcon -i own-2 {OUT} {FAR_INTO}")
    failed = fleet.run(f"rtcon -i own {FAR_OUT} {INTO} {OTHER}")
    assert "own-2" in failed.err
    told = hosts[0].run("env", "RTKIT_HOSTNAME=robot1", python, "-c", script)
    assert "nobody here expects connection own" in told
    fleet.ok(f"rtdis -i own-2 {OUT}")
    fleet.ok(f"rtdis -i known {INTO}")


def test_data_tools_read_and_write_ports_there_and_leave_nothing(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    assert len(fleet.ok(f"rtprint -n 3 {FAR_OUT}").splitlines()) == 3
    for number in range(1_000_001, 1_000_011):
        fleet.ok(f"rtinject {FAR_INTO} -c {number}")
        until(lambda n=number: counts(fleet, hosts)[1][0] == n, f"{number} is there")
    assert fleet.run(f"rtlog -f far.mcap -t 0.5 {FAR_OUT}").status == 0
    assert "Number of entries: 0\n" not in fleet.ok("rtlog -d -f far.mcap")
    reader = fleet.open(f"rtprint {FAR_OUT}")
    assert reader.stdout is not None
    assert reader.stdout.readline()
    reader.kill()
    for path in (FAR_OUT, FAR_INTO):
        component = path.partition(":")[0]
        until(
            lambda c=component: not json.loads(fleet.ok(f"rtcat --json {c}"))["connectors"],
            f"nothing is left at {path}",
        )


def test_a_watcher_hears_that_a_manager_of_another_host_was_killed(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    watcher = fleet.open("rtls --watch=0.2 /robot2")
    assert watcher.stdout is not None
    assert watcher.stderr is not None
    lines = iter(watcher.stdout.readline, "")  # it waits for the next one
    assert any("E.rtc" in line for line in lines)
    hosts[1].run("kill", "-9", fleet.ok("rtget /robot2/manager.mgr/pid").strip())
    why = "of host robot2 was killed, or is cut off; waiting for it to come back"
    assert why in watcher.stderr.readline()
    fleet.ok("rtmgr start --host robot2")
    linked_again(fleet, hosts[1])
    fleet.ok("rtmgr -c ConsoleIn /robot2/manager.mgr")
    assert any("ConsoleIn0.rtc" in line for line in lines)
    watcher.terminate()
    fleet.ok("rtmgr -d ConsoleIn0 /robot2/manager.mgr")


def test_a_host_that_is_not_linked_is_named_at_once(fleet: Shell) -> None:
    told = fleet.run(f"rtcon {OUT} /robot9/A.rtc:into")
    assert told.status == 1
    assert "robot9" in told.err


ASKS = """
from rtkit.component import Component


class Asks(Component):
    def on_execute(self, context):
        print("got", input("robot asks: "))


def AsksInit(manager):
    manager.register_factory(Asks)
"""


def test_a_component_of_another_host_is_answered_from_here(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    hosts[0].write("/root/Asks.py", ASKS)
    fleet.ok("rtmgr /robot1/manager.mgr -c 'Asks?manager_name=asking'")
    fleet.ok("rtact /robot1/Asks0.rtc")
    until(lambda: "waiting for input" in fleet.ok("rtls -l /robot1"), "it never waited")
    fleet.ok("rtattach --send yes /robot1/Asks0.rtc")
    command = fleet.command("rtattach /robot1/Asks0.rtc")
    environment = {**fleet.environment, "TERM": "xterm"}
    with opened(command, environment, fleet.folder) as terminal:
        terminal.until("got yes")
        terminal.type("again\r")
        terminal.until("got again")
        terminal.type("\x1d")
        terminal.until("left /robot1/Asks0.rtc, which goes on")
        assert terminal.status() == 0
    fleet.ok("rtexit /robot1/Asks0.rtc")
