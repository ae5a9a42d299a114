"""Connections to unix sockets: only to processes of this user."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from rtkit.errors import Unreachable
from rtkit.link import places, unix
from rtkit.wires.line.client import connect_unix


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "noise.ps"))
        listener.listen()
        yield listener


def test_the_other_end_is_known(listener: socket.socket) -> None:
    with unix.connect(listener.getsockname(), 1.0) as end:
        assert (unix.pid_of(end), unix.user_of(end)) == (os.getpid(), os.getuid())
        assert end.gettimeout() == 1.0
    assert unix.is_answering(listener.getsockname())
    assert not unix.is_answering(f"{listener.getsockname()}-not")


def test_a_socket_of_another_user_is_told_nothing(
    listener: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = os.getuid()
    monkeypatch.setattr(os, "getuid", lambda: own + 1)
    path = listener.getsockname()
    with pytest.raises(Unreachable, match=f"cannot reach {path}: another user listens there"):
        connect_unix(path, 1.0)
    with listener.accept()[0] as heard:
        assert heard.recv(1) == b""
    assert unix.is_answering(path)  # nobody may take its place


def test_a_service_that_was_killed_is_named_and_not_its_socket(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(places.service_socket("parts/arm"))
    for path, what in (
        (places.service_socket("parts/arm"), "service parts/arm: Connection refused"),
        (f"{tmp_path}/else/arm.ps", f"{tmp_path}/else/arm.ps: No such file or directory"),
    ):
        with pytest.raises(Unreachable, match=f"^cannot reach {what}$"):
            connect_unix(path, 1.0)
