"""Serves a port of a manager in a process of its own, until the manager is gone.

`rtkit.manager.endpoints.listening_process` starts it.

The process receives the port to open on a socket, as ``PORT SECRET_FILE``, and answers ``ready``,
or the error; then it may receive another one. It exits when the socket closes.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from rtkit.errors import RtkitError
from rtkit.link.port_holders import SERVANT
from rtkit.link.tcp_endpoint import open_endpoint

READY = "ready"


def open_at(wanted: str, inner: str, stack: ExitStack) -> None:
    """Open the port ``PORT SECRET_FILE``, which the stack closes.

    Raises:
        Unreachable: The port is taken, or the manager does not answer.
    """
    port, _, secret_file = wanted.partition(" ")
    stack.callback(open_endpoint(int(port), inner, secret_file).close)


def serve_manager(open_: Callable[[str, str, ExitStack], object], arguments: Sequence[str]) -> None:
    """Open what the manager asks for, and serve it until the manager is gone.

    Args:
        open_: Opens it; takes the request, the endpoint of the manager, and what closes it.
        arguments: Descriptor of the socket to the manager, and that endpoint.
    """
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # meant for the manager, which says when to end
    with open("/proc/self/comm", "w", encoding="ascii") as comm:
        comm.write(SERVANT)
    descriptor, inner = arguments
    manager = socket.socket(fileno=int(descriptor))
    for line in manager.makefile("r", encoding="utf-8"):
        with ExitStack() as stack:
            try:
                open_(line.rstrip("\n"), inner, stack)
            except RtkitError as error:
                manager.sendall(" ".join(str(error).split()).encode() + b"\n")
                continue
            manager.sendall(f"{READY}\n".encode())
            manager.recv(1)  # nothing comes but the end
        return


if __name__ == "__main__":
    serve_manager(open_at, sys.argv[1:])
    os._exit(0)  # threads of zenoh must not keep the process
