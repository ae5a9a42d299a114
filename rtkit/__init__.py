"""rtkit: deployment and orchestration of component-based robot systems.

``rtkit.connect()`` is the way in for scripts; component authors import `rtkit.component`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = ["Tree", "__version__", "connect"]

if TYPE_CHECKING:
    from rtkit.tree.client import Tree
    from rtkit.tree.connect import connect
    from rtkit.version import __version__


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
    return sorted({*globals(), *__all__})
