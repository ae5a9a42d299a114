"""Kills processes at named points, and checks that the state left behind is a legal one.

The rule, for every operation and every point that it passes: the live system afterwards is the one
before, the desired one, or part of the way there; a reported success is true; and the same command,
typed again, leads to the desired system.
"""

from __future__ import annotations

import os
import re
import signal
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from rtkit import fault
from rtkit.cli.shared.command import Main
from rtkit.deployment.actions import Action
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Unreachable
from rtkit.link.zenoh import ZenohLink, open_client, unix_endpoint
from rtkit.tree.client import Tree

STOPPED_S = 0.7
"""For how long processes are stopped [s]."""

PATIENCE_S = 15.0
"""How long may pass until what is done in the background is done [s]."""

GRADUAL_S = 1.0
"""How long to look whether something half done goes on by itself [s]."""

State = Mapping[str, Mapping[str, Any]]
"""What lives, by kind and name: components, connectors, slaves, modules, files."""


class Order(NamedTuple):
    """What is to happen at the so many-th pass of a point."""

    point: str
    number: int
    action: str = "kill"
    argument: str = ""

    def __str__(self) -> str:
        return f"{self.action} {self.argument} at {self.point} {self.number}".replace("  ", " ")


class Points:
    """The folder through which a test talks with the points of all processes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        folder.mkdir(mode=0o700)

    @property
    def variable(self) -> dict[str, str]:
        """What processes need in their environment."""
        return {fault.VARIABLE: str(self._folder)}

    def arm(self, *orders: Order) -> None:
        """Begin to count anew, and have these things happen."""
        self.disarm()
        lines = [f"{o.point} {o.number} {o.action} {o.argument}\n" for o in orders]
        draft = self._folder / "draft"
        draft.write_text("".join(lines))
        draft.rename(self._folder / "orders")

    def disarm(self) -> None:
        """Have nothing happen any more, and forget what was passed."""
        for name in ("orders", "passed", "struck"):
            (self._folder / name).unlink(missing_ok=True)

    def passed(self) -> Counter[str]:
        """Return how often each point was passed."""
        return Counter(line.split()[0] for line in self._lines("passed"))

    def has_struck(self, count: int) -> bool:
        """Whether all that was ordered happens, at the latest soon."""
        deadline = time.monotonic() + PATIENCE_S
        while len(self._lines("struck")) < count and time.monotonic() < deadline:
            time.sleep(0.01)
        return len(self._lines("struck")) >= count

    @contextmanager
    def going_on(self) -> Iterator[None]:
        """Have processes that are stopped go on a little later."""
        is_over = threading.Event()
        thread = threading.Thread(target=self._go_on, args=(is_over,), daemon=True)
        thread.start()
        try:
            yield
        finally:
            is_over.set()
            thread.join()

    def _go_on(self, is_over: threading.Event) -> None:
        gone_on = 0
        while not is_over.wait(0.05) or gone_on < len(self._lines("struck")):
            for line in self._lines("struck")[gone_on:]:
                gone_on += 1
                *_, pid, action = line.split()
                if action == "stop":
                    time.sleep(STOPPED_S)
                    os.kill(int(pid), signal.SIGCONT)

    def _lines(self, name: str) -> list[str]:
        file = self._folder / name
        return file.read_text().splitlines() if file.exists() else []


@dataclass(frozen=True)
class Operation:
    """A command whose interruption is tried everywhere.

    Attributes:
        line: What is typed.
        prepare: Makes what lives before; done again, it repairs what is missing of it.
        again: What the command may say when all is done already; empty if it says nothing.
        is_gradual: It consists of several things, and may be found with some of them done.
        ends_manager: No manager runs when it is done.
        is_blind: No manager runs before it is done: who dies meanwhile is not missed.
    """

    line: str
    prepare: Callable[[Site], object]
    again: str = ""
    is_gradual: bool = False
    ends_manager: bool = False
    is_blind: bool = False


class Site:
    """A shell with a manager whose processes can be broken off, and what lives there."""

    def __init__(self, shell: Any, *, has_points: bool = True) -> None:
        self.shell, self.has_points = shell, has_points
        self.points = Points(shell.folder / "points")
        if has_points:
            shell.environment.update(self.points.variable)

    def start(self) -> None:
        """Start the manager if it does not run."""
        if self.manager_pid():
            return
        _, _, err = self.shell.run("rtmgr start --allow-faults")
        deadline = time.monotonic() + PATIENCE_S
        while not self.manager_pid():  # one that begins to run makes another one give up
            assert time.monotonic() < deadline, f"no manager starts any more: {err}"

    @contextmanager
    def tree(self) -> Iterator[Tree]:
        """Connect to the manager, from this process."""
        path = self.shell.folder / "run" / "manager.sock"
        link = ZenohLink(open_client(unix_endpoint(str(path)), PATIENCE_S))
        with Tree(link, os.uname().nodename, "manager", PATIENCE_S) as tree:
            yield tree

    def apply(self, *actions: Action) -> None:
        """Have these things done; one that is done already may be refused."""
        with self.tree() as tree:
            tree.apply(actions, is_ordered=False)

    def type(self, command: Main, *arguments: str) -> None:
        """Run a command in this process, where it takes less time."""
        with self.tree() as tree:
            command(arguments, tree=tree)

    def state(self, operation: Operation) -> State:
        """Return what lives, as far as two runs are alike in it."""
        state: dict[str, dict[str, Any]] = {"files": self._files()}
        try:
            with self.tree() as tree:
                found = tree.snapshot()
        except Unreachable:
            return state
        state["manager"] = {found.manager: "up"}
        state["components"] = {c.instance: _facts(c) for c in found.components}
        state["connectors"] = {w.connector_id: sorted(map(str, w.ports)) for w in found.connectors}
        state["slaves"] = {p.name: p.state for p in found.processes if p.is_slave}
        state["modules"] = {m.path: m.init for m in found.modules}
        return state

    def _files(self) -> dict[str, str]:
        folder = self.shell.folder
        kept = ("run", "state", "modules", "points")
        texts = {f.name: f.read_text() for f in folder.iterdir() if f.name not in kept}
        return {name: re.sub(r'Date="[^"]*"', "", text) for name, text in texts.items()}

    def manager_pid(self) -> int:
        """Return the process of the manager, 0 if there is none."""
        try:
            with self.tree() as tree:
                return int(tree.get("manager.pid"))
        except Unreachable:
            return 0


def _facts(component: ComponentFacts) -> dict[str, Any]:
    return {
        "type": component.type.type_name,
        "process": component.process,
        "states": [context.state.name for context in component.contexts],
        "set": component.active_set,
        "sets": {name: dict(values) for name, values in component.sets.items()},
        "names": component.names,
        "zombie": component.zombie,
        "trouble": component.trouble,
    }


def counted(site: Site, operation: Operation) -> tuple[State, State, Counter[str]]:
    """Carry an operation out in peace; return what lived before and after, and what it passed."""
    operation.prepare(site)
    before = site.state(operation)
    site.points.arm()
    outcome = site.shell.run(operation.line)
    assert outcome.status == 0, f"{operation.line}: {outcome.err}{site.shell.log()}"
    after = site.state(operation)
    # Those of the manager's loop are passed at each turn, and tried by `test_duties.py`.
    passed = Counter({p: n for p, n in site.points.passed().items() if not p.startswith("duty.")})
    site.points.disarm()
    return before, after, passed


class Breach(Protocol):
    """Something that happens while an operation is carried out."""

    def carry_out(self, site: Site, line: str) -> tuple[Any, set[str]]:
        """Run a command with it; return its outcome, and the kinds of processes that died of it."""


class AtPoints:
    """Things that happen at named points."""

    def __init__(self, *orders: Order) -> None:
        self._orders = orders

    def __str__(self) -> str:
        return ", ".join(map(str, self._orders))

    def carry_out(self, site: Site, line: str) -> tuple[Any, set[str]]:
        """See `Breach.carry_out`."""
        site.points.arm(*self._orders)
        with site.points.going_on():
            outcome = site.shell.run(line, timeout_s=60.0)
            assert site.points.has_struck(len(self._orders)), f"not passed: {self}, {outcome}"
        site.points.disarm()
        killed = {order.point.partition(".")[0] for order in self._orders if order.action == "kill"}
        return outcome, killed


def tried(site: Site, operation: Operation, before: State, after: State, breach: Breach) -> None:
    """Carry an operation out with something happening on the way, and check the rule."""
    operation.prepare(site)
    _same(site.state(operation), before, "the state before is another one")
    manager = site.manager_pid()
    began = time.monotonic()
    outcome, kills = breach.carry_out(site, operation.line)
    took_s = time.monotonic() - began
    told = f"{operation.line!r}, {breach}: exit status {outcome.status}"
    told += f" after {took_s:.1f} s, {outcome.err!r}"
    trial = _Trial(site, operation, before, after, outcome.status, kills)
    try:
        assert "Traceback" not in outcome.err
        assert "bug in rtkit" not in outcome.err
        trial.check(manager)
    except AssertionError as error:
        raise AssertionError(f"{told}\n{error}{site.shell.log()}") from None


class _Trial(NamedTuple):
    """One time that an operation was broken off, and how its command ended.

    Attributes:
        kills: Kinds of processes that were killed: the first words of points.
    """

    site: Site
    operation: Operation
    before: State
    after: State
    status: int
    kills: set[str]

    def check(self, manager: int) -> None:
        """Check what is left, then that the same command leads to the end."""
        site, operation = self.site, self.operation
        if not operation.ends_manager:
            site.start()
        is_new = site.manager_pid() != manager
        found = self._settled(is_new)
        if not self._is_allowed(found, is_new):
            told = _differences(found, self._allowed)
            assert operation.is_gradual, told
            assert self.status, f"success was told, but {told}"
        if not operation.ends_manager:
            with site.tree() as tree:
                tree.listing()
            known = self.after if operation.is_blind else self.before
            if self._dead(found, known, is_new):
                operation.prepare(site)
        again = site.shell.run(operation.line)
        is_done = again.status == 0 or (operation.again and re.search(operation.again, again.err))
        assert is_done, f"and again: {again}"
        final = self._replace(before=self.after, status=0, kills=set())._settled(False)
        _same(final, self.after, f"and again: {again.err!r}")

    @property
    def _allowed(self) -> list[State]:
        """What may be left: who was told of success is to find it."""
        return [self.after] if self.status == 0 else [self.before, self.after]

    def _settled(self, is_new: bool) -> State:
        """Return what lives when it is one of what is allowed, or when patience has ended."""
        began = time.monotonic()
        patience_s = GRADUAL_S if self.operation.is_gradual and self.status else PATIENCE_S
        while True:
            found = self.site.state(self.operation)
            if self._is_allowed(found, is_new) or time.monotonic() > began + patience_s:
                return found
            time.sleep(0.02)

    def _is_allowed(self, found: State, is_new: bool) -> bool:
        """Whether what lives is what may be left, but for what died with its process."""
        for wanted in self._allowed:
            dead = self._dead(found, wanted, is_new)
            if _without(found, dead, is_new) == _without(wanted, dead, is_new):
                return True
        return False

    def _dead(self, found: State, wanted: State, is_new: bool) -> set[str]:
        """Return the components that died with their process.

        Those of a slave are shown as zombies, unless it was a manager that knew it that died too;
        those of a manager are not shown any more.
        """
        here, wished = found.get("components", {}), wanted.get("components", {})
        dead = set()
        if self.kills & {"slave", "holder"}:
            dead = {name for name, facts in here.items() if facts["zombie"]}
            if self.operation.is_blind:
                dead |= wished.keys() - here.keys()
        if is_new and self.kills & {"manager", "holder"}:
            dead |= {name for name, facts in wished.items() if facts["process"] == "manager"}
        return dead


def _without(state: State, dead: set[str], is_new: bool) -> State:
    left = {kind: dict(each) for kind, each in state.items()}
    components = left.get("components", {})
    processes = {components[name]["process"] for name in dead & components.keys()}
    left["components"] = {n: facts for n, facts in components.items() if n not in dead}
    left["connectors"] = {
        id: ends
        for id, ends in left.get("connectors", {}).items()
        if not any(end.partition(".")[0] in dead for end in ends)
    }
    left["slaves"] = {n: s for n, s in left.get("slaves", {}).items() if n not in processes}
    if is_new:
        left.pop("modules", None)
        left.pop("manager", None)
    return left


def _same(found: State, wanted: State, what: str) -> None:
    assert found == wanted, f"{what}: {_differences(found, [wanted])}"


def _differences(found: State, allowed: list[State]) -> str:
    """Tell in what way this is none of what is allowed."""
    told = []
    for wanted in allowed:
        lines = [
            f"{kind} {name}: {here.get(name)} instead of {there.get(name)}"
            for kind in sorted(found.keys() | wanted.keys())
            if (here := found.get(kind, {})) != (there := wanted.get(kind, {}))
            for name in sorted(here.keys() | there.keys())
            if here.get(name) != there.get(name)
        ]
        told.append("; ".join(lines))
    return "left is " + " -- or -- ".join(told)
