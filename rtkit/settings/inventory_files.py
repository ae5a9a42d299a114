"""Inventories of hosts, ``hosts.toml``: where they lie, and which names stand in them.

The user's own is in the configuration folder; one in the present folder takes precedence over it,
and one beside the system profile that a command reads over both.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Iterable

from rtkit.errors import RtkitError
from rtkit.link import places
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings.reading import read_private

_beside: list[str] = []
"""Folders of the system profiles that this process has read, the last one first."""


def user_file() -> str:
    """Return the path of the user's own inventory."""
    base = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")
    return os.path.join(base, "rtkit", places.INVENTORY)


def heed(folder: str) -> None:
    """Have an inventory in the folder of a system profile take precedence in this process."""
    folder = os.path.abspath(folder)
    _beside[:] = [folder, *(each for each in _beside if each != folder)]


def files() -> list[str]:
    """Return the inventories that are there, the strongest first; one beside a profile first."""
    inventories = (os.path.join(each, places.INVENTORY) for each in (*_beside, os.getcwd()))
    return [each for each in dict.fromkeys((*inventories, user_file())) if os.path.lexists(each)]


def hint(name: str, known: Iterable[str]) -> str:
    """Return what helps with the name of a host that is not among the known ones."""
    return did_you_mean(name, sorted(known)) or f" (add it: rthost add {name} USER@ADDRESS)"


def names() -> set[str]:
    """Return the names in all inventories, for hints; one that cannot be read counts as empty.

    Whoever goes to a host reads the inventory itself (`rtkit.hosts.inventory`), and is told why.
    """
    found: set[str] = set()
    for each in files():
        try:
            found.update(tomllib.loads(read_private(each, must_be_ours=True).decode("utf-8")))
        except (RtkitError, ValueError):
            continue
    return found
