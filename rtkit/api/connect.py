"""Connects scripts to a manager."""

from __future__ import annotations

from typing import cast

from rtkit.api.data_tree import silent
from rtkit.api.session import Notify
from rtkit.api.tree import Tree
from rtkit.errors import Unreachable
from rtkit.link.places import usual_manager
from rtkit.tree import connect as connecting
from rtkit.tree.client import DEFAULT_TIMEOUT_S


def connect(
    manager: str = "",
    timeout_s: float = DEFAULT_TIMEOUT_S,
    *,
    start: bool = False,
    notify: Notify = silent,
) -> Tree:
    """Connect to a manager of this host: ``with rtkit.connect() as tree:``.

    Args:
        manager: Its name, by default the usual one; or its address, ``localhost:2811`` or
            ``corbaloc::localhost:2811``.
        timeout_s: Bound on every call, also on this one [s].
        start: Start it first if it does not run, as ``rtmgr start`` does. It goes on to run.
        notify: Receives progress and warnings of what the tree does, one line each.

    Raises:
        Unreachable: It does not run, or does not answer in time.
        Refused: Another user can have laid its socket; or it could not be started.
    """
    try:
        tree = _connected(manager, timeout_s)
    except Unreachable:
        if not start:
            raise
        from rtkit.api.gathering import can_be_started, start_manager

        name = manager or usual_manager()
        if not can_be_started(name):
            raise
        start_manager(name, timeout_s, notify)
        tree = _connected(name, timeout_s)
    tree.notify = notify
    return tree


def _connected(manager: str, timeout_s: float) -> Tree:
    return cast(Tree, connecting.connect(manager, timeout_s, Tree))
