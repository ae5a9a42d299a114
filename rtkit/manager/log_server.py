"""Sends the log records of a manager and its slaves to whoever asks, or listens, from elsewhere.

Commands of its own host read the files themselves.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterable
from os import urandom

from rtkit.link import zenoh_keys
from rtkit.link.places import state_dir
from rtkit.link.threads import start_thread
from rtkit.link.transport import Link
from rtkit.link.wakeup import Wakeup
from rtkit.logs.logbook import Logbook, LogEntry
from rtkit.logs.selection import LOGS, About, selection_from_text

MOST_BYTES = 1 << 22
"""Size of an answer, of which the latest records are; and of what a listener gets at a time."""
_PIECE_BYTES = 1 << 18
_SETTLE_S = 0.02
"""Wait for simultaneous records of other processes, so that they can be put in order [s]."""
_OF_A_LOG = 9


class LogServer:
    """Records of one manager, for other hosts."""

    def __init__(self, manager: str) -> None:
        self._send: Callable[[str], object] = lambda _text: None
        self._own = About(manager, is_deep=True)
        self._follower: _Follower | None = None
        self._lock = threading.Lock()

    def open(self, link: Link, service: str) -> Callable[[], object]:
        """Open the topic of new records; return what ends it."""
        self._send = link.announce(zenoh_keys.line_key(service, LOGS), self._listened)
        return lambda: self._listened(False)

    def answer(self, text: str) -> str:
        """Return the records that a request asks for, the latest if there are too many.

        Raises:
            Malformed: It is none.
        """
        selection, most, mark = selection_from_text(text)
        wanted = selection.wanted()
        with self._lock:
            if self._follower is not None and self._follower.has_begun:
                self._send(json.dumps({"mark": mark[:64]}))
        book = Logbook(state_dir(), lambda entry: self._own.covers(entry) and wanted(entry))
        try:
            entries = book.there(None if most is None else max(0, most))
        finally:
            book.close()
        shown = _latest(entries)
        left_out = len(entries) - len(shown)
        return json.dumps({"entries": shown, "left_out": left_out, "unreadable": book.unreadable})

    def _listened(self, is_listened: bool) -> None:
        """Follow the logs while anybody listens."""
        with self._lock:
            if is_listened and self._follower is None:
                self._follower = _Follower(self._own, self._send)
                start_thread(self._follower.run, "logs")
            elif not is_listened and self._follower is not None:
                self._follower.end()
                self._follower = None


class _Follower:
    """Follows the logs, from its beginning to its end."""

    def __init__(self, own: About, send: Callable[[str], object]) -> None:
        self._own = own
        self._send = send
        self._run = urandom(4).hex()
        self._number = 0
        self._wakeup = Wakeup()
        self._is_over = False
        self.has_begun = False

    def end(self) -> None:
        self._is_over = True
        self._wakeup.ring()

    def run(self) -> None:
        book = Logbook(state_dir(), self._own.covers)
        try:
            book.there(0)
            self.has_begun = True
            while not self._is_over:
                self._wakeup.wait([book.fileno()], None)
                time.sleep(_SETTLE_S)
                self._publish(book.delta())
        finally:
            book.close()
            self._wakeup.close()

    def _publish(self, entries: Iterable[LogEntry]) -> None:
        rows: list[list[object]] = []
        size = 0
        for entry in entries:
            if self._is_over:
                return
            rows.append(_row(entry))
            size += _size(entry)
            if size > _PIECE_BYTES:
                self._send_rows(rows)
                rows, size = [], 0
        if rows:
            self._send_rows(rows)

    def _send_rows(self, rows: list[list[object]]) -> None:
        self._number += 1
        text = {"run": self._run, "number": self._number, "entries": rows}
        self._send(json.dumps(text))


def _row(entry: LogEntry) -> list[object]:
    return [*entry[:_OF_A_LOG]]


def _size(entry: LogEntry) -> int:
    return len(entry.message) + len(entry.exception) + 200


def _latest(entries: list[LogEntry]) -> list[list[object]]:
    rows: list[list[object]] = []
    size = 0
    for entry in reversed(entries):
        size += _size(entry)
        if size > MOST_BYTES:
            break
        rows.append(_row(entry))
    rows.reverse()
    return rows
