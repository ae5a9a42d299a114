"""rtkit: deployment and orchestration of component-based robot systems.

``rtkit.connect()`` is the way in for scripts; component authors import `rtkit.component`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = ["Tree", "__version__", "connect"]

if TYPE_CHECKING:
    from rtkit.tree.client import Tree, connect
    from rtkit.version import __version__


def __getattr__(name: str) -> Any:
    if name in ("Tree", "connect"):
        from rtkit.tree import client

        return getattr(client, name)
    if name == "__version__":
        from rtkit.version import __version__

        return __version__
    raise AttributeError(f"module 'rtkit' has no attribute {name!r}")
