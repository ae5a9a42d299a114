"""The table of what kinds of steps cost, where nothing was measured and nobody states a cost."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

DEFAULT_COSTS: Mapping[str, float] = {
    "start_manager": 8,
    "install": 12,
    "uninstall": 2,
    "load": 4,
    "unload": 2,
    "create": 3,
    "create_slave": 6,
    "delete": 2,
    "connect": 1,
    "disconnect": 1,
    "configure": 1,
    "activate": 1,
    "deactivate": 1,
    "reset": 1,
}

INTERRUPTIONS = ("deactivate", "delete", "reset")
"""Kinds of steps that interrupt a component."""


def is_cost(number: float) -> bool:
    """Return whether a step may cost so much."""
    return 0 < number < inf
