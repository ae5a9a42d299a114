"""The loop hears of everything that other threads want of it."""

from __future__ import annotations

import threading
from contextlib import ExitStack

from rtkit.property import line
from rtkit.property.service import Service
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.wires.line.client import connect_unix
from rtkit.wires.serve import serve

BOUND_S = 30.0


def test_what_is_posted_while_it_wakes_does_not_deafen_it() -> None:
    host = PropertyEventLoop()
    first, second = threading.Event(), threading.Event()
    awaken = host._wakeup

    class Waking:
        """Another thread posts at the worst moment: while the wake-up is being taken."""

        ring = awaken.ring
        fileno = awaken.fileno

        def hush(self) -> bool:
            host.post(first.set)
            host._wakeup = awaken
            return awaken.hush()

    host._wakeup = Waking()  # type: ignore[assignment]
    host.start()
    host.post(lambda: None)
    assert first.wait(BOUND_S)
    host.post(second.set)
    assert second.wait(BOUND_S)
    host.close()


def test_an_event_for_many_is_written_once(place: str) -> None:
    service = Service()
    service.add("tick", 0, "integer")
    with ExitStack() as ends:
        served = ends.enter_context(serve(service, "clock", is_on_zenoh=False))
        clients = [ends.enter_context(connect_unix(served.socket, BOUND_S)) for _ in range(10)]
        for client in clients:
            client.listen("tick?initial=0")
        before = line._known_event.cache_info().misses
        served.update("tick", 7)
        events = [client.event(BOUND_S) for client in clients]
        assert [event and event.payload for event in events] == ["7"] * 10
        assert line._known_event.cache_info().misses == before + 1


def test_its_house_is_kept_without_any_socket() -> None:
    is_kept = threading.Event()

    class Kept(Service):
        def tick(self) -> None:
            is_kept.set()

    host = PropertyEventLoop()
    host.add(Kept("kept"))
    host.start()
    assert is_kept.wait(BOUND_S)
    host.close()
