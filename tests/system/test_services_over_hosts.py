"""Standard services over hosts: asked there and from there, found, led as one, cut off."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator

import pytest
from farkit import FarHost
from fleetkit import NEEDS_HOSTS, cut, hosts_named, linked, linked_again
from forked import Commands
from shells import ROOT, Shell
from waiting import until

pytestmark = [
    NEEDS_HOSTS,
    pytest.mark.timeout(180),  # three bare hosts are made ready first
]
HERE = os.uname().nodename
NAMES = ("robot1", "robot2", "robot3")
BIN = "/root/.local/share/rtkit/current/bin"
LAMP = """
class Lamp:
    type = ("lamp",)

    def __init__(self, level: float = 0.2, at: float = 0.0) -> None:
        self.level = level
        self.location = (at, 0.0, 0.0, 0.0, 0.0, 0.0)
"""


hosts = hosts_named(*NAMES)


@pytest.fixture(scope="module")
def fleet(commands: Commands, hosts: list[FarHost]) -> Iterator[Shell]:
    """A shell that is linked to three hosts."""
    with linked(commands, hosts) as shell:
        (shell.modules / "lamp.py").write_text(LAMP)
        yield shell


@pytest.fixture
def healed(fleet: Shell, hosts: list[FarHost]) -> Iterator[Shell]:
    """The shell, for who cuts links."""
    yield fleet
    linked_again(fleet, *hosts)


def robot_at(fleet: Shell, name: str, host: str, x: float) -> None:
    """Have a robot on a host, in the world of this one."""
    values = {"service": f"robots/{name}", "world": f"/{HERE}/home/world", "start": f"{x},2,0"}
    values |= {"top_speed": "0.5"}
    service(fleet, host, "DifferentialRobot", name, **values)


def service(fleet: Shell, host: str, kind: str, name: str, **values: str) -> None:
    """Have an active component of a standard service."""
    given = "".join(f"&conf.default.{key}={value}" for key, value in values.items())
    create = f"{kind}?instance_name={name}&manager_name={name}{given}"
    fleet.ok(f"rtmgr /{host}/manager.mgr -c '{create}'")
    fleet.ok(f"rtact /{host}/{name}.rtc")


def there(host: FarHost, words: str, name: str = "") -> str:
    """Run a command on a host, under its name or another one; return all that it writes."""
    own = f"RTKIT_HOSTNAME={name} " if name else ""
    return host.run("sh", "-c", f"{own}{BIN}/{words} 2>&1 || true")


@pytest.fixture(scope="module")
def swarm(fleet: Shell) -> Shell:
    """A robot on each host, all in the world of this one, as one group here."""
    endpoints = " ".join(f"hosts={name}" for name in NAMES)
    service(fleet, "localhost", "HomeWorld", "world", service="home/world", endpoints=endpoints)
    for number, host in enumerate(NAMES):
        robot_at(fleet, f"r{number + 1}", host, 2.0 * number)
    members = " ".join(f"/{host}/robots/r{number + 1}" for number, host in enumerate(NAMES))
    service(fleet, "localhost", "Group", "swarm", service="swarm", robots=members)
    until(lambda: "ready" in fleet.run("rtget swarm.status").out, "all robots stand in the world")
    return fleet


def test_services_there_are_asked_and_listed(fleet: Shell) -> None:
    service(fleet, "robot1", "Storage", "notes", service="home/notes", root="/root")
    target = "/robot1/home/notes"
    fleet.ok(f"rtset {target}.today.txt 'water the plants'")
    assert fleet.ok(f"rtget {target}.today.txt") == "water the plants\n"
    assert 'txt  "water the plants"' in fleet.ok(f"rtls -l {target}.today")
    assert fleet.ok(f"rtget {target}.type {target}/status") == '(storage)\n"ready"\n'
    assert "home/notes" in fleet.ok("rtget /robot1.services")
    assert "quota" in fleet.ok(f"rtls {target}")
    assert '"ready"' in fleet.ok(f"rtls -l {target}")
    assert fleet.ok("rtget localhost.hosts") == "(robot1 robot2 robot3)\n"
    for path, why in (
        (f"{target}.nix", "unknown: no such property: nix"),
        ("/robot1/nix.x", "no service named nix (there is home/notes"),
        ("/robot9/a.x", "no link leads to host robot9"),
    ):
        refused = fleet.run(f"rtget {path}")
        assert refused.status == 1
        assert why in refused.err, refused.err
    fleet.ok("rtmgr /robot1/manager.mgr -d notes")
    until(lambda: fleet.ok("rtget /robot2.services") == "()\n", "none is listed that has gone")


def test_events_come_from_there_and_a_service_that_ends_is_told(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    service(fleet, "robot2", "Storage", "s", service="s", root="/root")
    listener = fleet.open("rtlisten /robot2/s.status")
    assert listener.stdout is not None
    assert "ready" in listener.stdout.readline()
    (pid,) = hosts[1].run("pgrep", "-x", "rtkit s").split()
    hosts[1].run("kill", "-9", pid)
    ended = fleet.end_of(listener)
    assert ended.status == 1
    assert "service s of host robot2 has gone" in ended.err
    fleet.run("rtmgr /robot2/manager.mgr -d s")


def test_who_works_on_a_host_has_the_name_that_it_was_started_under(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    host = hosts[1]
    host.run("hostname", "raspberrypi")
    host.write("/root/lamp.py", LAMP)
    assert there(host, "rtls /robot2") == "manager.mgr/\n"
    assert there(host, "rtget --raw localhost.name") == "robot2"
    serve = f"cd; {BIN}/rtserve ./lamp.py:Lamp lamp > lamp.out 2>&1 & echo $!"
    pid = host.run("sh", "-c", serve).strip()
    until(lambda: fleet.run("rtget /robot2/lamp.level").out == "0.2\n", "it is asked from here")
    assert there(host, "rtget /robot2/lamp.level") == "0.2\n"
    host.run("kill", pid)
    host.run("hostname", "robot2")


def test_only_hosts_that_are_named_may_ask_a_service_here(
    fleet: Shell, hosts: list[FarHost]
) -> None:
    first, second, _ = hosts
    target = f"/{HERE}/desk.level"
    lamps = [
        fleet.open(
            "rtserve ./modules/lamp.py:Lamp desk --host robot1 --rule 'deny zenoh robot1 SET at'"
        ),
        fleet.open("rtserve ./modules/lamp.py:Lamp other"),
    ]
    for lamp in lamps:
        assert lamp.stdout is not None
        assert lamp.stdout.readline()
    until(lambda: there(first, f"rtget {target}") == "0.2\n", "it may ask")
    there(first, f"rtset {target} 0.7")
    assert fleet.ok("rtget desk.level") == "0.7\n"
    assert f"(there is desk on host {HERE})" in there(first, f"rtget /{HERE}/other.level")
    for name in ("robot2", "robot1"):  # by its own name, and by that of one who may
        assert "it lets host" in there(second, f"rtget {target}", name)
        assert "no-service" in there(second, f"rtset {target} 0.1", name)
    assert fleet.ok("rtget desk.level") == "0.7\n"
    for lamp in lamps:
        lamp.terminate()
        lamp.wait()


def test_the_home_demonstration_runs_over_two_hosts(fleet: Shell, hosts: list[FarHost]) -> None:
    demo, out = ROOT / "examples" / "home" / "demo.py", fleet.folder / "pictures"
    given = f"{out} --there robot1 --set pace=4"
    environment = {k: v for k, v in fleet.environment.items() if k != "RTKIT_MANAGER"}
    done = subprocess.run(
        [sys.executable, demo, *given.split()],
        env=environment, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "on robot1: home/lights/hall home/lights/kitchen robots/r1\n" in done.stdout
    assert (out / "ball.png").read_bytes().startswith(b"\x89PNG")
    assert done.stdout.endswith("robot1: demo-home ended\n")
    assert fleet.ok("rtls /robot1") == "manager.mgr/\n"
    assert fleet.ok("rtpkg list --host robot1") == ""
    refused = subprocess.run(
        [sys.executable, demo, out, "--there", "robot9"],
        env=environment, capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    assert refused.returncode == 1
    assert refused.stderr.startswith("demo-home: no such host: robot9")


def test_a_swarm_over_three_hosts_is_led_as_one_robot(swarm: Shell) -> None:
    def place(name: str) -> tuple[float, ...]:
        return tuple(map(float, swarm.ok(f"rtget {name}.location").strip(" ()\n").split()))

    before = place("swarm")

    def ahead() -> bool:
        swarm.ok("rtset swarm.velocity '(0.4 0 0 0 0 0)'")
        return place("swarm")[0] > before[0] + 0.2

    until(ahead, "all have gone ahead")
    swarm.ok("rtset swarm.velocity '(0 0 0 0 0 0)'")
    each = [place(f"swarm.robots.r{number}") for number in (1, 2, 3)]
    assert all(x > 2.0 * number for number, (x, *_) in enumerate(each))
    x, y = place("swarm")[:2]
    swarm.ok(f"rtset swarm.behaviors.moveto '<marker><location>({x} {y + 0.5} 0)</location>"
             "<frame>world</frame></marker>'")  # fmt: skip
    until(lambda: 'state="done"' in swarm.ok("rtget swarm.behaviors.moveto"), "all are there")


def test_a_host_that_is_cut_off_is_named_and_the_others_go_on(
    swarm: Shell, healed: Shell, hosts: list[FarHost]
) -> None:
    cut(swarm, hosts[2])
    before = swarm.ok("rtget swarm.robots.r1.location")

    def turned() -> bool:
        refused = swarm.run("rtset swarm.velocity '(0 0 0 0 0 0.2)'")
        assert refused.status == 1
        assert "1 of 3 failed: r3: no-service: host robot3 cannot be reached: " in refused.err
        return swarm.ok("rtget swarm.robots.r1.location") != before

    until(turned, "another one turns")
    hosts[2].link("up")
    until(lambda: swarm.run("rtset swarm.velocity '(0 0 0 0 0 0)'").status == 0, "it is back")


def test_a_search_finds_what_is_there_and_tells_which_host_is_silent(
    swarm: Shell, healed: Shell, hosts: list[FarHost]
) -> None:
    service(swarm, "localhost", "Resource", "resource", service="resource", watch="robots/*")
    found = lambda query: swarm.ok(f"rtget 'resource.search?{query}'").strip()  # noqa: E731
    robots = " ".join(f"/{host}/robots/r{number + 1}" for number, host in enumerate(NAMES))
    until(lambda: found("type=mobilerobot") == f"({robots})", "all are found")
    assert found("near=(0 2 9)") == f"({robots})"
    assert swarm.ok("rtget resource.unanswered") == "()\n"
    assert 'protocol="zenoh">/robot2/robots/r2<' in swarm.ok("rtget resource.robot2.robots.r2")
    hosts[1].link("down")
    until(lambda: '/robot2" ' in found_unanswered(swarm), "the host is named")
    rest = f"({robots})".replace(" /robot2/robots/r2", "")
    until(lambda: found("near=(0 2 9)") == rest, "the others are found")
    told = '<failed code="no-service">/robot2</failed>'  # a time-out until the host counts as lost
    until(lambda: told in found("near=(0 2 9)&failed=1"), "the host is told as lost")
    hosts[1].link("up")
    until(lambda: found("near=(0 2 9)") == f"({robots})", "it is found again")
    assert swarm.ok("rtget resource.unanswered") == "()\n"


def found_unanswered(shell: Shell) -> str:
    shell.ok("rtget 'resource.search?near=(0 2 9)'")
    return shell.ok("rtget resource.unanswered")
