"""A handler of the loop says what it sends; whatever else it does, it need not."""

from __future__ import annotations

import threading

import pytest

from rtkit.serving.event_loop import IOHandler, PropertyEventLoop

BOUND_S = 30.0


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


class Later(Marked):
    """Has something that is due later only, the first time."""

    def __init__(self, host: PropertyEventLoop) -> None:
        super().__init__(host)
        self.threads: list[int] = []
        self.is_flushed_again = threading.Event()

    def flush(self, now: float) -> float | None:
        self.threads.append(threading.get_ident())
        if len(self.threads) > 1:
            self.is_flushed_again.set()
            return None
        return now


def test_who_changes_something_sends_the_events_itself() -> None:
    host = PropertyEventLoop()
    host.start()
    handler, rung = Marked(host), []
    host._wakeup.ring = lambda: rung.append(1)  # type: ignore[method-assign]
    host.change(handler.wake)
    assert handler.flushed == 1
    assert not rung
    del host._wakeup.ring
    host.close()


def test_what_is_due_later_is_left_to_the_loop() -> None:
    host = PropertyEventLoop()
    host.start()
    handler = Later(host)
    host.change(handler.wake)
    assert handler.is_flushed_again.wait(BOUND_S)
    assert handler.threads[0] == threading.get_ident() != handler.threads[1]
    host.close()


def test_an_error_of_who_changes_something_is_its_own() -> None:
    host = PropertyEventLoop()
    handler = Marked(host)

    def fail() -> None:
        handler.wake()
        raise ValueError("no value")

    with pytest.raises(ValueError, match="no value"):
        host.change(fail)
    assert handler.flushed == 1
    host.change(handler.wake)
    assert handler.flushed == 2
    host.close()
