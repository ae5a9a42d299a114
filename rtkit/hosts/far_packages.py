"""Packages of other hosts: pushed over SSH with all that they need, listed, removed.

What is pushed is a bundle without a system: the far side compares each byte, and asks no index.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence

from rtkit.errors import Malformed, Refused
from rtkit.fast_dataclass import Record
from rtkit.hosts import far_program, provisioned
from rtkit.hosts.connection import HostConnection
from rtkit.packages import bundle
from rtkit.packages.installed import Installed
from rtkit.rtc.serde import decode_text

_FAR_S = 60.0


class _Package(Record):
    """Package as `rtkit.hosts.far_packager` tells it."""

    name: str
    version: str
    path: str
    types: tuple[str, ...]
    requires: tuple[str, ...]
    wheels: Mapping[str, str]


class _Answer(Record):
    """Answer of `rtkit.hosts.far_packager`."""

    packages: tuple[_Package, ...] = ()
    error: str = ""


def push(connection: HostConnection, packages: Mapping[str, Sequence[str]]) -> list[Installed]:
    """Install packages on a host, their wheels by ``NAME==VERSION``; what is there is left.

    Raises:
        Refused: A wheel does not fit there, or its bytes were lost on the way; names the host.
        Unreachable: The connection ended; each package is there as a whole, or not at all.
    """
    with tempfile.TemporaryDirectory(prefix="rtpkg-") as folder:
        path = os.path.join(folder, f"push{bundle.SUFFIX}")
        bundle.write(path, b"", packages)
        with open(path, "rb") as stream:
            return _ask(connection, stream.read(), "install")


def push_bundle(connection: HostConnection, path: str) -> list[Installed]:
    """Install all packages of a bundle on a host; see `push`."""
    with bundle.unpacked(path) as found:
        files = {
            name: [os.path.join(found.wheels, each) for each in wheels]
            for name, wheels in found.packages.items()
        }
        return push(connection, files)


def listed(connection: HostConnection) -> list[Installed]:
    """Return what is installed on a host."""
    return _ask(connection, b"", "list")


def remove(connection: HostConnection, names: Sequence[str], *, is_forced: bool) -> list[Installed]:
    """Remove packages of a host, ``NAME`` or ``NAME==VERSION``; return them.

    Raises:
        NotFound: One is not installed.
        Refused: A manager there uses one.
    """
    return _ask(connection, b"", "remove" if is_forced else "uninstall", *names)


def _ask(connection: HostConnection, data: bytes, *words: str) -> list[Installed]:
    name = connection.host.name
    command = [*provisioned.python(connection), "-m", "rtkit.hosts.far_packager", *words]
    try:
        text = far_program.ask(connection, command, data, timeout_s=_FAR_S)
        found = decode_text(_Answer, text)
    except Malformed as error:
        raise Malformed(f"{name}: {words[0]}: {error}") from None
    except Refused as error:
        hint = f"rtmgr start --host {name} brings this rtkit there"
        raise Refused(f"{name}: {words[0]}: {error} ({hint})") from None
    if found.error:
        raise Refused(f"{name}: {found.error}")
    return [
        Installed(each.name, each.version, each.path, each.types, each.requires, {**each.wheels})
        for each in found.packages
    ]
