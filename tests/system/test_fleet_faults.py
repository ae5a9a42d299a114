"""Random faults of a fleet: links, hosts, managers and their processes, and what comes back."""

from __future__ import annotations

import os
import random
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import pytest
from counting import CHECKER, COUNTER
from farkit import FarHost, far_hosts
from fleetkit import NEEDS_HOSTS, linked
from forked import Commands
from shells import Shell
from waiting import until

pytestmark = [
    NEEDS_HOSTS,
    pytest.mark.timeout(280),
]
WIRES = (
    ("localhost/A:out", "robot1/B:into"),
    ("robot1/C:out", "localhost/D:into"),
    ("robot2/F:out", "robot1/E:into"),
)
KINDS = {"A": "Counter", "B": "Checker", "C": "Counter", "D": "Checker", "E": "Checker",
         "F": "Counter"}  # fmt: skip
HOMES = {end.partition("/")[2][0]: end.partition("/")[0] for pair in WIRES for end in pair}


class Fleet:
    """A system over three hosts, and the faults that may happen to it."""

    def __init__(self, shell: Shell, hosts: list[FarHost], chance: random.Random) -> None:
        self.shell, self.chance = shell, chance
        self.hosts = {host.name: host for host in hosts}
        self.faults: dict[str, Callable[[FarHost], str]] = {
            "cut": self.cut,
            "lossy": self.lossy,
            "slow": self.slow,
            "kill far manager": self.kill_far_manager,
            "kill near manager": self.kill_near_manager,
            "kill link": self.kill_link,
            "stop link": self.stop_link,
            "kill component": self.kill_component,
            "power off": self.power_off,
        }

    def build(self) -> None:
        """Make the system, and save it."""
        for host in self.hosts.values():
            self.give_modules(host)
        for name, text in (("Counter", COUNTER), ("Checker", CHECKER)):
            (self.shell.modules / f"{name}.py").write_text(text)
        for name, kind in KINDS.items():
            create = f"{kind}?instance_name={name}&manager_name={name.lower()}"
            restart = "&rtkit.restart=on-failure"
            self.shell.ok(f"rtmgr /{HOMES[name]}/manager.mgr -c '{create}{restart}'")
        for ends in WIRES:
            out, into = ("/" + end.replace(":", ".rtc:") for end in ends)
            self.shell.ok(f"rtcon {out} {into}")
        for name in KINDS:
            self.shell.ok(f"rtact /{HOMES[name]}/{name}.rtc")
        hosts = " ".join(f"/{name}" for name in self.hosts)
        self.shell.ok(f"rtcryo /localhost {hosts} -o fleet.xml")

    def give_modules(self, host: FarHost) -> None:
        for name, text in (("Counter", COUNTER), ("Checker", CHECKER)):
            host.write(f"/root/{name}.py", text)

    # Faults; each returns what a user does about it

    def cut(self, host: FarHost) -> str:
        assert host.wire is not None
        host.wire.is_cut = True
        time.sleep(self.chance.uniform(0.2, 4.0))
        host.wire.is_cut = False
        return ""

    def lossy(self, host: FarHost) -> str:
        assert host.wire is not None
        host.wire.loss = self.chance.uniform(0.1, 0.4)
        time.sleep(self.chance.uniform(1.0, 3.0))
        host.wire.loss = 0.0
        return ""

    def slow(self, host: FarHost) -> str:
        assert host.wire is not None
        host.wire.delay_s = self.chance.uniform(0.05, 0.3)
        time.sleep(self.chance.uniform(1.0, 3.0))
        host.wire.delay_s = 0.0
        return ""

    def kill_far_manager(self, host: FarHost) -> str:
        host.run("kill", "-9", self.shell.ok(f"rtget /{host.name}/manager.mgr/pid").strip())
        return f"rtmgr start --host {host.name}"

    def kill_near_manager(self, _host: FarHost) -> str:
        os.kill(int(self.shell.ok("rtget /localhost/manager.mgr/pid")), signal.SIGKILL)
        until(lambda: self.shell.run("rtmgr status").status == 1, "the end of the manager")
        return "rtmgr start"

    def kill_link(self, host: FarHost) -> str:
        os.kill(self.link(host), signal.SIGKILL)
        return ""

    def stop_link(self, host: FarHost) -> str:
        pid = self.link(host)
        os.kill(pid, signal.SIGSTOP)
        time.sleep(self.chance.uniform(0.2, 4.0))
        os.kill(pid, signal.SIGCONT)
        return ""

    def link(self, host: FarHost) -> int:
        """Return the process of a link."""
        from rtkit.link import host_links

        return host_links.read(host.name).pid

    def kill_component(self, host: FarHost) -> str:
        name = self.chance.choice([each for each in KINDS if HOMES[each] == host.name])
        host.run("pkill", "-9", "-x", f"rtkit {name.lower()}")
        return ""

    def power_off(self, host: FarHost) -> str:
        """End all its processes; what it comes back with is empty."""
        host.power_off()
        time.sleep(self.chance.uniform(0.0, 2.0))
        host.power_on()
        self.give_modules(host)
        return f"rtmgr start --host {host.name}; rtapply fleet.xml"

    # What must come back

    def is_whole(self) -> bool:
        return self.shell.run("rtcheck fleet.xml").status == 0

    def each_is_there_once(self) -> bool:
        lists = {host: self.shell.ok(f"rtls /{host}").split() for host in {*HOMES.values()}}
        found = [(each, host) for host, rows in lists.items() for each in rows if ".rtc" in each]
        return sorted(found) == sorted((f"{name}.rtc", host) for name, host in HOMES.items())


@pytest.fixture(scope="module")
def fleet(commands: Commands, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Fleet]:
    seed = 1 if os.environ.get("CI") else random.SystemRandom().randrange(1_000_000)
    print(f"seed {seed}")
    folder = tmp_path_factory.mktemp("far")
    with ExitStack() as stack:
        hosts = stack.enter_context(far_hosts(folder, "robot1", "robot2", is_lossy=True))
        shell = stack.enter_context(linked(commands, hosts))
        here = stack.enter_context(pytest.MonkeyPatch.context())
        here.setenv("RTKIT_RUNTIME_DIR", shell.environment["RTKIT_RUNTIME_DIR"])
        made = Fleet(shell, hosts, random.Random(seed))
        made.build()
        yield made


def drawn(fleet: Fleet, count: int) -> Iterator[tuple[str, FarHost]]:
    """Draw faults as cards are dealt: each kind once before any comes again."""
    deck: list[str] = []
    for _ in range(count):
        if not deck:
            deck = list(fleet.faults)
            fleet.chance.shuffle(deck)
        yield deck.pop(), fleet.chance.choice(list(fleet.hosts.values()))


@pytest.mark.parametrize(
    "count", [9, pytest.param(200, marks=[pytest.mark.campaign, pytest.mark.timeout(7200)])]
)
def test_a_fleet_comes_back_whole_after_any_fault(fleet: Fleet, count: int) -> None:
    for number, (kind, host) in enumerate(drawn(fleet, count), start=1):
        began = time.monotonic()
        what = f"{number} {kind} {host.name}"
        for line in filter(None, fleet.faults[kind](host).split("; ")):
            until(lambda each=line: fleet.shell.run(each).status == 0, f"{what}: {line}")
        until(fleet.is_whole, f"{what}: {fleet.shell.run('rtcheck fleet.xml').err}")
        before = received(fleet)
        until(lambda old=before: ahead(received(fleet), old), f"{what}: numbers come")
        assert fleet.each_is_there_once(), what
        print(f"{what} {time.monotonic() - began:.1f} s", flush=True)


def received(fleet: Fleet) -> list[int]:
    """Return how many numbers have come at each receiver."""
    paths = [f"/{HOMES[name]}/{name}.rtc.ports.into.count" for name in "BDE"]
    return [int(fleet.shell.run(f"rtget {path}").out or -1) for path in paths]


def ahead(now: list[int], before: list[int]) -> bool:
    return all(number >= 0 and number != old for number, old in zip(now, before, strict=True))
