"""Modules whose names are found when they are first asked for."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any


class LazyModule(ModuleType):
    """A module that finds each of its names once.

    Args:
        find: Returns what a name stands for; raises AttributeError, or KeyError, for others.
        listed: Returns the names that ``import *`` gives.
    """

    def __init__(
        self,
        name: str,
        find: Callable[[str], Any],
        listed: Callable[[], Iterable[str]] = tuple,
    ) -> None:
        super().__init__(name)
        self.__path__: list[str] = []
        self._find = find
        self._listed = listed

    def __getattr__(self, name: str) -> Any:
        if name == "__all__":
            return [each for each in self._listed() if not each.startswith("_")]
        if name.startswith("__"):
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        try:
            found = self._find(name)
        except KeyError:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}") from None
        setattr(self, name, found)
        return found

    def __dir__(self) -> list[str]:
        """Return the names that it has, found yet or not."""
        return sorted({*vars(self), *self._listed()})
