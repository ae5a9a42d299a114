"""Finds the folders of installed packages: NAME/VERSION, several versions side by side.

They are made by ``rtpkg install``, renamed last: a folder that is there is whole. One without the
record of an installation, or a link to another folder, is none of them.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import NamedTuple

RECORD = ".rtkit-package.json"
"""File of a version's folder, which records the installation."""
FOLDER = os.path.join("rtkit", "packages")
"""Where the packages of a user are, below the folder of his data."""


class PackageFolder(NamedTuple):
    """Folder of a version of a package, with all that it needs beside it."""

    name: str
    version: str
    path: str


def root() -> str:
    """Return the folder of the user's packages, which need not be there."""
    base = os.environ.get("XDG_DATA_HOME") or os.path.expanduser("~/.local/share")
    return os.path.join(base, FOLDER)


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
            path = os.path.join(top, name, version)
            if os.path.isfile(os.path.join(path, RECORD)):
                yield PackageFolder(name, version, path)


def _entries(folder: str) -> list[str]:
    """Return the names of the folders in a folder, without links and what is hidden."""
    try:
        with os.scandir(folder) as entries:
            return sorted(
                each.name
                for each in entries
                if not each.name.startswith(".") and each.is_dir(follow_symlinks=False)
            )
    except OSError:
        return []
