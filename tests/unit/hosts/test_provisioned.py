"""Provisioning of a host whose connection breaks: the error that is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from rtkit.errors import Unreachable
from rtkit.hosts import far_program, provisioned
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.host import Host
from rtkit.hosts.progress import unshown


class BrokenChannel:
    """Channel of a connection that breaks after the turn was given."""

    def settimeout(self, _timeout_s: float) -> None:
        pass

    def recv(self, _size: int) -> bytes:
        return f"{far_program.MARK}mine\n".encode()

    def close(self) -> None:
        raise EOFError


def test_the_break_itself_is_told_not_that_the_turn_cannot_be_given_back() -> None:
    channel = BrokenChannel()
    near: Any = SimpleNamespace(host=Host("bare", "10.0.0.1", "root"), open=lambda _args: channel)
    with (
        pytest.raises(Unreachable, match="broken off"),
        provisioned._turn(cast(HostConnection, near), unshown),
    ):
        raise Unreachable("bare: broken off at a.whl.part")
