"""Connection to another host over SSH (paramiko), as OpenSSH's own files of the user say.

Keys of hosts are looked up in the user's and the machine's ``known_hosts``; an unknown one is
refused with its fingerprint, a changed one always.
"""

from __future__ import annotations

import logging
import shlex
import socket
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import TYPE_CHECKING

from rtkit.closing import Closing
from rtkit.errors import RtkitError, Unreachable
from rtkit.hosts.host import Host
from rtkit.hosts.known_hosts import KnownKeys
from rtkit.hosts.silence import await_silence, longest_silence, packet_silence
from rtkit.hosts.ssh_config import SshRoute, way_to
from rtkit.hosts.ssh_library import paramiko
from rtkit.hosts.ssh_login import log_in

if TYPE_CHECKING:
    from paramiko.channel import Channel

logging.getLogger("paramiko").setLevel(logging.CRITICAL)  # its errors are raised here, too
TIMEOUT_S = 10.0
_THIN_LINEAR_TIMEOUTS = 16
"""Option of Linux for streams of little data."""


class HostConnection(Closing):
    """An open connection to a host.

    Attributes:
        host: Where it leads.
        longest_silence_s: How long the far side may be silent until it is given up [s].
    """

    def __init__(
        self,
        host: Host,
        transport: paramiko.Transport,
        through: HostConnection | None,
        round_trip_s: float,
    ) -> None:
        self.host = host
        self.longest_silence_s = longest_silence(round_trip_s)
        self._transport = transport
        self._through = through

    def close(self) -> None:
        """End it, with what still runs over it."""
        self._transport.close()
        if self._through is not None:
            self._through.close()

    @property
    def transport(self) -> paramiko.Transport:
        """The transport of paramiko.

        Raises:
            Unreachable: It has ended.
        """
        if not self._transport.is_active():
            raise Unreachable(f"the connection to {self.host.name} has ended")
        return self._transport

    def open(self, command: Sequence[str] | str) -> Channel:
        """Start a command there, and return its input and output.

        Raises:
            Unreachable: The connection ended, or nothing can be started.
        """
        line = command if isinstance(command, str) else shlex.join(command)
        try:
            channel = self.transport.open_session(timeout=TIMEOUT_S)
            channel.exec_command(line)
        except (paramiko.SSHException, EOFError, OSError) as error:
            raise Unreachable(f"{self.host.name}: {_text(error)}") from error
        return channel

    def ping(self) -> float:
        """Return how long a question to its sshd takes [s].

        Raises:
            Unreachable: It did not answer.
        """
        began = time.monotonic()
        transport = self.transport
        transport.global_request("keepalive@openssh.com", wait=True)
        if not transport.is_active():
            raise Unreachable(f"the connection to {self.host.name} has ended")
        return time.monotonic() - began

    def await_silence(self, silence_s: Callable[[], float]) -> str:
        """See `rtkit.hosts.silence.await_silence`."""
        end = self._transport.sock  # through another host it is no socket: only answers tell
        packet_silence_s = partial(packet_silence, end)
        return await_silence(self.ping, self.longest_silence_s, silence_s, packet_silence_s)


def connect(host: Host, timeout_s: float = TIMEOUT_S) -> HostConnection:
    """Connect to a host, through others where OpenSSH's file says so.

    Raises:
        Unreachable: Nobody answers there in time [s], or it is no sshd.
        Refused: The key of the host is unknown or has changed, or nobody of this user is let in.
    """
    return _connect(host, way_to(host), time.monotonic() + timeout_s)


def shake_hands(host: Host, way: SshRoute, timeout_s: float) -> HostConnection:
    """Connect to a host, and verify its key; nobody is logged in there yet.

    Raises:
        UnknownKey: None of its keys is known, or none of a host in between.
        Refused: Its key is another one, or revoked.
        Unreachable: Nobody answers there in time [s], or it is no sshd.
    """
    return _shake_hands(host, way, time.monotonic() + timeout_s)


def _connect(host: Host, way: SshRoute, deadline: float) -> HostConnection:
    connection = _shake_hands(host, way, deadline)
    with _explained(host, way, connection):
        connection.transport.auth_timeout = _left_s(deadline)
        log_in(connection.transport, way, f"{host.name} ({way.place})")
    return connection


def _shake_hands(host: Host, way: SshRoute, deadline: float) -> HostConnection:
    known = KnownKeys(way)
    through = _connect(host, way.through, deadline) if way.through is not None else None
    with _explained(host, way, through):
        began = time.monotonic()
        end = _socket(through, way, _left_s(deadline))
        round_trip_s = time.monotonic() - began  # of the first packet, and of its answer
        transport = paramiko.Transport(end)
    connection = HostConnection(host, transport, through, round_trip_s)
    with _explained(host, way, connection):
        options = transport.get_security_options()
        options.key_types = known.preferred(options.key_types)
        agreed = threading.Event()
        transport.start_client(event=agreed)
        if not agreed.wait(_left_s(deadline)):
            raise TimeoutError
        if not transport.is_active():
            raise transport.get_exception() or paramiko.SSHException("it ended the connection")
        known.check(host, transport.get_remote_server_key())
    return connection


def _socket(
    through: HostConnection | None, way: SshRoute, timeout_s: float
) -> socket.socket | Channel:
    place = (way.address, way.port)
    if through is not None:
        try:
            return through.transport.open_channel(
                "direct-tcpip", place, ("localhost", 0), timeout=timeout_s
            )
        except paramiko.ChannelException as error:
            between = through.transport.getpeername()[0]
            raise paramiko.SSHException(f"{between}, in between: {error.text}") from error
    found = _PromptSocket(fileno=socket.create_connection(place, timeout_s).detach())
    found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with suppress(OSError):  # what is lost is sent again at even intervals, not ever later
        found.setsockopt(socket.IPPROTO_TCP, _THIN_LINEAR_TIMEOUTS, 1)
    return found


class _PromptSocket(socket.socket):
    """Acknowledges at once what it hears: until a command runs there, an sshd waits for that.

    Its kernel keeps a small answer back while one before is not acknowledged (Nagle), which the one
    here would do 40 ms later.
    """

    def recv(self, size: int, flags: int = 0, /) -> bytes:
        data = super().recv(size, flags)
        self.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
        return data


def _left_s(deadline: float) -> float:
    return max(deadline - time.monotonic(), 0.001)


@contextmanager
def _explained(host: Host, way: SshRoute, opened: HostConnection | None) -> Iterator[None]:
    """Say what a failure means to a user, and close what was opened before it."""
    try:
        yield
    except BaseException as error:
        if opened is not None:
            opened.close()
        where = f"{host.name} ({way.place})"
        if isinstance(error, TimeoutError):
            raise Unreachable(f"{where}: no answer in time") from error
        if isinstance(error, paramiko.SSHException | OSError | EOFError) and not isinstance(
            error, RtkitError
        ):
            raise Unreachable(f"{where}: {_text(error)}") from error
        raise


def _text(error: BaseException) -> str:
    if isinstance(error, paramiko.SSHException) and "banner" in str(error):
        return "no SSH server answers there, or it hung up at once"
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(text).split()).rstrip(".")
