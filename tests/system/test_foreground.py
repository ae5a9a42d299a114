"""A manager in the foreground of a terminal: what its keys do, and what its end does."""

from __future__ import annotations

import os
import pty
import select
import signal
import time
from collections.abc import Iterator
from typing import Any

import pytest

from rtkit.manager.core.deletion import FINALISE_S
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

RUNS_PROCESSES = True
MANAGER = "/localhost/manager.mgr"
INT, QUIT = b"\x03", b"\x1c"
HANGS = """
import time
from rtkit.component import Component


class Hangs(Component):
    rate = 100.0

    def on_execute(self, context):
        time.sleep(1e9)


def HangsInit(manager):
    manager.register_factory(Hangs)
"""


class Terminal:
    """A terminal of its own with ``rtmgr run`` as its only process."""

    def __init__(self, shell: Any, prefix: str = "") -> None:
        command = shell.command("rtmgr run")
        if prefix:
            command = [*prefix.split(), *command]
        self.pid, self._fd = pty.fork()
        if not self.pid:
            # Under nohup the tests would hand on that a hang-up is ignored, which managers heed.
            signal.signal(signal.SIGHUP, signal.SIG_DFL)
            os.chdir(shell.folder)
            os.execvpe(command[0], command, shell.environment)
        self.text = ""
        self._pidfd = os.pidfd_open(self.pid)
        self._is_open = True

    def type(self, keys: bytes) -> None:
        os.write(self._fd, keys)

    def close(self) -> None:
        """Close the window."""
        if self._is_open:
            self._is_open = False
            os.close(self._fd)

    def shows(self, text: str) -> None:
        """Wait until it shows a text."""
        deadline = time.monotonic() + 30.0
        while text not in self.text:
            assert self._read(deadline), f"{text!r} is not in {self.text}"

    def end(self) -> int:
        """Return the exit status once the process has ended."""
        deadline = time.monotonic() + 30.0
        while self._is_open and self._read(deadline):
            continue
        assert select.select([self._pidfd], [], [], max(0.0, deadline - time.monotonic()))[0]
        os.close(self._pidfd)
        _, status = os.waitpid(self.pid, 0)
        return os.waitstatus_to_exitcode(status)

    def _read(self, deadline: float) -> bool:
        left_s = max(0.0, deadline - time.monotonic())
        ready = select.select([self._fd, self._pidfd], [], [], left_s)[0]
        if self._fd not in ready:
            return False
        try:
            chunk = os.read(self._fd, 4096)
        except OSError:  # nobody has it open any more
            return False
        self.text += chunk.decode()
        return bool(chunk)


@pytest.fixture
def terminal(shell: Any) -> Iterator[Terminal]:
    terminal = Terminal(shell)
    terminal.shows("begins, rtkit")
    yield terminal
    terminal.close()


@pytest.fixture
def tree(shell: Any, terminal: Terminal, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    yield from _connected(shell, monkeypatch)


def _connected(shell: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, shell.environment[key])
    deadline = time.monotonic() + 30.0
    while shell.run("rtls /localhost").status:
        assert time.monotonic() < deadline, shell.log()
    with connect() as tree:
        yield tree


def slaves(tree: Tree) -> list[int]:
    return [os.pidfd_open(process.pid) for process in tree.snapshot().processes if process.is_slave]


def all_ended(pidfds: list[int]) -> bool:
    """Whether these processes have ended; lets go of them."""
    ended = [bool(select.select([pidfd], [], [], 0)[0]) for pidfd in pidfds]
    for pidfd in pidfds:
        os.close(pidfd)
    return bool(ended) and all(ended)


@pytest.fixture
def others(tree: Tree) -> list[int]:
    tree.create("ConsoleIn?manager_name=s")
    tree.create("ConsoleIn?instance_name=In")
    return slaves(tree)


@pytest.mark.parametrize("key", [INT, QUIT])
def test_a_key_ends_it_in_order(terminal: Terminal, others: list[int], key: bytes) -> None:
    terminal.type(key)
    assert terminal.end() == 0
    assert all_ended(others)
    assert "ends" in terminal.text
    assert ("most recent call first" in terminal.text) is (key == QUIT)


def test_a_terminal_that_is_closed_ends_it_in_order(
    shell: Any, terminal: Terminal, others: list[int]
) -> None:
    terminal.close()
    assert terminal.end() == 0
    assert all_ended(others)
    assert '"message": "ends"' in (shell.folder / "state" / "manager.log").read_text()
    assert not list((shell.folder / "run").iterdir())


def test_quit_tells_where_every_thread_is(shell: Any, terminal: Terminal, tree: Tree) -> None:
    (shell.modules / "Hangs.py").write_text(HANGS)
    tree.create("Hangs?instance_name=H")
    tree.activate("/localhost/H.rtc")
    terminal.type(QUIT)
    terminal.shows('modules/Hangs.py", line 10 in on_execute')
    terminal.type(QUIT)
    assert terminal.end() == 0


def test_a_second_key_spares_the_grace(shell: Any, terminal: Terminal, tree: Tree) -> None:
    (shell.modules / "Hangs.py").write_text(HANGS)
    for place in ("", "&manager_name=s"):
        tree.create(f"Hangs?instance_name=H{len(place)}{place}")
    for row in tree.listing().rows:
        tree.activate(f"/localhost/{row.instance}.rtc")
    ends = slaves(tree)
    begin = time.monotonic()
    terminal.type(INT)
    while True:  # it stops: what is new is refused
        if shell.run(f"rtmgr {MANAGER} -c ConsoleIn").status:
            break
    terminal.type(INT)
    assert terminal.end() == 0
    took_s = time.monotonic() - begin
    assert all_ended(ends)
    assert took_s < FINALISE_S, "it was waited for who hangs"


def test_one_that_ignores_hang_ups_stays_so(shell: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(shell, "nohup")
    for tree in _connected(shell, monkeypatch):
        os.kill(terminal.pid, signal.SIGHUP)
        tree.create("ConsoleIn?manager_name=s")
        terminal.close()
        assert len(tree.listing().rows) == 1
    shell.ok("rtmgr stop")
    assert terminal.end() == 0


def test_a_daemon_stays_when_the_terminal_that_started_it_is_closed(manager: Any) -> None:
    pid = int(manager.ok("rtmgr status").split("Process ID", 1)[1].split()[0])
    os.kill(pid, signal.SIGHUP)
    assert manager.ok("rtls /localhost") == "manager.mgr/\n"


def test_a_daemon_tells_where_its_threads_are_and_goes_on(manager: Any) -> None:
    pid = int(manager.ok("rtmgr status").split("Process ID", 1)[1].split()[0])
    os.kill(pid, signal.SIGUSR1)
    assert manager.ok("rtls /localhost") == "manager.mgr/\n"
    text = (manager.folder / "state" / "manager.out").read_text()
    assert "most recent call first" in text
    assert "loop.py" in text
