"""Looks at a host: its Python and the wheels that fit it, room, clock, and what it lacks."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, Refused
from rtkit.fast_dataclass import Record, field
from rtkit.hosts import far_program
from rtkit.packages.wheel_target import WheelKind, WheelTarget
from rtkit.rtc.serde import decode_text

if TYPE_CHECKING:
    from rtkit.hosts.connection import HostConnection

OLDEST = (3, 11)
_KIND = re.compile(r"[A-Za-z0-9_]{1,32} [0-9]{1,3}\.[0-9]{1,3}")
_DISTRIBUTION = re.compile(r"(\w[\w.]{0,99})-(\w[\w.+!]{0,99})\.dist-info")
_ROOM = 300 << 20
"""How much room a version of rtkit takes at most [bytes]."""
_LOOK_S = 10.0


class FarSide(Record):
    """Host as its own Python sees it; sizes in bytes, time in seconds since 1970.

    Attributes:
        damaged: Files that are gone or changed, the first ones, by the version of rtkit.
    """

    python: tuple[int, ...]
    implementation: str
    abi: str
    machine: str
    libc: tuple[str, ...]
    has_venv: bool
    home: str
    hostname: str
    user: str
    has_linger: bool
    has_systemd: bool
    free_bytes: int
    is_writable: bool
    memory_bytes: int
    processors: int
    time_s: float
    current: str
    distributions: tuple[str, ...] = ()
    devices: tuple[str, ...] = ()
    damaged: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def version(self) -> str:
        """Version of its Python, ``3.11``."""
        return ".".join(map(str, self.python[:2]))

    @property
    def damage(self) -> str:
        """Files of the version in use that are gone or changed; empty if it is as it was made."""
        return ", ".join(self.damaged.get(self.current, ()))

    @property
    def kind(self) -> WheelKind:
        """Kind of its wheels."""
        return WheelKind(self.version, self.machine, self.libc[1] if len(self.libc) > 1 else "")

    @property
    def target(self) -> WheelTarget:
        """Target that packages are chosen for: its kind, and what its rtkit brings along."""
        from packaging.utils import canonicalize_name

        pairs = (found for each in self.distributions if (found := _DISTRIBUTION.fullmatch(each)))
        return WheelTarget(self.kind, {canonicalize_name(found[1]): found[2] for found in pairs})

    def obstacles(self, *, needs_room: bool = True) -> list[str]:
        """Return why rtkit cannot be made there, a line each."""
        found = []
        if self.python[:2] < OLDEST:
            found.append(f"its Python is {self.version}, rtkit needs {'.'.join(map(str, OLDEST))}")
        if self.implementation != "cpython":
            found.append(f"its Python is {self.implementation}, not cpython")
        if self.libc[:1] != ("glibc",):
            found.append("its C library is not glibc, for which there are wheels")
        elif not _KIND.fullmatch(f"{self.machine} {self.kind.glibc}"):  # it is a name of a folder
            found.append(f"no machine with wheels: {self.machine}, glibc {self.kind.glibc}")
        if not self.has_venv:
            found.append("its Python has no module venv (Debian: apt install python3-venv)")
        if not self.is_writable:
            found.append(f"nothing can be written in {self.home}")
        if needs_room and self.free_bytes < _ROOM:
            free, needed = self.free_bytes >> 20, _ROOM >> 20
            found.append(f"{free} MiB are free in {self.home}, {needed} are needed")
        return found


def look(connection: HostConnection, devices: Sequence[str] = ()) -> FarSide:
    """Look at a host, and which of some devices it has.

    Raises:
        Refused: There is no Python.
        Malformed: What it answers makes no sense.
        Unreachable: The connection ended.
    """
    host = connection.host
    program = far_program.text_of("far_probe.py")
    command = [host.python, "-", far_program.MARK, *devices]
    try:
        return decode_text(
            FarSide, far_program.ask(connection, command, program, timeout_s=_LOOK_S)
        )
    except Refused as error:
        raise Refused(f"{host.name}: no Python there as {host.python}: {error}") from None
    except Malformed as error:
        raise Malformed(f"{host.name}: {host.python} says no sense: {error}") from error


def check(obstacles: list[str], name: str) -> None:
    """Refuse a host that does not do.

    Raises:
        Refused: Tells why, all of it.
    """
    if obstacles:
        raise Refused(f"{name}: {'; '.join(obstacles)}")
