"""Measures the floor of the round trip: bare zenoh between two processes, rtkit's route.

Each end listens on a unix socket as a peer and opens a client session to the other one's:
``python -m bench.raw ping|echo OWN_SOCKET OTHER_SOCKET``. ``ping`` reads a number of round trips
and the bytes in hex a line, and answers with the median of one [us].
"""

from __future__ import annotations

import statistics
import sys
import time
from typing import TypeAlias

import zenoh

from rtkit.errors import Unreachable
from rtkit.link.zenoh import open_client, open_listener, unix_endpoint

_THERE, _BACK = "bench/there", "bench/back"
_PATIENCE_S = 10.0
_Arrivals: TypeAlias = "zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]]"


def main(role: str, own: str, other: str) -> None:
    """Be one end until the input ends."""
    listener = open_listener(unix_endpoint(own), "peer")
    hears, says = (_BACK, _THERE) if role == "ping" else (_THERE, _BACK)
    arrivals = listener.declare_subscriber(hears, zenoh.handlers.FifoChannel(64))
    client = reach(unix_endpoint(other))
    publisher = client.declare_publisher(says)
    (_ping if role == "ping" else _echo)(arrivals, publisher)
    client.close()  # type: ignore[no-untyped-call]
    listener.close()  # type: ignore[no-untyped-call]


def reach(endpoint: str) -> zenoh.Session:
    """Open a session to an endpoint as soon as somebody listens there."""
    deadline = time.monotonic() + _PATIENCE_S
    while True:
        try:
            return open_client(endpoint, _PATIENCE_S)
        except Unreachable:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.01)


def _echo(arrivals: _Arrivals, publisher: zenoh.Publisher) -> None:
    for sample in arrivals:
        payload = sample.payload.to_bytes()
        if not payload:
            return
        publisher.put(payload)


def _ping(arrivals: _Arrivals, publisher: zenoh.Publisher) -> None:
    for line in sys.stdin:
        count, payload = line.split()
        taken = _trips(arrivals, publisher, bytes.fromhex(payload), int(count))
        print(statistics.median(taken) * 1e6, flush=True)
    publisher.put(b"")


def _trips(
    arrivals: _Arrivals, publisher: zenoh.Publisher, payload: bytes, count: int
) -> list[float]:
    taken = []
    for _ in range(count):
        begin = time.perf_counter()
        publisher.put(payload)
        arrivals.recv().payload.to_bytes()
        taken.append(time.perf_counter() - begin)
    return taken


if __name__ == "__main__":
    main(*sys.argv[1:])
