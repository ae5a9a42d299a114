"""Serves the far side of property measurements: ``-m bench.property_ends ours|zenoh|lines``.

Each says ``ready`` and serves until its input ends.
"""

from __future__ import annotations

import os
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import zenoh

from rtkit.link import places
from rtkit.link.zenoh import open_listener, unix_endpoint

FAN = 10
"""Clients of a bare fan-out."""


class Arm:
    """An object as users serve it."""

    def __init__(self) -> None:
        self.speed = 0.5
        self._angle = 0.5

    @property
    def angle(self) -> float:
        """Angle [rad]."""
        return self._angle

    @angle.setter
    def angle(self, value: float) -> None:
        self._angle = value


def ours() -> None:
    """Serve a thousand numbers, and an object."""
    from rtkit.property.service import Service
    from rtkit.wires.serve import serve

    service = Service()
    for index in range(1000):
        service.add(f"p{index}", float(index), "number")
    service.add("tick", 0, "integer")
    with serve(Arm(), "object", is_on_zenoh=False), serve(service, "bench") as served:

        def run(count: object, given: object) -> None:
            ticks = (int(str(count)), lambda now: served.update("tick", now))
            threading.Thread(target=_tick, args=ticks, daemon=True).start()

        service.add("run", 0, "integer", write=run)
        _wait()


def _tick(count: int, tell: Callable[[int], object]) -> None:
    """Tell the time [ns] a thousand times a second."""
    begin = time.perf_counter_ns()
    for index in range(count):
        ahead = begin + index * 1_000_000 - time.perf_counter_ns()
        if ahead > 0:
            time.sleep(ahead / 1e9)
        tell(time.perf_counter_ns())


def bare_zenoh() -> None:
    """Answer each query with as many bytes as it asks for, or a number."""
    places.make_private(places.runtime_dir())
    session = open_listener(unix_endpoint(f"{places.runtime_dir()}/bare.zps"))
    kept: dict[int, str] = {}

    def answer(query: zenoh.Query) -> None:
        length = int(query.parameters.get("n") or 0)
        count = query.parameters.get("run")
        if count is not None:
            ticks = (int(count), lambda now: session.put("bare/tick", str(now)))
            threading.Thread(target=_tick, args=ticks, daemon=True).start()
        text = kept.setdefault(length, "x" * length) if length else "2.5"
        query.reply(query.key_expr, text)
        query.drop()  # type: ignore[no-untyped-call]

    handler = zenoh.handlers.Callback(answer, indirect=False)
    queryable = session.declare_queryable("bare/get", handler)
    _wait()
    queryable.undeclare()  # type: ignore[no-untyped-call]
    session.close()  # type: ignore[no-untyped-call]


def lines() -> None:
    """Send each line back; at another socket, send the time to all who are connected."""
    places.make_private(places.runtime_dir())
    with _listening("bare.lines", _echo), _listening("bare.fan", _fan_out):
        _wait()


@contextmanager
def _listening(name: str, accept: Callable[[socket.socket], object]) -> Iterator[None]:
    path = f"{places.runtime_dir()}/{name}"
    with socket.socket(socket.AF_UNIX) as endpoint:
        endpoint.bind(path)
        endpoint.listen()
        threading.Thread(target=accept, args=(endpoint,), daemon=True).start()
        yield
        os.unlink(path)


def _echo(endpoint: socket.socket) -> None:
    while True:
        client, _ = endpoint.accept()
        with client:
            while data := client.recv(65536):
                client.sendall(data)


def _fan_out(endpoint: socket.socket) -> None:
    """Send as many times to all clients as the first one asks for, again and again."""
    clients = [endpoint.accept()[0] for _ in range(FAN)]

    def tell(now: int) -> None:
        line = b"* tick %d\n" % now
        for each in clients:
            each.sendall(line)

    while asked := clients[0].recv(64):
        _tick(int(asked), tell)


def _wait() -> None:
    print("ready", flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    {"ours": ours, "zenoh": bare_zenoh, "lines": lines}[sys.argv[1]]()
