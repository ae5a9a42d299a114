"""The system at work, as the campaign sees it: its processes, its facts, its counts."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

import rtkit
from bench.harness import command, folders
from bench.processes import living, parent
from campaign.counts import Counts
from campaign.layout import CONNECTORS, NAMES, activations, creations, settings
from rtkit.deployment.actions import Action, SetParameters
from rtkit.deployment.facts import Snapshot
from rtkit.errors import RtkitError, Unreachable

if TYPE_CHECKING:
    from rtkit.tree.subscription import ManagerSubscription

TICK_S = 0.01
"""How long to wait for news before looking at what tells no news [s]."""
_MODULES = Path(__file__).parent / "components"
_PATIENCE_S = 60.0
_ZYGOTE = b"rtkit.manager.slaves.zygote"
ANSWERED = ("prints", "threads", "coroutine")
"""Misdeeds of an object after which a request of it is answered all the same."""


class Arena:
    """Twenty cells under a manager of their own.

    Attributes:
        profile: The desired state, as an RTS profile.
    """

    def __init__(self, folder: Path) -> None:
        self.profile = folder / "system.xml"
        self._orders = Path(os.environ["RTKIT_STATE_DIR"]) / "orders"
        self._orders.parent.mkdir(mode=0o700)
        self._orders.mkdir()
        self._counts = Counts(str(self._orders.parent / "counts"), is_new=True)
        self.cells = [self._counts.cell(number) for number in range(len(NAMES))]
        self._subscription: ManagerSubscription | None = None
        self._tree: rtkit.Tree | None = None

    # processes

    @property
    def manager(self) -> int:
        """The process of the manager."""
        return self.facts.pid

    def slave(self, name: str) -> int:
        """Return the process of a slave."""
        (pid,) = [each.pid for each in self.facts.processes if each.name == name]
        return pid

    def slaves(self) -> dict[str, int]:
        """Return the processes of all slaves."""
        return {each.name: each.pid for each in self.facts.processes if each.is_slave}

    def zygote(self) -> int:
        """Return the process that forks slaves, 0 while there is none."""
        manager = self.manager
        slaves = set(self.slaves().values())
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit() or int(entry.name) in slaves:
                continue
            try:
                if parent(int(entry.name)) != manager:
                    continue
                if _ZYGOTE in (entry / "cmdline").read_bytes() and living([int(entry.name)]):
                    return int(entry.name)
            except (FileNotFoundError, ProcessLookupError):
                continue
        return 0

    # what is known

    @property
    def facts(self) -> Snapshot:
        """What the manager has told so far."""
        assert self._subscription is not None
        return self._subscription.facts

    def listen(self, *, start: bool = False) -> None:
        """Listen to the manager that runs now, or that is to `start`.

        Raises:
            Unreachable: None answers.
        """
        self.deafen()
        self._tree = rtkit.connect(timeout_s=_PATIENCE_S, start=start)
        self._subscription = self._tree.live()

    def deafen(self) -> None:
        """Listen no more."""
        if self._subscription is not None:
            self._subscription.close()
        if self._tree is not None:
            self._tree.close()
        self._subscription = self._tree = None

    def until(self, is_so: Callable[[], bool], patience_s: float = _PATIENCE_S) -> float:
        """Wait until something is so; return when that was, monotonic [s].

        Raises:
            TimeoutError: It did not become so.
        """
        deadline = time.monotonic() + patience_s
        while not is_so():
            if time.monotonic() > deadline:
                raise TimeoutError
            assert self._subscription is not None
            self._subscription.wait(TICK_S)
        return time.monotonic()

    def trouble(self) -> str:
        """Return what the manager says of itself; empty when nothing troubles it."""
        assert self._tree is not None
        return self._tree.listing().trouble

    def lacks(self) -> str:
        """Return the first thing that the manager says and that is not as desired; empty if none.

        A look at what changes with faults; `differs` compares everything.
        """
        facts = self.facts
        known = {each.instance: each for each in facts.components}
        for name in NAMES:
            its = known.get(name)
            if its is None:
                return f"{name} is not there"
            if its.zombie or its.trouble or its.state != "Active":
                return f"{name} is {its.zombie or its.trouble or its.state}"
        wires = {each.connector_id for each in facts.connectors}
        missing = [name for name in CONNECTORS if name not in wires]
        return f"{missing[0]} is not connected" if missing else ""

    def differs(self) -> str:
        """Return what a plan would still do to reach the desired state; empty for nothing."""
        assert self._tree is not None
        try:
            plan = self._tree.plan(self.profile)
        except RtkitError as error:
            return f"no plan: {error}"
        return f"still to be done: {plan}" if plan else ""

    # what is done

    def is_ordered(self, cell: int) -> bool:
        """Whether a cell has yet to obey an order for its work."""
        return (self._orders / f"{NAMES[cell]}.work").exists()

    def order(self, cell: int, when: str, what: str) -> None:
        """Have a cell do something at its next birth, activation or cycle (``work``)."""
        draft = self._orders / "draft"
        draft.write_text(what)
        draft.rename(self._orders / f"{NAMES[cell]}.{when}")

    def start_manager(self) -> None:
        """Start a manager and listen to it."""
        self.listen(start=True)

    @contextmanager
    def starting(self) -> Iterator[subprocess.Popen[str]]:
        """Have a manager started by its command while something else is done."""
        with subprocess.Popen(
            [command("rtmgr"), "start"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            text=True,
        ) as start:
            yield start

    def begin_to_set(self, cell: int, value: str) -> Callable[[], bool]:
        """Have the gain of a cell set; return what awaits whether that is acknowledged."""
        assert self._tree is not None
        answer = self._tree.begin([SetParameters(NAMES[cell], "default", {"gain": value})])
        return lambda: all(result.ok for result in answer())

    def set_gain(self, cell: int, value: str) -> None:
        """Set the gain of a cell."""
        assert self._tree is not None
        self._tree.configure(f"/localhost/{NAMES[cell]}.rtc", gain=value)

    def gain(self, cell: int) -> str:
        """Return the gain of a cell."""
        (its,) = [each for each in self.facts.components if each.instance == NAMES[cell]]
        return its.sets["default"]["gain"]

    def misuse(self, how: str) -> str:
        """Have user code of the served object go wrong; return what it should not have led to."""
        assert self._tree is not None
        odd = self._tree.properties
        odd.set("odd.misdeed", f'"{how}"')
        requests: list[tuple[str, Callable[[], object]]] = [
            ("getting", lambda: odd.get("odd.mood?timeout=1")),
            ("setting", lambda: odd.set("odd.mood?timeout=1", "x")),
        ]
        if how == "hang":
            requests = [("getting", lambda: odd.get("odd.stuck?timeout=1"))]
        for what, ask in requests:
            outcome = _outcome(ask)
            if (outcome == "") != (how in ANSWERED):
                return f"{what} while it does {how!r}: {outcome or 'answered'}"
        if how != "hang":
            _outcome(lambda: odd.set("odd.act", "()"))  # begun; its end is told later
        well = _outcome(lambda: odd.get("odd.well?timeout=5"))
        return f"odd.well: {well}" if well else ""

    @contextmanager
    def serving(self) -> Iterator[None]:
        """Have an object served whose code goes wrong."""
        line = [command("rtserve"), str(_MODULES / "odd.py:Odd"), "odd"]
        nowhere = subprocess.DEVNULL
        with subprocess.Popen(line, stdout=nowhere, stderr=nowhere) as served:
            try:
                self.until(self._is_served)
                yield
            finally:
                served.terminate()

    def _is_served(self) -> bool:
        assert self._tree is not None
        return not _outcome(lambda: self._tree and self._tree.properties.get("odd.well?timeout=1"))

    def bring_up(self) -> None:
        """Make the system, and keep what it is like as the desired state."""
        self.start_manager()
        assert self._tree is not None
        for actions in (creations(), settings(), activations()):
            _apply(self._tree, actions)
        self.until(lambda: not self.lacks())
        self._tree.save("Campaign").write(self.profile)

    def end(self) -> None:
        """End the manager if one runs."""
        self.deafen()
        with suppress(Unreachable), rtkit.connect(timeout_s=_PATIENCE_S) as tree:
            tree.stop_manager()

    def log(self) -> str:
        """Return the end of the manager's log."""
        path = self._orders.parent / "manager.log"
        return path.read_text()[-6000:] if path.exists() else ""


def _apply(tree: rtkit.Tree, actions: list[Action]) -> None:
    for result in tree.apply(actions, is_ordered=False, timeout_s=_PATIENCE_S):
        result.raise_for_error()


def _outcome(ask: Callable[[], object]) -> str:
    """Return how a request failed; empty if it did not."""
    try:
        ask()
    except RtkitError as error:
        return str(error)
    return ""


def kill(pids: Iterable[int], number: int = signal.SIGKILL) -> None:
    """Send a signal to processes, one right after the other."""
    for pid in pids:
        os.kill(pid, number)


def end(pids: list[int], after_s: float = 0.0) -> None:
    """Kill processes, perhaps a while later, and wait until all have ended."""
    opened = []
    for pid in pids:
        with suppress(ProcessLookupError):  # told by `trial` where it should be there
            opened += [os.pidfd_open(pid)] if pid else []
    time.sleep(after_s)
    for pidfd in opened:
        with suppress(ProcessLookupError):  # it had given up before
            signal.pidfd_send_signal(pidfd, signal.SIGKILL)
    for pidfd in opened:
        select.select([pidfd], [], [])
        os.close(pidfd)


@contextmanager
def arena() -> Iterator[Arena]:
    """Bring the system up; at the end nothing of it is left."""
    os.environ["RTKIT_PORT"] = "none"
    with folders(str(_MODULES)) as folder:
        here = Arena(Path(folder))
        try:
            here.bring_up()
            with here.serving():
                yield here
        finally:
            here.end()
