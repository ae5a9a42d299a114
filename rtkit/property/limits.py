"""Limits of a value, and the budget that holds its reader to them."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.property.codes import PropertyError


class ValueLimits(NamedTuple):
    """Limits of a value: text [characters], nesting of brackets and elements, items."""

    text: int = 1 << 20
    depth: int = 64
    items: int = 1_000_000


LIMITS = ValueLimits()

OF_REPLIES = ValueLimits(text=1 << 26, items=1 << 26)
"""Limits of what was asked for: an owner may have more to tell than it takes at once."""


class Budget:
    """Counts items over groups, elements and leaves, and bounds what may still be read."""

    __slots__ = ("items", "limits")

    def __init__(self, limits: ValueLimits) -> None:
        self.limits = limits
        self.items = 0

    def spend(self, depth: int) -> None:
        """Count one item at a depth.

        Raises:
            PropertyError: ``too-large``.
        """
        self.items += 1
        self.check()
        if depth > self.limits.depth:
            raise PropertyError("too-large", f"nested deeper than {self.limits.depth}")

    def check(self) -> None:
        """Look whether what was counted is too much.

        Raises:
            PropertyError: ``too-large``.
        """
        if self.items > self.limits.items:
            raise PropertyError("too-large", f"more than {self.limits.items} items")


def syntax(offset: int, expected: str) -> PropertyError:
    """Return the error for a text that cannot be read from `offset` [characters] on."""
    return PropertyError("syntax", f"{offset} {expected}")
