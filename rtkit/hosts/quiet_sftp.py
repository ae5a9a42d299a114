"""Channel for files on another host, also where the shell of its user writes lines of its own."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rtkit.errors import Unreachable
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.ssh_library import paramiko

if TYPE_CHECKING:
    from paramiko.channel import Channel

_VERSION = re.compile(rb"\0\0..\x02\0\0\0\x03", re.DOTALL)
"""First packet of a server of SFTP version 3: its length, kind and version."""
_MOST = 1 << 16
"""How much may come before [bytes]."""


class _Quiet:
    """A channel without what comes before the first packet."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._kept: bytes | None = None

    def __getattr__(self, name: str) -> object:
        return getattr(self._channel, name)

    def recv(self, size: int) -> bytes:
        if self._kept is None:
            self._kept = self._first()
        if self._kept:
            found, self._kept = self._kept[:size], self._kept[size:]
            return found
        return self._channel.recv(size)

    def _first(self) -> bytes:
        text = b""
        while not (found := _VERSION.search(text)):
            data = self._channel.recv(1 << 12)
            text += data
            if not data or len(text) > _MOST:
                return b""
        return text[found.start() :]


def open_sftp(connection: HostConnection, timeout_s: float) -> paramiko.SFTPClient:
    """Open a channel for files, on which nothing may be silent for longer than `timeout_s` [s].

    Raises:
        Unreachable: The connection ended, or its sshd has no SFTP.
    """
    transport = connection.transport
    try:
        channel = transport.open_session(timeout=timeout_s)
        channel.settimeout(timeout_s)
        channel.invoke_subsystem("sftp")
        return paramiko.SFTPClient(_Quiet(channel))  # type: ignore[arg-type]
    except (paramiko.SSHException, EOFError, OSError) as error:
        raise Unreachable(f"{connection.host.name}: no SFTP: {error}") from error
