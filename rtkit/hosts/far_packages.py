"""Packages of other hosts: pushed over SSH with all that they need, listed, surveyed, removed.

What is pushed is a bundle without a system: the far side compares each byte, and asks no index.
"""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from functools import partial
from typing import BinaryIO

from rtkit.errors import Malformed, Refused
from rtkit.hosts import far_program
from rtkit.hosts.connection import HostConnection
from rtkit.hosts.far_packager import PackageAnswer
from rtkit.hosts.progress import HostStep, Progress, unshown
from rtkit.packages import bundle
from rtkit.packages.installed import work_folder
from rtkit.packages.records import Question, Survey
from rtkit.rtc.serde import decode_text, encode_text

_FAR_S = 60.0


def push(
    connection: HostConnection,
    packages: Mapping[str, Sequence[str]],
    system: str = "",
    show: Progress = unshown,
) -> PackageAnswer:
    """Install packages on a host, their wheels by ``NAME==VERSION``; what is there is left.

    Args:
        connection: Leads to the host.
        packages: The wheels.
        system: For which a plan installs them.
        show: Is shown how much was sent.

    Raises:
        Refused: A wheel does not fit there, or its bytes were lost on the way; names the host.
        Unreachable: The connection ended; each package is there as a whole, or not at all.
    """
    with work_folder() as folder:
        path = os.path.join(folder, f"push{bundle.SUFFIX}")
        bundle.write(path, b"", packages)
        with _ShownFile(path, connection.host.name, show) as stream:
            return _ask(connection, stream, "install", system)


class _ShownFile(io.FileIO):
    """File of which is shown how much was read."""

    def __init__(self, path: str, host: str, show: Progress) -> None:
        super().__init__(path)
        self._size = os.path.getsize(path)
        self._show = partial(show, host)

    def read(self, size: int | None = -1, /) -> bytes:
        """Read some, and show that."""
        data = super().read(-1 if size is None else size)
        sending = HostStep("sending", self.tell(), self._size, "MB")
        self._show(sending if data else HostStep("installing"))
        return data


def push_bundle(connection: HostConnection, path: str, show: Progress = unshown) -> PackageAnswer:
    """Install all packages of a bundle on a host; see `push`."""
    with bundle.unpacked(path) as found:
        files = {
            name: [os.path.join(found.wheels, each) for each in wheels]
            for name, wheels in found.packages.items()
        }
        return push(connection, files, show=show)


def listed(connection: HostConnection) -> PackageAnswer:
    """Return what is installed on a host, with signatures."""
    return _ask(connection, io.BytesIO(), "list")


def surveyed(connection: HostConnection, asked: Question) -> Survey:
    """Return what the packages of a host are to a system."""
    return _ask(connection, io.BytesIO(encode_text(asked).encode()), "survey").survey


def remove(connection: HostConnection, names: Sequence[str], *, is_forced: bool) -> PackageAnswer:
    """Remove packages of a host, ``NAME`` or ``NAME==VERSION``; return them.

    Raises:
        NotFound: One is not installed.
        Refused: A manager there uses one.
    """
    word = "remove" if is_forced else "uninstall"
    return _ask(connection, io.BytesIO(), word, *names)


def _ask(connection: HostConnection, data: BinaryIO, *words: str) -> PackageAnswer:
    name = connection.host.name
    command = [*far_program.python(connection), "-m", "rtkit.hosts.far_packager", *words]
    try:
        text = far_program.ask(connection, command, data, timeout_s=_FAR_S)
        found = decode_text(PackageAnswer, text)
    except Malformed as error:
        raise Malformed(f"{name}: {words[0]}: {error}") from None
    except Refused as error:
        hint = f"rtmgr start --host {name} brings this rtkit there"
        raise Refused(f"{name}: {words[0]}: {error} ({hint})") from None
    if found.error:
        raise Refused(f"{name}: {found.error}")
    return found
