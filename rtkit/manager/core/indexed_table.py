"""Tables whose rows are also found by what is in them: an index that each change keeps up.

A manager with ten thousand components looks for the owner of a name at each creation: going through
all rows would make them cost their square.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Iterable, Mapping
from typing import Any, Generic, TypeVar

K = TypeVar("K")
V = TypeVar("V")
_MISSING: Any = object()


class Journal(Generic[K]):
    """Keys of the rows of a table that were put or removed; each who follows it has one."""

    def __init__(self) -> None:
        self._keys: dict[K, None] = {}

    def note(self, key: K) -> None:
        """Note that a row has changed."""
        self._keys[key] = None

    def take(self) -> Mapping[K, None]:
        """Return the keys of the rows that have changed since the last time."""
        taken, self._keys = self._keys, {}
        return taken


class IndexedTable(dict[K, V]):
    """Dictionary that also finds the keys of the rows with a term, in the order of their arrival.

    The index is made at the first search, so a copy in which nobody searches costs nothing more.
    """

    def __init__(self, terms: Callable[[V], Iterable[Hashable]], rows: Mapping[K, V]) -> None:
        super().__init__(rows)
        self._terms = terms
        self._index: dict[Hashable, dict[K, None]] | None = None
        self._journals: list[Journal[K]] = []

    def like(self, rows: Mapping[K, V]) -> IndexedTable[K, V]:
        """Return a table of other rows, which are found by the same terms."""
        return IndexedTable(self._terms, rows)

    def keys_with(self, term: Hashable) -> Collection[K]:
        """Return the keys of the rows with a term; it changes with the table."""
        if self._index is None:
            self._index = {}
            for key, row in self.items():
                self._enter(self._index, key, self._terms(row))
        return self._index.get(term, {}).keys()

    def begin_journal(self) -> Journal[K]:
        """Return a journal of the rows that change from now on."""
        journal: Journal[K] = Journal()
        self._journals.append(journal)
        return journal

    def end_journal(self, journal: Journal[K]) -> None:
        """Note changes in a journal no more."""
        self._journals = [each for each in self._journals if each is not journal]

    def __setitem__(self, key: K, row: V) -> None:
        for journal in self._journals:
            journal.note(key)
        if self._index is not None:
            terms, known = tuple(self._terms(row)), self.get(key, _MISSING)
            if known is _MISSING or (before := tuple(self._terms(known))) != terms:
                if known is not _MISSING:
                    self._leave(self._index, key, before)
                self._enter(self._index, key, terms)
        super().__setitem__(key, row)

    def __delitem__(self, key: K) -> None:
        self.pop(key)

    def pop(self, key: K, default: Any = _MISSING) -> Any:
        """Remove a row, and return it."""
        if default is not _MISSING and key not in self:
            return default
        row = super().pop(key)
        for journal in self._journals:
            journal.note(key)
        if self._index is not None:
            self._leave(self._index, key, self._terms(row))
        return row

    # What would pass the index by: nobody needs it.
    clear = popitem = setdefault = update = __ior__ = None  # type: ignore[assignment]

    def _enter(
        self, index: dict[Hashable, dict[K, None]], key: K, terms: Iterable[Hashable]
    ) -> None:
        for term in terms:
            index.setdefault(term, {})[key] = None

    def _leave(
        self, index: dict[Hashable, dict[K, None]], key: K, terms: Iterable[Hashable]
    ) -> None:
        for term in dict.fromkeys(terms):
            del index[term][key]
            if not index[term]:
                del index[term]
