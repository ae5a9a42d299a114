"""Measures floors of the round trip between two processes, with nothing of rtkit on the way.

``python -m bench.raw KIND ping|echo PLACE SIZE``, of which the echo is started first and says that
it is there. ``ping`` reads a number of round trips a line, and answers with the median of one [us].
The kinds are a bare socket, zenoh between sessions at unix sockets, and iceoryx2. Each end writes
an array and gets one to read, as components do: a copy into what is sent, none out of it.
"""

from __future__ import annotations

import ctypes
import os
import socket
import statistics
import sys
import time
from collections.abc import Callable
from typing import Any, TypeAlias

Ends: TypeAlias = tuple[Callable[[Any], object], Callable[[], Any]]
"""What sends octets, and what waits for the next ones."""
KINDS = {
    "socket": "a bare SOCK_SEQPACKET",
    "zenoh": "bare zenoh",
    "iceoryx2": "iceoryx2 with its events",
}
_PATIENCE_S = 10.0
_kept: list[object] = []
"""What would be closed with the last reference to it."""


def main(kind: str, role: str, place: str, size: int) -> None:
    """Be one end until the input ends."""
    send, receive = _OPENERS[kind](role, place, size)
    if role == "ping":
        sent = os.urandom(size)
        for line in sys.stdin:
            print(statistics.median(_trips(send, receive, sent, int(line))) * 1e6, flush=True)
        send(bytes(size))
        return
    while any((came := receive())[:8]):
        send(came)


def _trips(
    send: Callable[[Any], object], receive: Callable[[], Any], sent: bytes, count: int
) -> list[float]:
    taken = []
    for _ in range(count):
        begin = time.perf_counter()
        send(sent)
        came = receive()
        taken.append(time.perf_counter() - begin)
        if came[-1] != sent[-1]:
            raise ValueError("another value came back")
    return taken


def _sockets(role: str, place: str, size: int) -> Ends:
    end = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    if role == "echo":
        end.bind(f"{place}/bare")
        end.listen(1)
        _say()
        end = end.accept()[0]
    else:
        end.connect(f"{place}/bare")
    return end.send, lambda: end.recv(size)


def _zenoh(role: str, place: str, size: int) -> Ends:
    import zenoh

    from rtkit.link.zenoh import open_listener, unix_endpoint

    names = ("there", "back") if role == "ping" else ("back", "there")
    listener = open_listener(unix_endpoint(f"{place}/{names[1]}"), "peer")
    arrivals = listener.declare_subscriber(names[1], zenoh.handlers.FifoChannel(64))
    if role == "echo":
        _say()
    client = reach(unix_endpoint(f"{place}/{names[0]}"))
    publisher = client.declare_publisher(names[0])
    _kept.extend([listener, client])
    while not publisher.matching_status.matching:
        time.sleep(0.001)
    return publisher.put, lambda: arrivals.recv().payload.to_bytes()


def reach(endpoint: str) -> Any:
    """Open a session of zenoh to an endpoint as soon as somebody listens there."""
    from rtkit.errors import Unreachable
    from rtkit.link.zenoh import open_client

    deadline = time.monotonic() + _PATIENCE_S
    while True:
        try:
            return open_client(endpoint, _PATIENCE_S)
        except Unreachable:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)


def _iceoryx2(role: str, place: str, size: int) -> Ends:
    import iceoryx2 as iox2  # type: ignore[import-not-found, import-untyped, unused-ignore]

    iox2.set_log_level(iox2.LogLevel.Error)
    node = iox2.NodeBuilder.new().create(iox2.ServiceType.Ipc)

    def service(way: str) -> tuple[Any, Any]:
        name = iox2.ServiceName.new(f"{place}/{way}")
        values = node.service_builder(name).publish_subscribe(iox2.Slice[ctypes.c_uint8])
        return values.open_or_create(), node.service_builder(name).event().open_or_create()

    ways = ("there", "back") if role == "ping" else ("back", "there")
    (values_out, events_out), (values_in, events_in) = map(service, ways)
    publisher = values_out.publisher_builder().initial_max_slice_len(size).create()
    notifier = events_out.notifier_builder().create()
    subscriber = values_in.subscriber_builder().create()
    listener = events_in.listener_builder().create()
    _kept.append(node)
    held: list[object] = []
    if role == "echo":
        _say()

    def send(value: Any) -> None:
        sample = publisher.loan_slice_uninit(size)
        sample.payload().as_memory_view().cast("B")[:] = value
        sample.assume_init().send()
        notifier.notify()

    def receive() -> memoryview:
        while True:
            sample = subscriber.receive()
            if sample is not None:
                held[:] = [sample]  # its memory is that of the view
                octets: memoryview = sample.payload().as_memory_view().cast("B")
                return octets
            listener.blocking_wait()

    return send, receive


def _say() -> None:
    print("there", flush=True)


_OPENERS: dict[str, Callable[[str, str, int], Ends]] = {
    "socket": _sockets,
    "zenoh": _zenoh,
    "iceoryx2": _iceoryx2,
}

if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4]))
