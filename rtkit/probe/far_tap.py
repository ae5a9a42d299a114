"""Reads or writes ports for a client on another host: a process for each, started by a gateway.

``python -m rtkit.probe.far_tap DESCRIPTOR MANAGER``. Requests come on the socket, see
`rtkit.link.tap_messages`. It is a data tool like others of its own host (decision 15), and ends
with the socket.
"""

from __future__ import annotations

import json
import os
import re
import resource
import signal
import socket
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any

from rtkit.component.values.codec import codec_for
from rtkit.deployment.facts import Snapshot
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.link.tap_messages import (
    CALL,
    DONE,
    ENDED,
    EXTEND,
    FAILED,
    FLUSH,
    GOES_ON,
    JOIN,
    LOST,
    OPEN,
    TAKE,
    WORDS,
    WRITE,
    FrameSplitter,
    call_from_bytes,
    frame,
    values_from_bytes,
    values_to_bytes,
)
from rtkit.link.threads import start_thread
from rtkit.probe.known_types import data_type
from rtkit.probe.port_spec import Stream
from rtkit.probe.probe import LOSSLESS, SURE, Probe, out_ports, tap_ports
from rtkit.probe.tap import Arrival
from rtkit.rtc.names import Path
from rtkit.rtc.profiles import PortRef
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect
from rtkit.tree.wiring import ResolvedPort

_MEMORY_BYTES = 1 << 30
"""What it may use: whoever takes no values, of a component that writes many, loses its tap."""
_PIECE_BYTES = 1 << 20
_LONGEST_S = 1.0
_KIND, _STREAM = re.compile(r"[A-Za-z_]\w{0,40}"), re.compile(r"\w{1,200}")
"""Names that a client may give to its component, and to ports of it."""


class FarTap:
    """A probe that is told what to do by requests.

    Args:
        tree: The manager of its own host.
        send: Sends a frame.
    """

    def __init__(self, tree: Tree, send: Callable[[bytes], object]) -> None:
        self._tree = tree
        self._send = send
        self._probe: Probe | None = None
        self._numbers: dict[str, int] = {}
        self._names: list[str] = []
        self._decode: dict[str, Callable[[bytes], Any]] = {}
        self._left: deque[Arrival] = deque()
        self._taking = Lock()
        self._does = {
            OPEN: self._open, JOIN: self._join, EXTEND: self._extend, WRITE: self._write,
            FLUSH: self._flush, LOST: self._lost,
        }  # fmt: skip

    def take(self, number: int, kind: int, body: bytes) -> None:
        """Take a request, and answer it, some on a thread of their own."""
        if kind in (TAKE, CALL):
            work = self._take if kind == TAKE else self._call
            start_thread(lambda: self._answer(number, work, body), WORDS[kind])
        else:
            self._answer(number, self._does[kind], body)

    def close(self) -> None:
        """End the probe."""
        if self._probe is not None:
            self._probe.close()

    def _answer(self, number: int, work: Callable[[bytes], bytes], body: bytes) -> None:
        try:
            self._send(frame(number, DONE, work(body)))
        except RtkitError as error:
            self._send(frame(number, FAILED, json.dumps([error.kind, str(error)]).encode()))
        except (ValueError, KeyError, TypeError, RecursionError, IndexError) as error:
            self._send(
                frame(number, FAILED, json.dumps([Malformed.kind, repr(error)[:200]]).encode())
            )

    def _opened(self) -> Probe:
        if self._probe is None:
            raise Malformed("nothing is open")
        return self._probe

    def _open(self, body: bytes) -> bytes:
        asked = json.loads(body)
        kind = str(asked["kind"])
        if self._probe is not None or not _KIND.fullmatch(kind):
            raise Refused(f"opens no tap: {kind[:80]!r}")
        streams = self._streams(asked["streams"])
        types = {}
        if asked["writes"]:
            for each in streams:
                types[each.name] = data_type(
                    each.data_type, each.ends[0].path.typed, each.definition
                )
            self._decode = {name: codec_for(cls).decode for name, cls in types.items()}
        ports = out_ports(types) if asked["writes"] else tap_ports(streams)
        probe = Probe(self._tree, kind, streams, ports, float(asked["rate"]))
        probe.is_patient = bool(asked["is_patient"])
        why: list[str] = []
        given = LOSSLESS if asked["lossless"] else SURE if asked["writes"] else {}
        try:
            probe.connect(given, why.append if probe.is_patient else None)
        except BaseException:
            probe.close()
            raise
        self._probe = probe
        return json.dumps([probe.component.instance, why]).encode()

    def _join(self, body: bytes) -> bytes:
        why: list[str] = []
        self._opened().join(self._tree, self._streams(json.loads(body)), why.append)
        return json.dumps(why).encode()

    def _extend(self, body: bytes) -> bytes:
        names = [str(each) for each in json.loads(body)]
        probe = self._opened()
        for each in names:
            if not _STREAM.fullmatch(each) or each in self._numbers:
                raise Refused(f"no name of a further stream: {each[:80]!r}")
            self._number(each)
        probe.extend(tap_ports([Stream(each, ()) for each in names]))
        return b""

    def _streams(self, asked: Sequence[Sequence[Any]]) -> list[Stream]:
        """Return streams by what a client calls them: name, then ends as instance, port, path."""
        if any(not _STREAM.fullmatch(str(name)) for name, _ in asked):
            raise Refused("no name of a stream")
        wanted = [(str(name), [tuple(map(str, end)) for end in ends]) for name, ends in asked]
        instances = [end[0] for _, ends in wanted for end in ends]
        known = self._tree.part(instances)
        found = []
        for name, ends in wanted:
            resolved = []
            for end in ends:
                resolved.append(_resolved(known, *end))
            self._number(name)
            found.append(Stream(name, tuple(resolved)))
        return found

    def _number(self, name: str) -> None:
        if name not in self._numbers:
            self._numbers[name] = len(self._numbers)
            self._names.append(name)

    def _take(self, _body: bytes) -> bytes:
        """Return what has arrived, or after a while nothing."""
        with self._taking:
            probe, end = self._opened(), GOES_ON
            if not self._left:
                piece = probe.take(time.monotonic() + _LONGEST_S)
                end = ENDED if piece is None else GOES_ON
                self._left.extend(piece or ())
            taken: list[Arrival] = []
            size = 0
            while self._left and (not taken or size + len(self._left[0].payload) < _PIECE_BYTES):
                taken.append(self._left.popleft())
                size += len(taken[-1].payload)
            numbered = ((self._numbers[each.stream], *each[1:]) for each in taken)
            return end + values_to_bytes(numbered)

    def _write(self, body: bytes) -> bytes:
        probe = self._opened()
        for stream, _, payload in values_from_bytes(body):
            name = self._names[stream]
            probe.write(name, self._decode[name](payload))
        return b""

    def _flush(self, _body: bytes) -> bytes:
        self._opened().flush()
        return b""

    def _call(self, body: bytes) -> bytes:
        from rtkit.probe.calling import pass_on

        end, timeout_s, call = call_from_bytes(body)
        provider = _resolved(self._tree.part(end[:1]), *end)
        return pass_on(self._tree, provider, call, timeout_s)

    def _lost(self, _body: bytes) -> bytes:
        return json.dumps(self._opened().lost).encode()


def _resolved(known: Snapshot, instance: str, port: str, typed: str) -> ResolvedPort:
    component = known.component(instance)
    profile = component.port(port) if component is not None else None
    if profile is None:
        raise NotFound(f"No such port: {typed}")
    return ResolvedPort(Path(typed, ()), PortRef(instance, port), profile)


def main() -> None:
    """Be the process."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_DATA, (_MEMORY_BYTES, _MEMORY_BYTES))
    end, manager = socket.socket(fileno=int(sys.argv[1])), sys.argv[2]
    lock = Lock()

    def send(data: bytes) -> None:
        with lock:
            end.sendall(data)

    with connect(manager) as tree:
        tap, frames = FarTap(tree, send), FrameSplitter()
        try:
            while data := end.recv(1 << 16):
                for each in frames.feed(data):
                    tap.take(*each)
        finally:
            tap.close()


if __name__ == "__main__":
    try:
        main()
    finally:
        os._exit(0)  # threads of zenoh must not keep the process
