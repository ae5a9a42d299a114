"""Measures the floor of data tools: bare zenoh that only counts, on the route of rtkit.

``python -m bench.flow pour|drain SOCKET``: ``drain`` listens on a unix socket; for each line
``COUNT`` it answers with the time that so many values took from that line on [ms]. ``pour`` sends
``COUNT SIZE`` values for each line, none of which it drops.
"""

from __future__ import annotations

import sys
import threading
import time

import zenoh

from bench.raw import reach
from rtkit.link.zenoh import open_listener, unix_endpoint

_KEY = "bench/flow"
_PATIENCE_S = 60.0


def main(role: str, path: str) -> None:
    """Be one end until the input ends."""
    (_drain if role == "drain" else _pour)(path)


def _drain(path: str) -> None:
    counted = 0
    wanted = 0
    reached = threading.Event()

    def heard(sample: zenoh.Sample) -> None:
        nonlocal counted
        sample.payload.to_bytes()
        counted += 1
        if counted == wanted:
            reached.set()

    listener = open_listener(unix_endpoint(path), "peer")
    listener.declare_subscriber(_KEY, heard)
    for line in sys.stdin:
        counted, wanted = 0, int(line)
        reached.clear()
        print("ready", flush=True)
        begin = time.perf_counter()
        if not reached.wait(_PATIENCE_S):
            raise TimeoutError(f"{counted} of {wanted} values came")
        print((time.perf_counter() - begin) * 1e3, flush=True)
    listener.close()  # type: ignore[no-untyped-call]


def _pour(path: str) -> None:
    client = reach(unix_endpoint(path))
    block = zenoh.CongestionControl.BLOCK
    publisher = client.declare_publisher(_KEY, congestion_control=block)
    for line in sys.stdin:
        count, size = map(int, line.split())
        payload = bytes(size)
        for _ in range(count):
            publisher.put(payload)
    client.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
