"""Functions on lists that components call by name; ``OpenRTM_aist.CORBA_SeqUtil``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any


def for_each(items: Iterable[Any], function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Call a function with each item."""
    for each in items:
        function(each)
    return function


def find(items: Iterable[Any], test: Callable[[Any], Any]) -> int:
    """Return the place of the first item that passes a test, -1 where none does."""
    return next((at for at, each in enumerate(items) if test(each)), -1)


def push_back(items: list[Any], item: Any) -> None:
    """Append an item."""
    items.append(item)


def push_back_list(items: list[Any], others: Iterable[Any]) -> None:
    """Append items."""
    items.extend(others)


def insert(items: list[Any], item: Any, index: int) -> None:
    """Insert an item."""
    items.insert(index, item)


def front(items: list[Any]) -> Any:
    """Return the first item."""
    return items[0]


def back(items: list[Any]) -> Any:
    """Return the last item; None where there is none."""
    return items[-1] if items else None


def erase(items: list[Any], index: int) -> None:
    """Remove the item of a place, if there is one."""
    del items[index : index + 1]


def erase_if(items: list[Any], test: Callable[[Any], Any]) -> None:
    """Remove the first item that passes a test."""
    at = find(items, test)
    if at >= 0:
        del items[at]


def clear(items: list[Any]) -> None:
    """Remove all items."""
    del items[:]
