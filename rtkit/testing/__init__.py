"""Tools for tests: a trial of one component by hand, a private manager, fixtures of pytest."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rtkit.testing.realm import own_manager
    from rtkit.testing.trial import Trial

__all__ = ["Trial", "own_manager"]

_HOMES = {"Trial": "rtkit.testing.trial", "own_manager": "rtkit.testing.realm"}


def __getattr__(name: str) -> Any:
    # pytest loads the plugin of this package in each run, also where nothing of it is used.
    if name not in _HOMES:
        raise AttributeError(f"module 'rtkit.testing' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOMES[name]), name)
