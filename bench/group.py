"""Measures a group of robots: one request to all members, beside a bare client that asks each."""

from __future__ import annotations

import select
import socket
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager, ExitStack
from time import monotonic

import rtkit
from bench.harness import Lines, Row, folders, servers, timed
from bench.pairs import paired
from rtkit.link import places
from rtkit.link.deadline import with_deadline
from rtkit.property.line import write_request as _line

_MEMBERS = 100
_PROCESSES = 10
_ROUNDS = 41
_BARE_IS = "a client that writes the same lines to 100 sockets at once and reads the replies"


def _fanout() -> Lines:
    names = [f"robots/r{at}" for at in range(_MEMBERS)]
    with folders(), _started(names), ExitStack() as stack:
        client = stack.enter_context(rtkit.Client(timeout_s=20.0))
        ends = [stack.enter_context(socket.socket(socket.AF_UNIX)) for _ in names]
        for end, name in zip(ends, names, strict=True):
            end.connect(places.service_socket(name))
        velocity = "(1.0 0.0 0.0 0.0 0.0 0.0)"
        for what, payload, line in (
            ("SET", velocity, lambda: _line(with_deadline("velocity", monotonic() + 20), velocity)),
            ("GET", None, lambda: _line("velocity", None)),
        ):
            ask = rtkit.Ask("swarm.velocity", *(() if payload is None else (payload,)))
            measured = paired(
                lambda ask=ask: timed(lambda: client.payload(ask, 20.0)),  # type: ignore[misc]
                lambda line=line: timed(lambda: ask_each(ends, line())),  # type: ignore[misc]
                _ROUNDS,
            )
            what = f"group: {what} of {_MEMBERS} members"
            yield Row(what, "ms", measured, 1.5, True, _BARE_IS)


def ask_each(ends: Sequence[socket.socket], line: bytes) -> None:
    """Write one request line to all sockets at once, and read a reply from each."""
    left = {end.fileno(): end for end in ends}
    with select.epoll() as poll:
        for number, end in left.items():
            poll.register(number, select.EPOLLIN)
            end.sendall(line)
        while left:
            for number, _ in poll.poll():
                poll.unregister(number)
                if not left.pop(number).recv(4096).startswith(b"="):
                    raise RuntimeError("a member of the benchmark did not do it")


def _started(names: Sequence[str]) -> AbstractContextManager[None]:
    """Serve members in some processes, and the group of them in another one."""
    count = len(names) // _PROCESSES
    words = [names[at : at + count] for at in range(0, len(names), count)]
    return servers(*(["bench.group", *each] for each in (*words, ["swarm", *names])))


class _Robot:
    """Member: it does nothing but answer."""

    velocity: tuple[float, float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def _serve(words: Sequence[str]) -> None:
    from rtkit.services.group import Group

    with ExitStack() as stack:
        if words[0] == "swarm":
            group = Group(robots=" ".join(words[1:]), deadline=20.0)
            stack.enter_context(rtkit.serve(group, "swarm", is_on_zenoh=False))
        else:
            for name in words:
                stack.enter_context(rtkit.serve(_Robot(), name, is_on_zenoh=False))
        print("ready", flush=True)
        sys.stdin.read()


PARTS = {"fanout": _fanout}

if __name__ == "__main__":
    _serve(sys.argv[1:])
