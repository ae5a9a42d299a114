"""Measures searches with a live condition among 500 processes, some of them killed, some stopped.

Each service has a process of its own, all forked from one that has imported what they need. In each
round 50 are killed at random; in the second row five more are stopped (SIGSTOP), so their sockets
take requests that nobody answers.
"""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial

import rtkit
from bench.group import ask_each
from bench.harness import Lines, Row, folders, servers, timed
from bench.pairs import medians
from rtkit.link import places
from rtkit.property.line import write_request

_SERVICES = 500
_KILLED = 50
_STOPPED = 5
_ROUNDS = 5
_START_S = 60.0
_BARE_IS = "a client that writes the same line to 500 sockets at once and reads the replies"
_WAITING_IS = "the time that the search waits for answers"
_WAITING_MS = 800.0


class _Light:
    """Service with a value to search for, and the process that it lives in."""

    type = ("light",)

    def __init__(self) -> None:
        self.level = 1.0
        self.pid = os.getpid()


def _searches() -> Lines:
    with (
        folders(),
        servers(["bench.search", "resource"]),
        _lights() as start,
        rtkit.Client(timeout_s=20.0) as client,
    ):
        chance = random.Random(1)
        pairs = [_round(client, start, chance, 0) for _ in range(_ROUNDS)]
        what = f"search of {_SERVICES} services by a live condition, {_KILLED} of them killed"
        yield Row(what, "ms", medians(pairs), 1000.0, False, _BARE_IS)
        pairs = [_round(client, start, chance, _STOPPED) for _ in range(_ROUNDS)]
        what += f", {_STOPPED} stopped"
        yield Row(what, "ms", medians(pairs), 1000.0, False, _WAITING_IS)


def _round(
    client: rtkit.Client, start: Callable[[list[str]], None], chance: random.Random, stopped: int
) -> tuple[float, float]:
    """Kill and stop some at random; return the times of the search and of its floor [ms]."""
    names = [f"lights/l{at}" for at in range(_SERVICES)]
    start(names)
    _until(lambda: _found(client) == names)
    pids = client.ask_all([rtkit.Ask(f"{name}.pid") for name in names], 20.0)
    floor = _WAITING_MS if stopped else _bare_ms(names)
    chosen = chance.sample(range(_SERVICES), _KILLED + stopped)
    gone, silent = chosen[:_KILLED], chosen[_KILLED:]
    answer: list[object] = []
    try:
        for number, each in ((signal.SIGKILL, gone), (signal.SIGSTOP, silent)):
            for at in each:
                os.kill(pids[at], number)
        figure = timed(lambda: answer.extend(_search(client, where="level > 0", failed=1)))
    finally:
        for at in silent:
            os.kill(pids[at], signal.SIGCONT)
    failed = {str(each.leaf) for each in answer if isinstance(each, rtkit.Element)}
    if failed != {names[at] for at in chosen} or len(answer) != _SERVICES:
        raise RuntimeError("a search of the benchmark did not name who failed")
    return figure, floor


def _search(client: rtkit.Client, **parameters: object) -> Sequence[object]:
    found: Sequence[object] = client.get("resource.search", type="light", **parameters)
    return found


def _found(client: rtkit.Client) -> list[str]:
    return sorted(map(str, _search(client)), key=lambda name: int(name.partition("/l")[2]))


def _until(holds: Callable[[], bool]) -> None:
    end = time.monotonic() + _START_S
    while not holds():
        if time.monotonic() > end:
            raise RuntimeError("the services of the benchmark were not found")
        time.sleep(0.1)


def _bare_ms(names: Sequence[str]) -> float:
    with ExitStack() as stack:
        ends = [stack.enter_context(socket.socket(socket.AF_UNIX)) for _ in names]
        for end, name in zip(ends, names, strict=True):
            end.connect(places.service_socket(name))
        return timed(lambda: ask_each(ends, write_request("level", None)))


@contextmanager
def _lights() -> Iterator[Callable[[list[str]], None]]:
    """Yield what has services started, each in its process, unless they run already."""
    words, pipe = [sys.executable, "-m", "bench.search", "lights"], subprocess.PIPE
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, text=True) as parent:
        yield partial(_start, parent)


def _start(parent: subprocess.Popen[str], names: list[str]) -> None:
    assert parent.stdin is not None
    assert parent.stdout is not None
    print(*names, file=parent.stdin, flush=True)
    if parent.stdout.readline() != "ready\n":
        raise RuntimeError("the services of the benchmark did not start")


def _serve_lights() -> None:
    import rtkit.wires.serve  # noqa: F401  each fork has it then

    running: dict[str, int] = {}
    for line in sys.stdin:
        while ended := running and os.waitpid(-1, os.WNOHANG)[0]:
            running = {name: pid for name, pid in running.items() if pid != ended}
        begun = {name: _forked(name) for name in line.split() if name not in running}
        for _, reader in begun.values():
            os.read(reader, 1)
            os.close(reader)
        running |= {name: pid for name, (pid, _) in begun.items()}
        print("ready", flush=True)
    for pid in running.values():
        os.kill(pid, signal.SIGKILL)


def _forked(name: str) -> tuple[int, int]:
    """Serve a light in a process of its own; return its pid, and where it tells that it does."""
    reader, writer = os.pipe()
    if pid := os.fork():
        os.close(writer)
        return pid, reader
    served = rtkit.serve(_Light(), name, is_on_zenoh=False)
    os.write(writer, b"!")
    while served:
        signal.pause()
    raise AssertionError


def _serve_resource() -> None:
    from rtkit.services.resource import Resource

    with rtkit.serve(Resource(), "resource", is_on_zenoh=False):
        print("ready", flush=True)
        sys.stdin.read()


PARTS = {"live": _searches}

if __name__ == "__main__":
    (_serve_resource if sys.argv[1] == "resource" else _serve_lights)()
