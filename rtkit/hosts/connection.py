"""Connection to another host over SSH (paramiko), as OpenSSH's own files of the user say.

Keys of hosts are looked up in the user's and the machine's ``known_hosts``; an unknown one is
refused with its fingerprint, a changed one always.
"""

from __future__ import annotations

import base64
import hashlib
import logging
import os
import shlex
import socket
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple

import paramiko

from rtkit.closing import Closing
from rtkit.errors import Refused, Unreachable
from rtkit.hosts.host import Host
from rtkit.hosts.ssh_config import SshRoute, way_to
from rtkit.link.threads import start_thread

if TYPE_CHECKING:
    from paramiko.channel import Channel

logging.getLogger("paramiko").setLevel(logging.CRITICAL)  # its errors are raised here, too
TIMEOUT_S = 10.0
_MOST = 16 << 20
"""How much a command on another host may write [bytes]."""
_PING_S = 0.5
_SILENT_S = 1.5
"""How often the far side is asked whether it is there, and how long it may be silent [s]."""


class Done(NamedTuple):
    """Outcome of a command on another host."""

    status: int
    out: str
    err: str


class HostConnection(Closing):
    """An open connection to a host.

    Attributes:
        host: Where it leads.
    """

    def __init__(
        self, host: Host, client: paramiko.SSHClient, through: HostConnection | None
    ) -> None:
        self.host = host
        self._client = client
        self._through = through

    def close(self) -> None:
        """End it, with what still runs over it."""
        self._client.close()
        if self._through is not None:
            self._through.close()

    @property
    def transport(self) -> paramiko.Transport:
        """The transport of paramiko.

        Raises:
            Unreachable: It has ended.
        """
        transport = self._client.get_transport()
        if transport is None or not transport.is_active():
            raise Unreachable(f"the connection to {self.host.name} has ended")
        return transport

    def run(
        self, command: Sequence[str] | str, data: bytes = b"", timeout_s: float = TIMEOUT_S
    ) -> Done:
        """Run a command there, words or a line for the shell; return its status and texts.

        Raises:
            Unreachable: The connection ended, or it took longer than `timeout_s` [s].
            Refused: It writes too much.
        """
        channel = self.open(command)
        try:
            until = time.monotonic() + timeout_s
            if data:
                start_thread(lambda: _feed(channel, data), "ssh input")
            else:
                channel.shutdown_write()
            errors: list[bytes] = []

            def read_errors() -> None:
                with suppress(OSError, Refused):  # its status tells more
                    errors.append(read_all(channel, channel.recv_stderr, until))

            reading = start_thread(read_errors, "ssh errors")
            out = read_all(channel, channel.recv, until)
            reading.join(max(0.0, until - time.monotonic()))
            if not channel.status_event.wait(max(0.0, until - time.monotonic())):
                raise TimeoutError
            texts = [each.decode("utf-8", "replace") for each in (out, b"".join(errors))]
            return Done(channel.recv_exit_status(), *texts)
        except (TimeoutError, paramiko.SSHException, OSError) as error:
            what = command if isinstance(command, str) else shlex.join(command)
            raise Unreachable(
                f"{self.host.name}: no end of {what.split()[0]} in {timeout_s:g} s"
                if isinstance(error, TimeoutError)
                else f"{self.host.name}: {error}"
            ) from error
        finally:
            channel.close()

    def open(self, command: Sequence[str] | str) -> Channel:
        """Start a command there, and return its input and output.

        Raises:
            Unreachable: The connection ended, or nothing can be started.
        """
        line = command if isinstance(command, str) else shlex.join(command)
        try:
            channel = self.transport.open_session(timeout=TIMEOUT_S)
            channel.exec_command(line)
        except (paramiko.SSHException, OSError) as error:
            raise Unreachable(f"{self.host.name}: {error}") from error
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

    def sftp(self) -> paramiko.SFTPClient:
        """Open a channel for files.

        Raises:
            Unreachable: The connection ended, or its sshd has no SFTP.
        """
        try:
            files = paramiko.SFTPClient.from_transport(self.transport)
        except (paramiko.SSHException, OSError) as error:
            raise Unreachable(f"{self.host.name}: no SFTP: {error}") from error
        assert files is not None
        return files

    def await_silence(self) -> str:
        """Ask again and again whether the far side is there; return why it is not any more."""
        import threading

        while True:
            answered = threading.Event()

            def ask(answered: threading.Event = answered) -> None:
                with suppress(paramiko.SSHException, OSError):
                    self.transport.global_request("keepalive@openssh.com", wait=True)
                    answered.set()

            start_thread(ask, "ping")
            if not answered.wait(_SILENT_S):
                return f"no answer in {_SILENT_S:g} s"
            transport = self._client.get_transport()
            if transport is None or not transport.is_active():
                return "the connection has ended"
            threading.Event().wait(_PING_S)


def connect(host: Host, timeout_s: float = TIMEOUT_S) -> HostConnection:
    """Connect to a host, through others where OpenSSH's file says so.

    Raises:
        Unreachable: Nobody answers there in time [s], or it is no sshd.
        Refused: The key of the host is unknown or has changed, or nobody of this user is let in.
    """
    return _connect(host, way_to(host), timeout_s)


def _connect(host: Host, way: SshRoute, timeout_s: float) -> HostConnection:
    through = _connect(host, way.through, timeout_s) if way.through is not None else None
    client = paramiko.SSHClient()
    for file in way.known_hosts:
        if os.path.exists(file):
            client.load_host_keys(file)
    client.set_missing_host_key_policy(_Unknown(host, way))
    try:
        sock = _through(through, way, timeout_s) if through is not None else None
        client.connect(
            way.address,
            way.port,
            way.user,
            key_filename=[*way.identities] or None,  # type: ignore[arg-type]
            timeout=timeout_s,
            banner_timeout=timeout_s,
            auth_timeout=timeout_s,
            channel_timeout=timeout_s,
            allow_agent=way.uses_agent,
            look_for_keys=not way.identities,
            sock=sock,
        )
    except BaseException as error:
        client.close()
        if through is not None:
            through.close()
        raise _explained(host, way, error) from error
    transport = client.get_transport()
    assert transport is not None
    if isinstance(transport.sock, socket.socket):
        transport.sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return HostConnection(host, client, through)


def _through(through: HostConnection, way: SshRoute, timeout_s: float) -> Channel:
    return through.transport.open_channel(
        "direct-tcpip", (way.address, way.port), ("localhost", 0), timeout=timeout_s
    )


class _Unknown(paramiko.MissingHostKeyPolicy):
    """Refuses hosts whose key is not known."""

    def __init__(self, host: Host, way: SshRoute) -> None:
        self._host = host
        self._way = way

    def missing_host_key(
        self, client: paramiko.SSHClient, hostname: str, key: paramiko.PKey
    ) -> None:
        name, found = self._host.name, fingerprint(key)
        raise Refused(
            f"{name}: the key of {self._way.place} is not known: {key.get_name()} {found};"
            f" if that is it: rthost accept {name} {found}"
        )


def fingerprint(key: paramiko.PKey) -> str:
    """Return the fingerprint of a key as OpenSSH shows it."""
    digest = hashlib.sha256(key.asbytes()).digest()
    return "SHA256:" + base64.b64encode(digest).decode("ascii").rstrip("=")


def _explained(host: Host, way: SshRoute, error: BaseException) -> BaseException:
    """Return what a failure means to a user; what is none of the connection, as it is."""
    where = f"{host.name} ({way.place})"
    if isinstance(error, paramiko.BadHostKeyException):
        return Refused(
            f"{where}: its key has changed: {error.key.get_name()} {fingerprint(error.key)},"
            f" known is {fingerprint(error.expected_key)}. Somebody may be in between; nothing"
            " was sent"
        )
    if isinstance(error, paramiko.AuthenticationException):
        return Refused(f"{where}: user {way.user} is not let in: {_text(error)}")
    if isinstance(error, TimeoutError):
        return Unreachable(f"{where}: no answer in time")
    if isinstance(error, paramiko.SSHException | OSError | EOFError) and not isinstance(
        error, Unreachable
    ):
        return Unreachable(f"{where}: {_text(error)}")
    return error


def _text(error: BaseException) -> str:
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return " ".join(str(text).split()).rstrip(".")


def _feed(channel: Channel, data: bytes) -> None:
    with suppress(OSError):  # then its status tells why it wanted no more
        channel.sendall(data)
        channel.shutdown_write()


def read_all(channel: Channel, receive: Callable[[int], bytes], until: float) -> bytes:
    """Return what comes to its end; who sends it can neither go on for ever nor fill the memory.

    Raises:
        TimeoutError: It has not ended in time, by the monotonic clock [s].
        Refused: It is more than `_MOST`.
    """
    found = bytearray()
    while True:
        channel.settimeout(max(0.001, until - time.monotonic()))
        data = receive(1 << 16)
        if not data:
            return bytes(found)
        found += data
        if len(found) > _MOST:
            raise Refused(f"a host writes more than {_MOST >> 20} MiB")
