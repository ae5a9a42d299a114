"""Serves the TCP port of a manager in a process of its own, until the manager is gone.

`rtkit.manager.endpoint_supervisor` starts it.

The process receives the port to open on a socket, as ``PORT SECRET_FILE``, and answers ``ready``,
or the error; then it may receive another one. It exits when the socket closes.
"""

from __future__ import annotations

import os
import signal
import socket
import sys

from rtkit.errors import Unreachable
from rtkit.link.port_holders import SERVANT
from rtkit.link.tcp_endpoint import open_endpoint

READY = "ready"


def main() -> None:
    """Be the process."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)  # meant for the manager, who says when to end
    with open("/proc/self/comm", "w", encoding="ascii") as comm:
        comm.write(SERVANT)
    descriptor, inner = sys.argv[1:]
    manager = socket.socket(fileno=int(descriptor))
    for line in manager.makefile("r", encoding="utf-8"):
        port, _, secret_file = line.rstrip("\n").partition(" ")
        try:
            session = open_endpoint(int(port), inner, secret_file)
        except Unreachable as error:
            manager.sendall(" ".join(str(error).split()).encode() + b"\n")
            continue
        manager.sendall(f"{READY}\n".encode())
        manager.recv(1)  # nothing comes but the end
        session.close()  # type: ignore[no-untyped-call]
        return


if __name__ == "__main__":
    main()
    os._exit(0)  # threads of zenoh must not keep the process
