"""Opens the TCP endpoint of a manager, or reports why there is none."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.errors import Refused, Unreachable
from rtkit.link import ports, secret, tcp_endpoint
from rtkit.manager.processes.tcp_endpoint import TcpEndpoint, end_orphan
from rtkit.settings.configuration import TcpEndpointSettings

_TRIES = 5


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
        if not tcp_endpoint.is_free(port) and not _end_orphan(port, inner):
            break
        try:
            endpoint.open(port, secret_file)
        except Unreachable:
            if tcp_endpoint.is_free(port):
                raise  # it is not the port that is to blame
            if wanted.port:
                break
        else:
            return port
    endpoint.close()
    why = f"port {port} is in use by {ports.port_holder(port) or 'somebody'}"
    if wanted.is_asked:
        raise Refused(f"{why}; choose another one with -p, or none with -a")
    warn(f"{why}: this manager has no TCP port; -p gives it one of its own, -a does without")
    return 0


def _end_orphan(port: int, inner: str) -> bool:
    """End what an earlier manager of this name left at a port; return whether it is free now."""
    holder = ports.listener(port)
    return holder is not None and end_orphan(holder.pid, inner) and tcp_endpoint.is_free(port)
