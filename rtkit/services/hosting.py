"""Services as components: ``StorageInit = init_of(Storage)`` makes a class loadable by rtmgr."""

from __future__ import annotations

from rtkit import component_of, init_of

__all__ = ["component_of", "init_of"]
