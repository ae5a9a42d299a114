"""A system over several hosts: what may happen to it, and what must come back.

The hosts are those of the tests: namespaces with a real sshd, and a link that loses packets.
"""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))

_HERE = "localhost"
_FILE = "fleet.xml"
_CUT_S = (0.2, 4.0)
_WEAK_S = (1.0, 3.0)
_OFF_S = (0.0, 2.0)
_LOSS = (0.1, 0.4)
_DELAY_S = (0.05, 0.3)


class Setback(NamedTuple):
    """What came of one fault of a fleet.

    Attributes:
        what: Its kind.
        host: To which it happened.
        recovery_s: From the fault, or from the end of one that lasts, until all is whole [s].
        why: What has not come back; empty if all has.
    """

    what: str
    host: str
    recovery_s: float
    why: str


class Fleet:
    """Senders and receivers of numbers, here and on hosts, each in a process of its own.

    Numbers go from here to the first host and from there to here, and from each further host to the
    one before it.

    Args:
        shell: Its manager is linked to all hosts.
        hosts: Of `farkit`.
        chance: Draws what happens.
    """

    def __init__(self, shell: Any, hosts: list[Any], chance: random.Random) -> None:
        self._shell, self._chance = shell, chance
        self._hosts = {host.name: host for host in hosts}
        names = list(self._hosts)
        ends = [(_HERE, names[0]), (names[0], _HERE), *zip(names[1:], names, strict=False)]
        self._homes: Mapping[str, str] = {
            f"{kind}{number}": home
            for number, pair in enumerate(ends)
            for kind, home in zip(("Counter", "Checker"), pair, strict=True)
        }
        self._wires = [(f"Counter{number}", f"Checker{number}") for number in range(len(ends))]

    def build(self) -> None:
        """Make the system, and save it as the desired state."""
        for host in self._hosts.values():
            self._give_modules(host)
        for name, text in _modules().items():
            (self._shell.modules / name).write_text(text)
        for name in self._homes:
            words = f"{name[:-1]}?instance_name={name}&manager_name={name.lower()}"
            restart = "rtkit.restart=on-failure"
            self._shell.ok(f"rtmgr /{self._homes[name]}/manager.mgr -c '{words}&{restart}'")
        for sender, receiver in self._wires:
            self._shell.ok(f"rtcon {self._path(sender)}:out {self._path(receiver)}:into")
        for name in self._homes:
            self._shell.ok(f"rtact {self._path(name)}")
        places = " ".join(f"/{name}" for name in (_HERE, *self._hosts))
        self._shell.ok(f"rtcryo {places} -o {_FILE}")

    def faults(self, count: int) -> Iterator[tuple[str, str]]:
        """Draw faults as cards are dealt: each kind once before any comes again."""
        deck: list[str] = []
        for _ in range(count):
            if not deck:
                deck = list(FAULTS)
                self._chance.shuffle(deck)
            yield deck.pop(), self._chance.choice(list(self._hosts))

    def tried(self, what: str, host: str) -> Setback:
        """Have a fault happen to a host, and return what comes of it."""
        from waiting import until  # type: ignore[import-not-found]

        lines = FAULTS[what](self, self._hosts[host])
        began, numbers, why = time.monotonic(), self._numbers(), ""

        def is_back() -> bool:
            nonlocal why
            while lines:
                told = self._shell.run(lines[0])
                if told.status:
                    why = f"{lines[0]}: {told.err}"
                    return False
                lines.pop(0)
            why = self._lacks(numbers)
            return not why

        try:
            until(is_back, "it is back")
        except AssertionError:
            why += self._shell.log()
        return Setback(what, host, time.monotonic() - began, why)

    def _path(self, name: str) -> str:
        return f"/{self._homes[name]}/{name}.rtc"

    def _numbers(self) -> list[str]:
        """Return how many numbers have come at each receiver; empty where it cannot be told."""
        return [
            self._shell.run(f"rtget {self._path(name)}.ports.into.count").out
            for _, name in self._wires
        ]

    def _lacks(self, before: list[str]) -> str:
        """Return what is not as desired; empty if all is, once each, and numbers come."""
        checked = self._shell.run(f"rtcheck {_FILE}")
        if checked.status:
            return f"rtcheck: {checked.out}{checked.err}"
        listed = {host: self._shell.run(f"rtls /{host}") for host in {*self._homes.values()}}
        found = sorted(
            (name.removesuffix(".rtc"), host)
            for host, told in listed.items()
            for name in told.out.split()
            if ".rtc" in name
        )
        if found != sorted(self._homes.items()):
            return f"there are {found}"
        pairs = zip(self._wires, before, self._numbers(), strict=True)
        silent = [wire for wire, old, new in pairs if new in ("", old)]
        return f"no number goes from {' to '.join(silent[0])}" if silent else ""

    def _give_modules(self, host: Any) -> None:
        for name, text in _modules().items():
            host.write(f"/root/{name}", text)

    # Faults; each returns the commands that a user types because of it

    def cut(self, host: Any) -> list[str]:
        """Cut its network link for a while."""
        host.wire.is_cut = True
        time.sleep(self._chance.uniform(*_CUT_S))
        host.wire.is_cut = False
        return []

    def lose(self, host: Any) -> list[str]:
        """Have its link lose packets for a while."""
        host.wire.loss = self._chance.uniform(*_LOSS)
        time.sleep(self._chance.uniform(*_WEAK_S))
        host.wire.loss = 0.0
        return []

    def delay(self, host: Any) -> list[str]:
        """Have its link be slow for a while."""
        host.wire.delay_s = self._chance.uniform(*_DELAY_S)
        time.sleep(self._chance.uniform(*_WEAK_S))
        host.wire.delay_s = 0.0
        return []

    def kill_far_manager(self, host: Any) -> list[str]:
        """Kill its manager."""
        host.run("kill", "-9", self._pid(host.name))
        return [f"rtmgr start --host {host.name}"]

    def kill_near_manager(self, _host: Any) -> list[str]:
        """Kill the manager of this host."""
        from waiting import has_ended, until

        pid = int(self._pid(_HERE))
        os.kill(pid, signal.SIGKILL)
        until(lambda: has_ended(pid), "the end of the manager")
        return ["rtmgr start"]

    def _pid(self, host: str) -> str:
        return str(self._shell.ok(f"rtget /{host}/manager.mgr/pid")).strip()

    def kill_link(self, host: Any) -> list[str]:
        """Kill the process of its link."""
        os.kill(self._link(host), signal.SIGKILL)
        return []

    def stop_link(self, host: Any) -> list[str]:
        """Stop the process of its link for a while."""
        pid = self._link(host)
        os.kill(pid, signal.SIGSTOP)
        time.sleep(self._chance.uniform(*_CUT_S))
        os.kill(pid, signal.SIGCONT)
        return []

    def _link(self, host: Any) -> int:
        """Return the process of a link."""
        record = Path(self._shell.environment["RTKIT_RUNTIME_DIR"]) / f"{host.name}.link"
        return int(json.loads(record.read_text(encoding="utf-8"))["pid"])

    def kill_component(self, host: Any) -> list[str]:
        """Kill the process of one of its components."""
        its = sorted(name for name, home in self._homes.items() if home == host.name)
        host.run("pkill", "-9", "-x", f"rtkit {self._chance.choice(its).lower()}"[:15])
        return []

    def power_off(self, host: Any) -> list[str]:
        """End all its processes; what it comes back with is empty."""
        host.power_off()
        time.sleep(self._chance.uniform(*_OFF_S))
        host.power_on()
        self._give_modules(host)
        return [f"rtmgr start --host {host.name}", f"rtapply {_FILE}"]


FAULTS: Mapping[str, Callable[[Fleet, Any], list[str]]] = {
    "cut": Fleet.cut,
    "lossy": Fleet.lose,
    "slow": Fleet.delay,
    "kill far manager": Fleet.kill_far_manager,
    "kill near manager": Fleet.kill_near_manager,
    "kill link": Fleet.kill_link,
    "stop link": Fleet.stop_link,
    "kill component": Fleet.kill_component,
    "power off": Fleet.power_off,
}


def missing() -> str:
    """Return why there can be no such hosts here, empty if there can."""
    import farkit  # type: ignore[import-not-found]

    return str(farkit.missing())


@contextmanager
def fleet(hosts: int, seed: int, commands: Any = None) -> Iterator[Fleet]:
    """Bring a system over so many hosts up; at the end nothing of it is left.

    Args:
        hosts: How many there are beside this one.
        seed: Of what happens.
        commands: What runs commands as forks (`forked`); without, each is a process of its own.
    """
    from farkit import far_hosts
    from fleetkit import linked  # type: ignore[import-not-found]

    names = [f"robot{number}" for number in range(1, hosts + 1)]
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="rtc")))
        found = stack.enter_context(far_hosts(folder, *names, is_lossy=True))
        shell = stack.enter_context(linked(commands, found))
        made = Fleet(shell, found, random.Random(seed))
        made.build()
        yield made


def _modules() -> dict[str, str]:
    from counting import CHECKER, COUNTER  # type: ignore[import-not-found]

    return {"Counter.py": COUNTER, "Checker.py": CHECKER}
