"""Devices of this host: files, mostly below /dev, that a path or a pattern names."""

from __future__ import annotations

import fnmatch
import os
from collections.abc import Iterable

from rtkit.fast_dataclass import Record


class HostFacts(Record):
    """Facts about a host by which places are chosen.

    Attributes:
        memory: Free memory [bytes].
        devices: Of the devices that were asked for those that are there.
        tags: Words of its manager's property ``rtkit.tags``.
    """

    memory: int = 0
    devices: tuple[str, ...] = ()
    tags: tuple[str, ...] = ()


def identity(device: str) -> str:
    """Return what tells one file behind a path or pattern from the next; empty for none.

    A device that goes and comes back between two looks has another inode.
    """
    folder, _, name = device.rpartition("/")
    if "*" not in name and "?" not in name:
        names = [name]
    else:
        try:
            names = sorted(fnmatch.filter(os.listdir(folder or "/"), name))
        except OSError:
            return ""
    for each in names:
        try:
            found = os.stat(f"{folder}/{each}")
        except OSError:  # a link that leads nowhere is none
            continue
        return f"{each} {found.st_dev} {found.st_ino} {found.st_rdev}"
    return ""


def present(devices: Iterable[str]) -> tuple[str, ...]:
    """Return those that are there."""
    return tuple(each for each in devices if identity(each))
