"""What tests of real components share: a connection to the manager, and word from components."""

from __future__ import annotations

import os
import select
from collections.abc import Iterator
from typing import Any

import pytest
from leakkit import grown, held

from rtkit.deployment.actions import ChangeState, Connect, Create, Delete
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect


class Notes:
    """What the components wrote into their diary, line by line as it comes."""

    def __init__(self, path: str) -> None:
        os.mkfifo(path)
        self._fd = os.open(path, os.O_RDWR | os.O_NONBLOCK)
        self._text = b""

    def next(self, count: int) -> list[str]:
        while self._text.count(b"\n") < count:
            assert select.select([self._fd], [], [], 10.0)[0], f"only {self._text!r} came"
            self._text += os.read(self._fd, 65536)
        *lines, self._text = self._text.split(b"\n", count)
        return [line.decode() for line in lines]

    def nothing(self) -> bool:
        return not self._text and not select.select([self._fd], [], [], 0)[0]

    def close(self) -> None:
        os.close(self._fd)


@pytest.fixture
def notes(manager: Any) -> Iterator[Notes]:
    """A diary that components write into: ``$RTKIT_STATE_DIR/diary``."""
    notes = Notes(manager.environment["RTKIT_STATE_DIR"] + "/diary")
    yield notes
    notes.close()


@pytest.fixture
def steady(tree: Tree) -> Iterator[None]:
    """The manager holds no more threads and descriptors when all that was made is deleted."""
    make_and_delete(tree)  # what is opened only once is open now
    pid = tree.listing().pid
    before = held(pid)
    yield
    rows = tree.listing().rows
    tree.apply([Delete(row.instance, is_forced=True) for row in rows], is_ordered=False)
    more = grown(pid, before)
    assert not more, f"the manager kept {dict(more)}"


def make_and_delete(tree: Tree) -> None:
    """Make two components in slaves, connect and activate them, and delete them again."""
    ends = (PortRef("In", "out"), PortRef("Out", "in"))
    actions = [
        Create("ConsoleIn?instance_name=In&manager_name=in"),
        Create("ConsoleOut?instance_name=Out&manager_name=out"),
        Connect(ConnectorProfile("wire", "wire", ends)),
        ChangeState("Out", "0", Transition.ACTIVATE),
        ChangeState("In", "0", Transition.ACTIVATE),
        Delete("In"),
        Delete("Out"),
    ]
    for result in tree.apply(actions, timeout_s=60.0):
        result.raise_for_error()


@pytest.fixture
def tree(manager: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    """A connection to the manager."""
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, manager.environment[key])
    with connect() as tree:
        yield tree
