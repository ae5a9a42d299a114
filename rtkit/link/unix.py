"""Connects unix sockets to processes of this user only; the kernel identifies the peer.

Only datagrams to a service manager go to another user.
"""

from __future__ import annotations

import _socket
import errno
import os
import struct
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import socket

_PEER = struct.Struct("3i")


def connect(
    path: str, timeout_s: float | None = None, *, keeps_packets: bool = False
) -> socket.socket:
    """Connect to the unix socket of a process of this user; one may keep the bounds of packets.

    Raises:
        PermissionError: A process of another user listens there: nothing is sent to it.
        OSError: Nobody does.
    """
    end = _made(keeps_packets=keeps_packets)
    try:
        end.settimeout(timeout_s)
        end.connect(path)
        if user_of(end) != os.getuid():
            raise PermissionError(errno.EACCES, "another user listens there", path)
    except BaseException:
        end.close()
        raise
    return end


def connect_to_manager(path: str, timeout_s: float) -> _socket.socket:
    """Connect to a socket of a manager, in a folder that is known to be trusted.

    It has no more than the interpreter gives: the module ``socket`` takes longer to import than a
    command takes to ask (decision 99).

    Raises:
        OSError: Nobody listens there, or lets it in in time.
    """
    end = _socket.socket(_socket.AF_UNIX, _socket.SOCK_STREAM)
    try:
        end.settimeout(timeout_s)
        end.connect(path)
    except BaseException:
        end.close()
        raise
    return end


def listen(path: str, *, keeps_packets: bool = False, backlog: int = 1) -> socket.socket:
    """Listen on a unix socket, in the place of one that is left there.

    So many may wait for being let in at a time.

    Raises:
        OSError: It cannot be made.
    """
    with suppress(FileNotFoundError):
        os.unlink(path)
    end = _made(keeps_packets=keeps_packets)
    try:
        end.bind(path)
        end.listen(backlog)
    except BaseException:
        end.close()
        raise
    return end


def send_datagram(address: str, data: bytes, timeout_s: float) -> None:
    """Send a datagram to the service manager at an address; an ``@`` begins an abstract one.

    It is whoever started this process and named its address, mostly root; with a time-out of 0
    it is sent at once or not at all.

    Raises:
        OSError: Nobody takes it in time.
    """
    import socket

    place = "\0" + address[1:] if address.startswith("@") else address
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as end:
        end.settimeout(timeout_s)
        end.sendto(data, place)


def is_answering(path: str) -> bool:
    """Return whether a process listens on a unix socket, be it of another user."""
    try:
        connect(path).close()
    except PermissionError:
        return True
    except OSError:
        return False
    return True


def pid_of(end: _socket.socket) -> int:
    """Return the pid of the process at the other end of a unix socket."""
    return _peer(end)[0]


def user_of(end: _socket.socket) -> int:
    """Return the uid of the process at the other end of a unix socket."""
    return _peer(end)[1]


def _made(*, keeps_packets: bool) -> socket.socket:
    import socket

    return socket.socket(
        socket.AF_UNIX, socket.SOCK_SEQPACKET if keeps_packets else socket.SOCK_STREAM
    )


def _peer(end: _socket.socket) -> tuple[int, int]:
    asked = end.getsockopt(_socket.SOL_SOCKET, _socket.SO_PEERCRED, _PEER.size)
    pid, uid, _ = _PEER.unpack(asked)
    return pid, uid
