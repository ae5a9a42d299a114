"""Tells which running managers use a package: those that have loaded a module of it."""

from __future__ import annotations

import os

from rtkit.errors import Refused
from rtkit.link.running import managers
from rtkit.packages.installed import Installed
from rtkit.tree.connect import connect


def users(package: Installed, timeout_s: float) -> list[str]:
    """Return the managers of the user on this host that have loaded a module of a package.

    Raises:
        Unreachable: A manager does not answer, so that it may be one.
    """
    found = []
    for name in managers():
        with connect(name, timeout_s) as tree:
            modules = tree.snapshot().modules
        folder = os.path.realpath(package.path)  # as managers tell files
        if any(each.file.startswith(f"{folder}/") for each in modules):
            found.append(name)
    return found


def check_unused(package: Installed, timeout_s: float) -> None:
    """Refuse to remove a package that a running manager uses.

    Raises:
        Refused: One does; names it.
        Unreachable: One does not answer.
    """
    using = users(package, timeout_s)
    if using:
        raise Refused(
            f"{package.text} is in use by manager {', '.join(using)}"
            " (rtmgr -u unloads its module; --force removes it all the same)"
        )
