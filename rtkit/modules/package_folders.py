"""Finds the folders of installed packages: NAME/VERSION, several versions side by side.

They are made by ``rtpkg install``, renamed last: what is there is whole.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import NamedTuple


class PackageFolder(NamedTuple):
    """Folder of a version of a package, with all that it needs beside it."""

    name: str
    version: str
    path: str


def root() -> str:
    """Return the folder of the user's packages, which need not be there."""
    base = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    return os.path.join(base, "rtkit", "packages")


def folders() -> Iterator[PackageFolder]:
    """Yield what is installed, sorted by name, the newest version of each first."""
    top = root()
    for name in _entries(top):
        versions = _entries(os.path.join(top, name))
        if len(versions) > 1:
            from packaging.version import InvalidVersion, Version  # each manager starts here

            try:
                versions.sort(key=Version, reverse=True)
            except InvalidVersion:
                versions.sort(reverse=True)
        for version in versions:
            yield PackageFolder(name, version, os.path.join(top, name, version))


def _entries(folder: str) -> list[str]:
    try:
        return sorted(each for each in os.listdir(folder) if not each.startswith("."))
    except OSError:
        return []
