"""Finds modules by which components are clients of their manager, and see others of the tree.

They stand above this room, as all clients do, and are loaded when a component asks for one.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

_ROOM = "rtkit.openrtm_scripts"
CLIENTS = {"CorbaNaming": "naming"}
"""Names of OpenRTM-aist that such a module has, and that module."""


def client_module(name: str) -> ModuleType:
    """Return such a module."""
    return import_module(f"{_ROOM}.{name}")
