"""Keys of hosts as OpenSSH's ``known_hosts`` files tell them, and what to think of one shown."""

from __future__ import annotations

import base64
import binascii
import fnmatch
import hashlib
from collections.abc import Sequence
from typing import NamedTuple

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.hosts.host import Host
from rtkit.hosts.ssh_config import SshRoute
from rtkit.hosts.ssh_library import paramiko
from rtkit.settings.reading import read_private

_RSA = ("rsa-sha2-512", "rsa-sha2-256")
_REVOKED, _AUTHORITY = "@revoked", "@cert-authority"


class UnknownKey(Refused):
    """A host shows a key, and no key of it is known."""

    def __init__(self, host: Host, way: SshRoute, key: paramiko.PKey, remark: str) -> None:
        self.way = way
        self.key = key
        found = fingerprint(key)
        super().__init__(
            f"{host.name}: the key of {way.place} is not known: {key.get_name()} {found}{remark};"
            f" if that is it: rthost accept {host.name} {found}"
        )


class KnownKey(NamedTuple):
    """Line about a host: its marker, the type of the key and its bytes, file and line."""

    marker: str
    kind: str
    data: bytes
    where: str


class KnownKeys:
    """Keys that are known of the host at the end of a way.

    Raises:
        Malformed: A line makes no sense; tells file and line.
        Refused: A stranger can have written a file.
    """

    def __init__(self, way: SshRoute) -> None:
        self._way = way
        self._lines: list[KnownKey] = []
        for path in way.known_hosts:
            if path != "/dev/null":
                self._lines += _read(path, way.place)

    def preferred(self, kinds: Sequence[str]) -> tuple[str, ...]:
        """Return the algorithms for keys, those of known keys first: that one is to be shown."""
        known = {kind for line in self._lines if not line.marker for kind in _algorithms(line.kind)}
        return tuple(sorted(kinds, key=lambda kind: kind not in known))

    def check(self, host: Host, key: paramiko.PKey) -> None:
        """Return if a key is known.

        Raises:
            UnknownKey: No key of the host is.
            Refused: It is revoked, or the host is known by another one.
        """
        data, where = key.asbytes(), f"{host.name} ({self._way.place})"
        for line in self._lines:
            if line.marker == _REVOKED and line.data == data:
                raise Refused(
                    f"{where}: its key is revoked ({line.where}): {key.get_name()}"
                    f" {fingerprint(key)}; nothing was sent"
                )
        known = [line for line in self._lines if not line.marker]
        if any(line.data == data for line in known):
            return
        if known:
            best = next((line for line in known if line.kind == key.get_name()), known[0])
            raise Refused(
                f"{where}: its key has changed: {key.get_name()} {fingerprint(key)}, known is"
                f" {best.kind} {_digest(best.data)} ({best.where}). Somebody may be in between;"
                " nothing was sent. If the key was replaced there: ssh-keygen -R"
                f" '{self._way.place}'"
            )
        authorities = [line.where for line in self._lines if line.marker == _AUTHORITY]
        remark = f" (@cert-authority in {authorities[0]} does not count)" if authorities else ""
        raise UnknownKey(host, self._way, key, remark)


def fingerprint(key: paramiko.PKey) -> str:
    """Return the fingerprint of a key as OpenSSH shows it."""
    return _digest(key.asbytes())


def _digest(data: bytes) -> str:
    return "SHA256:" + base64.b64encode(hashlib.sha256(data).digest()).decode("ascii").rstrip("=")


def _algorithms(kind: str) -> tuple[str, ...]:
    return _RSA if kind == "ssh-rsa" else (kind,)


def _read(path: str, place: str) -> list[KnownKey]:
    try:
        text = read_private(path, must_be_ours=True).decode("utf-8", "replace")
    except NotFound:
        return []
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        where = f"{path}:{number}"
        marker = words.pop(0) if words[0].startswith("@") else ""
        try:
            if marker not in ("", _REVOKED, _AUTHORITY):
                raise ValueError(f"unknown marker {marker}")
            names, kind, key, *_ = words
            data = base64.b64decode(key, validate=True)
            if data[4 : 4 + len(kind)] != kind.encode() and not kind.isdigit():
                raise ValueError(f"the key is not one of {kind}")
            if _is_named(place, names):
                found.append(KnownKey(marker, kind, data, where))
        except (ValueError, AssertionError, IndexError, binascii.Error) as error:
            why = "NAMES TYPE KEY is expected" if len(words) < 3 else str(error)
            raise Malformed(f"{where}: cannot be read: {why}") from error
    return found


def _is_named(place: str, names: str) -> bool:
    is_found = False
    for name in names.split(","):
        if name.startswith("|"):
            is_found |= paramiko.HostKeys.hash_host(place, name) == name
            continue
        pattern = name.lower().removeprefix("!").replace("[", "[[]")
        if fnmatch.fnmatchcase(place, pattern):
            if name.startswith("!"):
                return False
            is_found = True
    return is_found
