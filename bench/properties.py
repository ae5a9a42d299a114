"""Measures live properties: one at a time, many at once, very many; beside a bare transport."""

from __future__ import annotations

import itertools
import os
import socket
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager

import zenoh

from bench.harness import Lines, Row, folders, servers, timed
from bench.pairs import Measure, alone, paired
from bench.placement import kept_on, placements
from rtkit.link import places, zenoh_keys
from rtkit.link.zenoh import open_client, open_to_service, unix_endpoint
from rtkit.wires.line.client import LineClient, connect_unix
from tests.support.zenoh_client import ZenohClient

_TIMES = 300
_ON_THE_WAY = 200
_MANY = 1000
_VERY_MANY = 100_000
_BARE_ZENOH_IS = "bare zenoh queries to another process, same sockets, same bytes"
_BARE_LINES_IS = "a loop that sends each line back, in another process, each pinned as rtkit is"


def _zenoh() -> Lines:
    with server() as _, to_service() as ours:
        client = ZenohClient(ours, key(), 10.0)
        with session(f"{places.runtime_dir()}/bare.zps") as bare:
            for what, payload, floor in (("GET", None, None), ("SET", "2.5", "2.5")):
                measured = paired(
                    lambda payload=payload: _each_us(lambda: client.ask("p7", payload)),  # type: ignore[misc]
                    lambda floor=floor: _each_us(lambda: query(bare, "bare/get", floor)),  # type: ignore[misc]
                )
                what = f"property: {what} over zenoh"
                yield Row(what, "us", measured, 1 / 0.85, True, _BARE_ZENOH_IS)


def _line() -> Lines:
    for place in placements():
        with (
            kept_on(place.client),
            server(place.server),
            connect_unix(places.service_socket("bench"), 10.0) as client,
            connect_unix(places.service_socket("object"), 10.0) as of_object,
            socket.socket(socket.AF_UNIX) as bare,
        ):
            bare.connect(f"{places.runtime_dir()}/bare.lines")
            yield from _lines_at(place.words, client, of_object, bare)


def _lines_at(where: str, client: LineClient, of_object: LineClient, bare: socket.socket) -> Lines:
    values = itertools.cycle(("2.5", "3.5"))
    for what, end, name, target in (
        ("", client, "p7", 1.5),
        (" of an attribute", of_object, "speed", None),
        (" of a property with getter and setter", of_object, "angle", None),
    ):
        get, set_it = (lambda: end.ask(name), lambda: end.ask(name, next(values)))  # noqa: B023
        for method, ask, line in (("GET", get, b"GET p7\n"), ("SET", set_it, b"SET p7 2.5\n")):
            measured = paired(
                lambda: _each_us(ask),  # noqa: B023
                lambda: _each_us(lambda: _echo(bare, line)),  # noqa: B023
            )
            row = f"property: {method}{what} as a line, {where}"
            yield Row(row, "us", measured, target, True, _BARE_LINES_IS)
    with client.detach() as ours:
        many = b"GET p7\n" * _ON_THE_WAY
        length = len(_ask_many(ours, many, 0))
        measured = paired(
            lambda: timed(lambda: _ask_many(ours, many, length)) * 1e3 / _ON_THE_WAY,
            lambda: timed(lambda: _ask_many(bare, many, len(many))) * 1e3 / _ON_THE_WAY,
        )
        what = f"property: GET as a line, {_ON_THE_WAY} on the way, {where}"
        yield Row(what, "us", measured, 100.0, False, _BARE_LINES_IS)


def _bulk() -> Lines:
    names = "%20".join(f"p{index}" for index in range(_MANY))
    target = f"properties?values&names=({names})"
    with server(), to_service() as ours:
        client = ZenohClient(ours, key(), 10.0)
        length = len(client.ask(target).value())
        with session(f"{places.runtime_dir()}/bare.zps") as bare:
            measured = paired(
                lambda: timed(lambda: client.ask(target).value()),
                lambda: timed(lambda: query(bare, f"bare/get?n={length};names={names}", None)),
            )
            what = f"property: GET of {_MANY} at once over zenoh"
            yield Row(what, "ms", measured, 5.0, True, _BARE_ZENOH_IS)


def _very_many() -> Lines:
    script = f"""
import time
from rtkit.property.service import Service
begin = time.perf_counter()
service = Service()
for index in range({_VERY_MANY}):
    service.add(f"p{{index}}", float(index), "number")
made = time.perf_counter()
service.get("properties")
listed = time.perf_counter()
print((made - begin) * 1e3, (listed - made) * 1e3,
      int(open("/proc/self/status").read().split("VmRSS:")[1].split()[0]) / 1024)
"""
    bare = f"""
import time
begin = time.perf_counter()
known = {{}}
for index in range({_VERY_MANY}):
    known[f"p{{index}}"] = str(float(index))
made = time.perf_counter()
" ".join(known)
listed = time.perf_counter()
print((made - begin) * 1e3, (listed - made) * 1e3,
      int(open("/proc/self/status").read().split("VmRSS:")[1].split()[0]) / 1024)
"""
    pairs = [(_run(script), _run(bare)) for _ in range(5)]
    floor_is = "a dictionary of as many texts"
    for index, (what, unit, target) in enumerate(
        (("made", "ms", 1500.0), ("listed", "ms", 60.0), ("memory", "MiB", 120.0))
    ):
        ones = sorted(pair[0][index] for pair in pairs)
        others = sorted(pair[1][index] for pair in pairs)
        one, other = ones[2], others[2]
        label = f"property: {_VERY_MANY} in one service, {what}"
        yield Row(label, unit, alone(one, other), target, False, floor_is)


PARTS = {"zenoh": _zenoh, "line": _line, "bulk": _bulk, "many": _very_many}


def _run(script: str) -> list[float]:
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, check=True, text=True
    )
    return [float(each) for each in done.stdout.split()]


def _each_us(work: Callable[[], object]) -> float:
    def repeat() -> None:
        for _ in range(_TIMES):
            work()

    return timed(repeat) * 1e3 / _TIMES


def key() -> str:
    return zenoh_keys.property_service(os.uname().nodename, "bench")


def query(session: zenoh.Session, selector: str, payload: str | None) -> str:
    for reply in session.get(
        selector,
        payload=payload,
        timeout=10.0,
        handler=zenoh.handlers.FifoChannel(16),
        consolidation=zenoh.ConsolidationMode.NONE,
    ):
        if reply.ok is not None:
            return reply.ok.payload.to_string()
    raise RuntimeError(f"no reply to {selector}")


def _ask_many(end: socket.socket, lines: bytes, length: int) -> bytes:
    """Send requests without waiting for replies, of which there are so many bytes, if known."""
    end.sendall(lines)
    got, count = b"", lines.count(b"\n")
    while len(got) < length or (not length and got.count(b"\n") < count):
        got += end.recv(65536)
    return got


def _echo(end: socket.socket, line: bytes) -> None:
    end.sendall(line)
    while not end.recv(65536).endswith(b"\n"):
        pass


@contextmanager
def to_service() -> Iterator[zenoh.Session]:
    """Open a session to the service, as clients of it do."""
    session = open_to_service("bench", 10.0)
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


@contextmanager
def session(path: str) -> Iterator[zenoh.Session]:
    session = open_client(unix_endpoint(path), 10.0)
    try:
        yield session
    finally:
        session.close()  # type: ignore[no-untyped-call]


@contextmanager
def by_line() -> Iterator[Measure]:
    """Yield what measures a GET as a line [us]; the service is a process of its own."""
    with _ours(), connect_unix(places.service_socket("bench"), 10.0) as client:
        yield lambda: _each_us(lambda: client.ask("p7"))


@contextmanager
def by_zenoh() -> Iterator[Measure]:
    """Yield what measures a GET over zenoh likewise."""
    with _ours(), to_service() as ours:
        client = ZenohClient(ours, key(), 10.0)
        yield lambda: _each_us(lambda: client.ask("p7"))


@contextmanager
def _ours() -> Iterator[None]:
    with folders(), servers(["bench.property_ends", "ours"]):
        yield


@contextmanager
def server(processors: Iterable[int] = ()) -> Iterator[None]:
    """Run a service of very simple properties, and what it is compared with, each a process.

    They are kept on these processors, if any are told.
    """
    roles = ("ours", "zenoh", "lines")
    ends = servers(*(["bench.property_ends", role] for role in roles))
    with folders(), ExitStack() as stack:
        with kept_on(processors or os.sched_getaffinity(0)):
            stack.enter_context(ends)
        yield
