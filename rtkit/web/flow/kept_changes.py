"""Keeps the changes that pages were told, so that a past moment can be shown as it was.

A change bears the time of its last event. What was at a moment is what the changes up to then make
of the picture before the first one that is kept.
"""

from __future__ import annotations

import json
from collections import deque
from collections.abc import Iterator, Sequence
from time import time
from typing import TYPE_CHECKING

from rtkit.api.live_records import SystemRecords

if TYPE_CHECKING:
    from rtkit.api.live_records import Record

_MOST_CHANGES = 20_000
_MOST_BYTES = 32 << 20


class KeptChanges:
    """The last changes, bounded in number and size.

    Attributes:
        since: The first moment that is known [s since 1970].
        before: The records before the first change that is kept, and their revision.
    """

    def __init__(self, most: int = _MOST_CHANGES, most_bytes: int = _MOST_BYTES) -> None:
        """Have none yet."""
        self.since = time()
        self.before = SystemRecords.nothing()
        self.revision = 0
        self._most = most
        self._most_bytes = most_bytes
        self._changes: deque[tuple[float, bytes]] = deque()
        self._bytes = 0
        self._last = self.since
        self._has_forgotten = False

    def begin(self, records: SystemRecords, revision: int) -> float:
        """Begin with what is found by the first look; return its time."""
        self.before = SystemRecords(*(dict(each) for each in records))
        self.since = self._last = time()
        self.revision = revision
        return self.since

    def stamp(self, change: Record) -> None:
        """Give a change its time, which is not before that of the one before, and keep it."""
        events = change["events"]
        at = max((each["time"] for each in events), default=time())
        change["time"] = self._last = max(self._last, at)
        text = json.dumps(change, allow_nan=False).encode()
        self._changes.append((self._last, text))
        self._bytes += len(text)
        self._bound()

    def _bound(self) -> None:
        while len(self._changes) > self._most or self._bytes > self._most_bytes:
            self._forget()

    def _forget(self) -> None:
        self._has_forgotten = True
        self.since, text = self._changes.popleft()
        self._bytes -= len(text)
        change = json.loads(text)
        self.revision = change["revision"]
        _apply(change, self.before)

    def reach_back(self, since: float, before: SystemRecords, changes: Sequence[Record]) -> bool:
        """Know what was before the first look, too; return whether that still fits to what is kept.

        Args:
            since: The first moment that is known then [s since 1970].
            before: What was at that moment.
            changes: All until the first look, with their times; they lead to what that has found.
        """
        if self._has_forgotten:
            return False
        first = self.revision - len(changes)
        texts = []
        for number, change in enumerate(changes, first + 1):
            numbered = {"revision": number, **change}
            texts.append((change["time"], json.dumps(numbered, allow_nan=False).encode()))
        self._changes.extendleft(reversed(texts))
        self._bytes += sum(len(text) for _, text in texts)
        self.since, self.before, self.revision = since, before, first
        self._bound()
        return True

    def at(self, moment: float) -> SystemRecords:
        """Return what was at a moment [s since 1970]."""
        found = SystemRecords(*(dict(each) for each in self.before))
        for time_s, text in self._changes:
            if time_s > moment:
                break
            _apply(json.loads(text), found)
        return found

    def pieces(self, picture: Record) -> Iterator[bytes]:
        """Yield the answer of all that is kept; `picture` has what no change touches."""
        records = {name: list(each.values()) for name, each in self.before._asdict().items()}
        first = {**picture, **records, "revision": self.revision}
        yield f'{{"since": {self.since!r}, "picture": {json.dumps(first)}, "changes": ['.encode()
        yield b", ".join(text for _, text in self._changes)
        yield b"]}"


def _apply(change: Record, records: SystemRecords) -> None:
    for name, known in records._asdict().items():
        for id in change["gone"][name]:
            known.pop(id, None)
        known.update({each["id"]: each for each in change[name]})
