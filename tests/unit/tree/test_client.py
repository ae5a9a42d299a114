"""The connection to a manager: time-outs, answers that cannot be read, nobody there."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest
from fake_link import InprocLink

from rtkit.errors import Malformed, NotFound, Unreachable
from rtkit.property.exchange import Reply
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect


def tree_that_answers(text: str, error: str = "") -> Tree:
    link = InprocLink()
    link.serve("rt/default/box/manager", lambda request: request.answer(Reply(text, error)))
    return Tree(link, "box", "manager", 0.5)


def test_nobody_there(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    with pytest.raises(Unreachable, match=r"manager 'manager' is not running.*rtmgr start"):
        connect()
    monkeypatch.setenv("RTKIT_MANAGER", "other")
    with pytest.raises(Unreachable, match="manager 'other' is not running"):
        connect()


def test_a_socket_that_nobody_serves(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(tmp_path / "manager.sock"))
    with pytest.raises(Unreachable, match=r"manager 'manager' is not running.*rtmgr start"):
        connect(timeout_s=0.2)


def test_a_manager_that_does_not_answer_is_named() -> None:
    link = InprocLink()
    link.serve("rt/default/box/manager", lambda request: None)
    tree = Tree(link, "box", "manager", 0.05)
    with pytest.raises(Unreachable, match=r"manager on box: no answer within 0.05 s"):
        tree.listing()


def test_an_error_of_the_manager_is_raised() -> None:
    with pytest.raises(NotFound, match="no such property"):
        tree_that_answers("no such property: x", "not-found").get("x")


@pytest.mark.parametrize("text", ["", "{}", "[1, 2]", "[1,2,3,4,[[]]]", "null"])
def test_answers_that_cannot_be_read(text: str) -> None:
    tree = tree_that_answers(text)
    with pytest.raises(Malformed):
        tree.listing()
    with pytest.raises(Malformed):
        tree.snapshot()
