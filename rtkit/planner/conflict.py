"""Finds minimal conflicts: desired values that can hold together once any one is left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

W = TypeVar("W")


def minimal_conflict(
    wishes: Sequence[W], is_possible: Callable[[Sequence[W]], bool]
) -> tuple[W, ...]:
    """Return a minimal conflict: desired values that can hold together once any is left out.

    It halves the set (QuickXplain), so few questions find few values among many.
    Empty when all can hold together, and also when it is impossible without any desired value.
    """
    if is_possible(wishes) or not is_possible(()):
        return ()
    return tuple(_conflict([], False, list(wishes), is_possible))


def _conflict(
    given: list[W], is_new: bool, wishes: list[W], is_possible: Callable[[Sequence[W]], bool]
) -> list[W]:
    if is_new and not is_possible(given):
        return []
    if len(wishes) == 1:
        return wishes
    half = len(wishes) // 2
    first, second = wishes[:half], wishes[half:]
    of_second = _conflict(given + first, bool(first), second, is_possible)
    of_first = _conflict(given + of_second, bool(of_second), first, is_possible)
    return of_first + of_second
