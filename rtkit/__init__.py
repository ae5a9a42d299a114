"""rtkit: deployment and orchestration of component-based robot systems.

``rtkit.connect()`` is the way in for scripts, ``rtkit.serve()`` makes live properties of an object,
``rtkit.run()`` runs a component in the process that calls it; component authors import
`rtkit.component`.
"""

from __future__ import annotations

# Spelt out, because typing costs more to import than all that a command does before its own
# imports, and until it has done that a Ctrl-C shows a traceback (decision 35).
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rtkit import aio as aio
    from rtkit.api.asked import Ask
    from rtkit.api.client import Client
    from rtkit.api.connect import connect
    from rtkit.api.hosting import component_of, init_of
    from rtkit.api.plan import SystemPlan
    from rtkit.api.property_change import PropertyChange
    from rtkit.api.system_profiles import SystemProfile, load
    from rtkit.api.tree import Tree
    from rtkit.by_hand import run
    from rtkit.property.annotations import Concurrent, Range, Returns, Text, Unit
    from rtkit.property.codes import PropertyError
    from rtkit.property.functional import behavior
    from rtkit.property.marker import Marker
    from rtkit.property.names import Names
    from rtkit.property.presenting import Choices, Gui
    from rtkit.property.values import Element, Word
    from rtkit.proxy.mounts import Mount, mounts
    from rtkit.version import __version__
    from rtkit.wires.serve import serve

_HOMES = {
    "Ask": "rtkit.api.asked",
    "Client": "rtkit.api.client",
    "aio": "rtkit.aio",
    "Choices": "rtkit.property.presenting",
    "Concurrent": "rtkit.property.annotations",
    "Gui": "rtkit.property.presenting",
    "Element": "rtkit.property.values",
    "Marker": "rtkit.property.marker",
    "Names": "rtkit.property.names",
    "Mount": "rtkit.proxy.mounts",
    "PropertyChange": "rtkit.api.property_change",
    "PropertyError": "rtkit.property.codes",
    "Word": "rtkit.property.values",
    "SystemPlan": "rtkit.api.plan",
    "Range": "rtkit.property.annotations",
    "Returns": "rtkit.property.annotations",
    "SystemProfile": "rtkit.api.system_profiles",
    "Tree": "rtkit.api.tree",
    "Text": "rtkit.property.annotations",
    "Unit": "rtkit.property.annotations",
    "__version__": "rtkit.version",
    "behavior": "rtkit.property.functional",
    "component_of": "rtkit.api.hosting",
    "connect": "rtkit.api.connect",
    "init_of": "rtkit.api.hosting",
    "load": "rtkit.api.system_profiles",
    "mounts": "rtkit.proxy.mounts",
    "run": "rtkit.by_hand",
    "serve": "rtkit.wires.serve",
}
__all__ = [
    "Ask", "Choices", "Client", "Concurrent", "Element", "Gui", "Marker", "Mount", "Names",
    "PropertyChange", "PropertyError", "Range", "Returns", "SystemPlan", "SystemProfile", "Text",
    "Tree", "Unit", "Word", "__version__", "aio", "behavior", "component_of", "connect", "init_of",
    "load", "mounts", "run", "serve",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'rtkit' has no attribute {name!r}")
    from importlib import import_module

    if name == "aio":
        return import_module("rtkit.aio")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return sorted(__all__)
