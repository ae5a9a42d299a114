"""rtkit: deployment and orchestration of component-based robot systems.

``rtkit.connect()`` is the way in for scripts; component authors import `rtkit.component`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = ["Tree", "__version__", "connect"]

if TYPE_CHECKING:
    from rtkit.tree.client import Tree, connect


def __getattr__(name: str) -> Any:
    if name in ("Tree", "connect"):
        from rtkit.tree import client

        return getattr(client, name)
    raise AttributeError(f"module 'rtkit' has no attribute {name!r}")
