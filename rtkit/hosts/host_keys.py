"""Keys of hosts: accepted by their fingerprints into the user's ``known_hosts``."""

from __future__ import annotations

import os

from rtkit.errors import Refused
from rtkit.hosts.connection import shake_hands
from rtkit.hosts.host import Host
from rtkit.hosts.known_hosts import UnknownKey, fingerprint
from rtkit.hosts.ssh_config import SshRoute, way_to
from rtkit.hosts.ssh_library import paramiko
from rtkit.link import places


def accept(host: Host, expected: str, timeout_s: float) -> str:
    """Write the key of a host to the user's file, if it has that fingerprint; return the file.

    Is the key of a host in between not known, it is the one that is meant.

    Raises:
        Refused: It has another one, is revoked, or another key of that host is known.
        Unreachable: It does not answer.
    """
    way = way_to(host)
    try:
        with shake_hands(host, way, timeout_s) as shaken:
            key, is_known = shaken.transport.get_remote_server_key(), True
    except UnknownKey as error:
        way, key, is_known = error.way, error.key, False
    found = fingerprint(key)
    if found != expected.strip():
        raise Refused(
            f"{host.name}: the key of {way.place} has another fingerprint: {key.get_name()} {found}"
        )
    if not is_known:
        _append(way, key)
    return way.known_hosts[0]


def _append(way: SshRoute, key: paramiko.PKey) -> None:
    """Write a line at once: whoever else writes there loses nothing, nor does a kill."""
    name = paramiko.HostKeys.hash_host(way.place) if way.hashes_names else way.place
    path = way.known_hosts[0]
    try:
        places.make_folders(os.path.dirname(path))
        with open(path, "a+b", opener=lambda file, flags: os.open(file, flags, 0o600)) as stream:
            stream.seek(max(0, stream.seek(0, os.SEEK_END) - 1))
            end = b"" if stream.read(1) in (b"", b"\n") else b"\n"
            stream.write(end + f"{name} {key.get_name()} {key.get_base64()}\n".encode())
    except OSError as error:
        raise Refused(f"cannot write {path}: {error.strerror}") from error
