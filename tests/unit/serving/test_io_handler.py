"""A handler of the loop says what it sends; whatever else it does, it need not."""

from __future__ import annotations

import pytest

from rtkit.serving.event_loop import IOHandler, PropertyEventLoop


class Marked(IOHandler):
    def __init__(self, host: PropertyEventLoop) -> None:
        self._host = host
        self.flushed = 0

    def flush(self, now: float) -> float | None:
        self.flushed += 1
        return None


def test_a_handler_that_does_not_say_what_it_sends_cannot_be_made() -> None:
    with pytest.raises(TypeError, match="flush"):
        type("Silent", (IOHandler,), {})()


def test_a_handler_without_a_socket_is_flushed_once_when_it_wakes() -> None:
    host = PropertyEventLoop()
    handler = Marked(host)
    handler.wake()
    assert host._flush(0.0) == []
    assert host._flush(0.0) == []
    assert handler.flushed == 1
    assert handler.ready(1) is None
    handler.check(0.0)
    host.close()
