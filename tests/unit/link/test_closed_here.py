"""A client that another thread closes tells who waits at it that the connection has ended."""

from __future__ import annotations

import socket

import pytest

from rtkit.errors import Unreachable
from rtkit.wires.line.client import LineClient


def test_who_waits_for_an_event_is_told() -> None:
    ours, theirs = socket.socketpair()
    with theirs, LineClient(ours, 1.0) as client:
        client.close()
        with pytest.raises(Unreachable, match="closed here"):
            client.event()
