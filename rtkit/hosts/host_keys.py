"""Keys of hosts: accepted by their fingerprints into the user's ``known_hosts``."""

from __future__ import annotations

import os
import socket

import paramiko

from rtkit.errors import Refused, Unreachable
from rtkit.hosts.connection import fingerprint
from rtkit.hosts.host import Host
from rtkit.hosts.ssh_config import way_to


def accept(host: Host, expected: str, timeout_s: float) -> str:
    """Write the key of a host to the user's file, if it has that fingerprint; return the file.

    Raises:
        Refused: It has another one, or another key of that host is known.
        Unreachable: It does not answer.
    """
    way = way_to(host)
    keys = paramiko.HostKeys()
    for file in way.known_hosts:
        if os.path.exists(file):
            keys.load(file)
    key = _key(host, timeout_s)
    found = fingerprint(key)
    if found != expected.strip():
        raise Refused(f"{host.name}: its key has another fingerprint: {key.get_name()} {found}")
    known = keys.lookup(way.place)
    if known is not None and key.get_name() in known:
        if known[key.get_name()] == key:
            return way.known_hosts[0]
        raise Refused(
            f"{host.name}: another key of {way.place} is known:"
            f" {fingerprint(known[key.get_name()])}; if that was replaced there, remove it first:"
            f" ssh-keygen -R {way.place}"
        )
    path = way.known_hosts[0]
    os.makedirs(os.path.dirname(path), mode=0o700, exist_ok=True)
    with open(path, "a+b") as stream:
        stream.seek(max(0, stream.seek(0, os.SEEK_END) - 1))
        start = b"\n" if stream.read() not in (b"", b"\n") else b""  # its last line may be open
        stream.write(start + f"{way.place} {key.get_name()} {key.get_base64()}\n".encode())
    return path


def _key(host: Host, timeout_s: float) -> paramiko.PKey:
    """Return the key that a host shows; nothing else is sent there."""
    way = way_to(host)
    try:
        if way.through is not None:
            raise Refused(f"{host.name}: accept the keys of hosts in between with ssh")
        sock = socket.create_connection((way.address, way.port), timeout_s)
        transport = paramiko.Transport(sock)
        try:
            transport.start_client(timeout=timeout_s)
            return transport.get_remote_server_key()
        finally:
            transport.close()
    except (OSError, paramiko.SSHException) as error:
        raise Unreachable(f"{host.name} ({way.place}): {error}") from error
