"""rtkit: deployment and orchestration of component-based robot systems.

``rtkit.connect()`` is the way in for scripts; component authors import `rtkit.component`.
"""

from __future__ import annotations

# Spelt out, because typing costs more to import than all that a command does before its own
# imports, and until it has done that a Ctrl-C shows a traceback.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rtkit.tree.client import Tree
    from rtkit.tree.connect import connect
    from rtkit.version import __version__

__all__ = ["Tree", "__version__", "connect"]

_HOMES = {
    "Tree": "rtkit.tree.client",
    "__version__": "rtkit.version",
    "connect": "rtkit.tree.connect",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rtkit' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__} - {"TYPE_CHECKING", "annotations"})
