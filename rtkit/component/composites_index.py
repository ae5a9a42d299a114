"""Detects composites without importing the modules that composites need."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeGuard

from rtkit.component.base import Component

if TYPE_CHECKING:
    from rtkit.component.composite import Composite


def is_composite(component: Component | None) -> TypeGuard[Composite]:
    """Return whether a component drives or groups others."""
    return component is not None and bool(component.composite_type)
