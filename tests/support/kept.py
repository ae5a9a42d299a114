"""Keeps a manager from one test to the next, as long as it is again what it was when it was new."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import NamedTuple

from forked import Commands
from shells import Shell, opened_shell, processes_of, tree_at

from rtkit.deployment.actions import Delete, EndSlave, Unload
from rtkit.deployment.facts import Snapshot
from rtkit.errors import RtkitError
from rtkit.tree.client import Tree

_PATIENCE_S = 5.0


class _Found(NamedTuple):
    """What can be told of a manager."""

    facts: Snapshot | None = None
    processes: Sequence[int] = ()
    files: Sequence[Path] = ()

    def is_again(self, later: _Found) -> bool:
        """Return whether that is all there is; what a start leaves for a moment may be gone.

        A manager keeps the endpoint of its own components' port data, which the first connection
        to another process opens; its zygote may listen only after the first look.
        """
        gone, new = {*self.files} - {*later.files}, {*later.files} - {*self.files}
        own = f"manager.{self.facts.pid if self.facts else 0}.data"
        return (
            later.facts == self.facts
            and {*later.processes} <= {*self.processes}
            and {path.name for path in new if path.suffix != ".zygote"} <= {own, f"{own}.lock"}
            and all(path.parent.name == "run" for path in gone)
        )


class KeptManager:
    """A shell with a manager that goes from test to test, each of which finds it as new.

    That is one process that lives on, all its facts what they were at its start, no process but
    those that it began with, no file but those, logs as long as then, the shell's settings as they
    were. One of which that is not so after a test is ended, and the next test has a new one.
    """

    def __init__(self, commands: Commands) -> None:
        self._commands = commands
        self._stack = ExitStack()
        self._shell: Shell | None = None
        self._was = _Found()
        self._folder = Path()
        self._logs: dict[Path, int] = {}
        self._environment: dict[str, str] = {}

    def take(self) -> Shell:
        """Return the shell, with a manager that runs."""
        if self._shell is None:
            self._shell = self._stack.enter_context(opened_shell(self._commands))
            self._shell.ok("rtmgr start")
            self._folder = self._shell.folder
            self._environment = dict(self._shell.environment)
            logs = (self._folder / "state").glob("*.[lo][ou][gt]")
            self._logs = {log: log.stat().st_size for log in logs}
            with tree_at(self._socket, _PATIENCE_S) as tree:
                self._was = self._found(self._shell, tree)
        return self._shell

    def give_back(self) -> None:
        """Make it as new, or end it and look for what is left behind."""
        assert self._shell is not None
        try:
            is_as_new = self._made_as_new(self._shell)
        except (RtkitError, OSError):
            is_as_new = False
        if not is_as_new:
            self.close()

    def close(self) -> None:
        """End it, if there is one."""
        self._shell = None
        self._stack.close()

    def _made_as_new(self, shell: Shell) -> bool:
        others = {*self._socket.parent.glob("*.sock")} - {self._socket}
        if others or shell.prefix or shell.folder != self._folder:
            return False
        shell.environment.clear()
        shell.environment.update(self._environment)
        with tree_at(self._socket, _PATIENCE_S) as tree:
            if _lasting(tree.snapshot()) != _lasting(self._was.facts):
                return False
            _empty(tree)
            deadline = time.monotonic() + _PATIENCE_S
            while not self._was.is_again(self._found(shell, tree)):
                if time.monotonic() > deadline:
                    return False
                time.sleep(0.01)
                self._clean()
        for log, size in self._logs.items():
            os.truncate(log, size)
        shell.close()
        return True

    @property
    def _socket(self) -> Path:
        return self._folder / "run" / "manager.sock"

    def _found(self, shell: Shell, tree: Tree) -> _Found:
        return _Found(tree.snapshot(), processes_of(shell.run_id), self._files())

    def _files(self) -> list[Path]:
        """Return all that is there but the store, which a manager has from its first commit on."""
        files = sorted(self._folder.rglob("*"))
        return [path for path in files if not path.match("state/manager.desired*")]

    def _clean(self) -> None:
        """Remove the files that were not there at first; who has a socket removes it itself."""
        for path in reversed(self._files()):
            if path not in self._was.files and path.parent.name != "run":
                path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()


def _lasting(facts: Snapshot | None) -> object:
    """Return what does not become again what it was when all that was made is deleted."""
    return facts and (facts.pid, facts.properties, facts.names, facts.systems)


def _empty(tree: Tree) -> None:
    facts = tree.snapshot()
    actions = [
        *(Delete(each.instance, is_forced=True) for each in facts.components),
        *(EndSlave(each.name, is_forced=True) for each in facts.processes if each.is_slave),
        *(Unload(each.path) for each in facts.modules),
    ]
    tree.apply(actions, is_ordered=False, timeout_s=_PATIENCE_S)
