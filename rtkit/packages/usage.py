"""Tells which running managers use a package: those that have loaded a module of it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator

from rtkit.errors import Refused
from rtkit.link.places import quoted
from rtkit.link.running import managers
from rtkit.packages.records import Installed
from rtkit.rtc.names import LOCAL, MANAGER_SUFFIX
from rtkit.tree.connect import connect


def users(package: Installed, timeout_s: float) -> dict[str, list[str]]:
    """Return the modules of a package that managers of the user on this host have loaded, by these.

    Raises:
        Unreachable: A manager does not answer, so that it may be one.
    """
    found = {}
    for name in managers():
        with connect(name, timeout_s) as tree:
            modules = tree.snapshot().modules
        folder = os.path.realpath(package.path)  # as managers tell files
        if loaded := [each.path for each in modules if each.file.startswith(f"{folder}/")]:
            found[name] = loaded
    return found


def check_unused(package: Installed, timeout_s: float, host: str = LOCAL) -> None:
    """Refuse to remove a package that a running manager uses.

    Args:
        package: One of this host.
        timeout_s: How long a manager may take to answer [s].
        host: By which the user knows this host.

    Raises:
        Refused: One does; names it.
        Unreachable: One does not answer.
    """
    using = users(package, timeout_s)
    if using:
        lines = (
            " ".join(["rtmgr", quoted(f"/{host}/{name}{MANAGER_SUFFIX}"), *_unloading(modules)])
            for name, modules in using.items()
        )
        raise Refused(
            f"{package.text} is in use by manager {', '.join(using)}"
            f" ({'; '.join(lines)} unloads it; --force removes it all the same)"
        )


def _unloading(modules: Iterable[str]) -> Iterator[str]:
    for each in modules:
        yield from ("-u", quoted(each))
