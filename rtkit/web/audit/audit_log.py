"""Records each change that was asked of the server: when, by whom, what, the old and new value.

All pages see it, and the log of the server has a line of it. A value that is moved, as by a slider,
is one change: from what was before to what it was when the hand rested.
"""

from __future__ import annotations

import asyncio
import shlex
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from itertools import count
from time import time
from typing import NamedTuple

from starlette.requests import Request

from rtkit.api.live_records import Record
from rtkit.web.live.steps import CommandStep
from rtkit.web.pages import Pages

CHANGED = "changed"
"""The event that tells a record: a new one, or that it goes on."""
PAGE_HEADER = "rtkit-page"
"""The header by which a page says which one it is."""
_MOST = 2000
_MOST_TEXT = 1000
_REST_S = 1.0
"""A value that is set again within this time is still being moved."""


class Author:
    """Page or script that has asked for a change.

    Attributes:
        page: The id that a page has given itself; empty for a script.
        address: Where the request came from.
    """

    def __init__(self, request: Request) -> None:
        self.page = request.headers.get(PAGE_HEADER, "")[:64]
        self.address = request.client.host if request.client else ""

    def __str__(self) -> str:
        """Return it in words."""
        who = f"page {self.page[:8]}" if self.page else "script"
        return f"{who} at {self.address}"


@dataclass
class AuditRecord:
    """One change.

    Attributes:
        id: Grows from record to record.
        time: When it was done, or was done last [s since 1970].
        page: The page that has asked for it; empty for a script.
        by: That page or script, in words.
        text: What was done, as a sentence.
        command: The command line that does the same.
        old: The value before; None where there is none, or none that is known.
        new: The value since.
        error: Why it failed; empty when it was done.
        count: How many times in a row a value was set.
    """

    id: int
    time: float
    page: str
    by: str
    text: str
    command: str
    old: str | None = None
    new: str | None = None
    error: str = ""
    count: int = 1

    def line(self) -> str:
        """Return it as a line of the log."""
        when = datetime.fromtimestamp(self.time, UTC).isoformat(timespec="milliseconds")
        values = "" if self.new is None else f" from {_known(self.old)} to {self.new}"
        times = f", {self.count} values" if self.count > 1 else ""
        failed = f": failed: {self.error}" if self.error else ""
        return f"{when} {self.by}: {self.text}{values}{times}{failed}"


class MovedValue(NamedTuple):
    """A value that somebody is moving.

    Attributes:
        record: Its record, which goes on.
        old: The value before it was moved; None where it is not known.
        why: Why the move cannot be taken back; empty if it can.
        timer: Ends the move.
    """

    record: AuditRecord
    old: str | None
    why: str
    timer: asyncio.TimerHandle


class AuditLog:
    """The last records; those of values that are moved are still open."""

    def __init__(self, pages: Pages, write_line: Callable[[str], object]) -> None:
        """Have none; news is sent to `pages`, lines are written by `write_line`."""
        self._pages = pages
        self._write_line = write_line
        self._numbers = count(1)
        self._records: deque[AuditRecord] = deque(maxlen=_MOST)
        self._moved: dict[str, MovedValue] = {}

    def records(self) -> list[Record]:
        """Return the last ones, the newest last."""
        return [asdict(each) for each in self._records]

    def add(
        self,
        author: Author,
        text: str,
        command: str = "",
        *,
        old: str | None = None,
        new: str | None = None,
        error: str = "",
    ) -> None:
        """Record a change that was done, or has failed."""
        record = self._new(author, text, command, old, new, error)
        self._write_line(record.line())
        self._send(record)

    def add_step(self, author: Author, step: CommandStep, outcome: Record) -> None:
        """Record how a step went."""
        if step.target:
            self.rest(step.target)
        error = "" if outcome["ok"] else outcome["error"]
        line = shlex.join(step.line)
        self.add(author, step.text, line, old=step.old, new=step.new, error=error)

    def moving(self, author: Author, target: str) -> MovedValue | None:
        """Return the value that this author is moving, None if it rests."""
        moved = self._moved.get(target)
        return moved if moved is not None and moved.record.page == author.page else None

    def move(
        self,
        author: Author,
        target: str,
        command: str,
        new: str,
        *,
        old: str | None,
        why: str,
        error: str = "",
    ) -> int:
        """Record that a value was set; return the number of the record, of one that goes on its."""
        moved = self.moving(author, target)
        if moved is None:
            self.rest(target)
            record = self._new(author, f"Set {target}", command, old, new, error)
        else:
            moved.timer.cancel()
            record = moved.record
            record.time, record.command, record.error = time(), command, error
            record.new = new[:_MOST_TEXT]
            record.count += 1
        timer = asyncio.get_running_loop().call_later(_REST_S, self.rest, target)
        self._moved[target] = MovedValue(record, old, why, timer)
        self._send(record)
        return record.id

    def rest(self, target: str) -> None:
        """Take a value to be moved no longer: what comes next is a change of its own."""
        moved = self._moved.pop(target, None)
        if moved is not None:
            moved.timer.cancel()
            self._write_line(moved.record.line())

    async def close(self) -> None:
        """Write what is still open."""
        for target in tuple(self._moved):
            self.rest(target)

    def _new(
        self, author: Author, text: str, command: str, old: str | None, new: str | None, error: str
    ) -> AuditRecord:
        old, new = (None if each is None else each[:_MOST_TEXT] for each in (old, new))
        about = next(self._numbers), time(), author.page, str(author), text, command
        record = AuditRecord(*about, old, new, error)
        self._records.append(record)
        return record

    def _send(self, record: AuditRecord) -> None:
        self._pages.send(CHANGED, asdict(record))


def _known(value: str | None) -> str:
    return "what is not known" if value is None else value
