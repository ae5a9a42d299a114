"""Supervises a process that opens a port of a manager: starts it, and another when it ends.

All sessions of a process share zenoh's threads, of which few accept connections and close them:
thousands of connections to the TCP port kept clients of the Unix socket out for 20 s as long as
one process served both (decision 47).
"""

from __future__ import annotations

import contextlib
import logging
import os
import select
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable

from rtkit.errors import Refused, Unreachable
from rtkit.link import port_holders, secret, tcp_endpoint
from rtkit.link.processes import ProcessWatch
from rtkit.manager.child_process import Backoff, exit_reason
from rtkit.settings.configuration import TcpEndpointSettings

_log = logging.getLogger(__name__)
_MODULE = "rtkit.link.endpoint_process"
_GATEWAY = "rtkit.manager.gateway.process"
_READY = "ready"
_TRIES = 5
_START_S = 20.0
_END_S = 3.0
"""How long the process may take to be ready, and to end [s]."""
_THREADS = "(acc: (worker_threads: 4), net: (worker_threads: 4))"
"""Closing a connection takes a thread of zenoh 5 ms: more of them serve sooner after a flood."""


class TcpEndpoint:
    """Process that listens, started at once; another one takes its place when it ends.

    Args:
        inner: Endpoint of the manager's session behind it.
        module: Module that the process runs.
        kind: Name of the port in the log.
    """

    def __init__(self, inner: str, module: str = _MODULE, kind: str = "TCP") -> None:
        self._inner = inner
        self._module, self._kind = module, kind
        self._what = ""
        self._wanted = b""
        self._backoff = Backoff()
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._thread: threading.Thread | None = None
        self._pid = 0
        self._end: socket.socket
        self._spawn()

    def open(self, port: int, request: str) -> None:
        """Open a port, as the module reads the request.

        Raises:
            Unreachable: The port is taken, or the manager cannot be reached behind it.
        """
        self._wanted = f"{request}\n".encode()
        self._what = f"{self._kind} port {port}"
        self._ask()
        name = f"{self._kind} endpoint"
        self._thread = threading.Thread(target=self._supervise, name=name, daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the process, and wait until it has ended."""
        with self._lock:
            self._closing.set()
            self._end.close()
        waiting = self._thread or threading.Thread(target=self._reap, daemon=True)
        if self._thread is None:
            waiting.start()
        waiting.join(_END_S)
        if waiting.is_alive():
            self._kill()
            waiting.join()

    def _spawn(self) -> None:
        self._backoff.begin(time.monotonic())
        ours, theirs = socket.socketpair()
        with theirs:
            theirs.set_inheritable(True)
            arguments = [
                sys.executable,
                "-P",
                "-m",
                self._module,
                str(theirs.fileno()),
                self._inner,
            ]
            environment = {"ZENOH_RUNTIME": _THREADS, **os.environ}
            self._pid = os.posix_spawn(sys.executable, arguments, environment)
        self._end = ours

    def _ask(self) -> None:
        """Have the port opened."""
        deadline, received = time.monotonic() + _START_S, b""
        with contextlib.suppress(BrokenPipeError):  # then nothing is read either
            self._end.sendall(self._wanted)
        while not received.endswith(b"\n"):
            left = max(0.0, deadline - time.monotonic())
            data = self._end.recv(4096) if select.select([self._end], [], [], left)[0] else b""
            if not data:
                raise Unreachable(f"the process of {self._what} was not ready in {_START_S:g} s")
            received += data
        text = received.decode("utf-8", "replace").strip()
        if text != _READY:
            raise Unreachable(text)
        self._backoff.prove()

    def _kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._pid, signal.SIGKILL)

    def _reap(self) -> str:
        try:
            report = os.waitid(os.P_PID, self._pid, os.WEXITED)
        except ChildProcessError:  # another thread has waited for all children
            report = None
        return exit_reason(report) if report is not None else "exit status unknown"

    def _supervise(self) -> None:
        """Start it again whenever it has ended."""
        while True:
            how = self._reap()
            if self._closing.is_set():
                return
            _log.error("the process of %s ended: %s", self._what, how)
            if self._closing.wait(self._backoff.end(time.monotonic())):
                return
            with self._lock:
                if self._closing.is_set():
                    return
                self._end.close()
                self._spawn()
            try:
                self._ask()
            except (Unreachable, OSError) as error:
                _log.error("%s cannot be opened: %s", self._what, error)
                self._kill()
            else:
                _log.warning("%s is open again", self._what)


def end_orphan(pid: int, inner: str) -> bool:
    """End such a process that outlived its manager; return whether it was one, and is gone.

    Args:
        pid: A process that may be anything.
        inner: Endpoint of the manager whose name is locked by this process.
    """
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            arguments = file.read().split(b"\0")
        is_ours = {_MODULE.encode(), _GATEWAY.encode()} & set(arguments)
        if pid == 0 or not is_ours or inner.encode() not in arguments:
            return False
        process = ProcessWatch(pid)
    except OSError:
        return False
    with process:
        process.send(signal.SIGKILL)
        return process.await_end(_END_S)


def open_front(
    wanted: TcpEndpointSettings, endpoint: TcpEndpoint, inner: str, warn: Callable[[str], object]
) -> int:
    """Open the port that is wanted; return its number, 0 for none.

    Args:
        wanted: The port.
        endpoint: Opens it.
        inner: Endpoint of the manager's session behind it.
        warn: Receives why there is none: the usual port may be in use, and the manager can be
            reached all the same.

    Raises:
        Refused: A port that was asked for is in use; names the process.
    """
    secret_file = secret.make()
    for _ in range(_TRIES):
        port = wanted.port or tcp_endpoint.free_port()
        if not tcp_endpoint.is_free(port) and not _end_orphan_at(port, inner):
            break
        try:
            endpoint.open(port, f"{port} {secret_file}")
        except Unreachable:
            if tcp_endpoint.is_free(port):
                raise  # it is not the port that is to blame
            if wanted.port:
                break
        else:
            return port
    endpoint.close()
    why = f"port {port} is in use by {port_holders.port_holder(port) or 'somebody'}"
    if wanted.is_asked:
        raise Refused(f"{why}; choose another one with -p, or none with -a")
    warn(f"{why}: this manager has no TCP port; -p gives it one of its own, -a does without")
    return 0


def open_gateway(wanted: tuple[str, int], inner: str) -> tuple[TcpEndpoint, int]:
    """Open a port to those who show a certificate; return what closes it, and its number.

    Args:
        wanted: Address and port, 0 for any.
        inner: Endpoint of the manager's session behind it.

    Raises:
        Refused: It cannot be opened; says why.
    """
    address, port = wanted
    port = port or tcp_endpoint.free_port()
    if not tcp_endpoint.is_free(port):
        _end_orphan_at(port, inner)
    gateway = TcpEndpoint(inner, _GATEWAY, "TLS")
    try:
        gateway.open(port, f"{address} {port}")
    except Unreachable as error:
        gateway.close()
        raise Refused(f"TLS: {error}") from None
    return gateway, port


def _end_orphan_at(port: int, inner: str) -> bool:
    """End what an earlier manager of this name left at a port; return whether it is free now."""
    holder = port_holders.listener(port)
    return holder is not None and end_orphan(holder.pid, inner) and tcp_endpoint.is_free(port)
