"""Reads the logs of a manager of another host, by questions to it; see `rtkit.logs.logbook`.

Times are put right by the estimated offset of the clock there.
"""

from __future__ import annotations

import json
import re
import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime, timedelta
from operator import attrgetter
from os import urandom
from typing import Any

from rtkit.closing import Closing
from rtkit.errors import Malformed, RtkitError, Unreachable
from rtkit.link.threads import start_thread
from rtkit.link.wakeup import Wakeup
from rtkit.logs.logbook import LogEntry
from rtkit.logs.selection import LEVELS, LOGS, Selection, selection_to_text
from rtkit.rtc.manager_address import is_address
from rtkit.tree.client import Tree
from rtkit.tree.clock import ClockOffset, compare
from rtkit.tree.connect import connect

_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{6}Z")
_QUEUE = 4096
"""Messages that may wait."""
_MARK_S = 0.25
_TRIES = 20
_PAUSE_S = 0.5
"""Between two tries to reach a manager again [s]."""
_AGE_S, _AGAIN = 10.0, 3
"""After how long the clocks are compared again, while records come, and by how many questions."""


class FarLogbook(Closing):
    """The logs of a manager of another host.

    Attributes:
        unreadable: How many lines, or messages, were no records.
        lost: How many messages did not arrive.
        left_out: How many records there are before those that were sent at the beginning.
        clock: The offset there, as it was found last.
    """

    def __init__(self, tree: Tree, selection: Selection) -> None:
        """Begin to listen.

        Raises:
            RtkitError: The manager does not answer, or cannot be asked for logs.
        """
        self._tree = tree
        self._selection = selection
        self._wanted = selection._replace(since_s=None).wanted()
        self._wakeup = Wakeup()
        self._received: deque[str] = deque(maxlen=_QUEUE)
        self._seen: Counter[LogEntry] = Counter()
        self._last = ("", 0)
        self.unreadable = self.lost = self.left_out = 0
        self.clock: ClockOffset = compare(tree)
        self._news: list[str] = []
        self._was_found = self._is_lost = False
        self._latest = _in_log(datetime.fromtimestamp(time.time() + self.clock.offset_s, UTC))
        self._closing = threading.Event()
        self._is_looking = False
        self._fresh: list[Tree | RtkitError] = []
        self._own: Tree | None = None
        self._ends = self._begin()

    def fileno(self) -> int:
        """Return the descriptor that turns readable when something has come."""
        return self._wakeup.fileno()

    def close(self) -> None:
        """Read no more."""
        self._closing.set()
        self._leave()
        self._wakeup.close()

    def _begin(self) -> list[Callable[[], object]]:
        return [self._tree.listen(LOGS, self._take), self._tree.notice(self._note)]

    def _leave(self) -> None:
        while self._ends:
            self._ends.pop()()
        if self._own is not None:
            self._own.close()

    def there(self, most: int | None = None, *, is_followed: bool = True) -> list[LogEntry]:
        """Return what is in the logs, or of that the latest, and have `delta` begin after it.

        Raises:
            Unreachable: The manager does not answer, or what it sends does not arrive.
        """
        for _ in range(_TRIES if is_followed else 1):
            mark = urandom(8).hex()
            text = self._tree.view(LOGS, selection_to_text(self._selection, most, mark))
            if not is_followed or self._has_come(mark):
                return self._present(text)
        raise Unreachable(f"what manager {self._tree.manager!r} logs does not arrive")

    def delta(self) -> list[LogEntry]:
        """Return what was logged since the last time."""
        self._wakeup.hush()
        missed = self._logged_meanwhile() if self._fresh else []
        entries: list[LogEntry] = []
        while self._received:
            entries += self._entries(self._received.popleft())
        if entries and time.time() - self.clock.found_s > _AGE_S:
            with suppress(RtkitError):  # the old one holds on, less exactly
                self.clock = compare(self._tree, _AGAIN)
        fresh = [*missed]
        for entry in entries:
            if self._seen[entry]:
                self._seen[entry] -= 1
            elif self._wanted(entry):
                fresh.append(self._put_right(entry))
        return sorted(fresh, key=attrgetter("time"))

    def news(self) -> list[str]:
        """Return what is to be told since the last time: that the host was lost, or is back.

        Raises:
            RtkitError: It lets this user in no longer, or another manager answers there.
        """
        news, self._news = self._news, []
        if self._fresh and isinstance(self._fresh[0], RtkitError):
            raise self._fresh[0]
        return news

    def _reconnect(self) -> None:
        """Connect anew to a port for certificates: there is no link that does it."""
        place, timeout_s = self._tree.place, self._tree.timeout_s
        while not self._closing.wait(_PAUSE_S):
            try:
                self._fresh.append(connect(place, timeout_s))
            except Unreachable:
                continue
            except RtkitError as error:
                self._fresh.append(error)
            self._wakeup.ring()
            return

    def _logged_meanwhile(self) -> list[LogEntry]:
        """Go on by a new connection; return what was logged since the old one ended."""
        fresh = self._fresh[0]
        if isinstance(fresh, RtkitError):
            return []
        self._leave()
        self._fresh.clear()
        self._is_looking = False
        self._own = self._tree = fresh
        self._selection = self._selection._replace(since_s=None)
        self._last = ("", 0)
        latest = self._latest
        try:
            self._ends = self._begin()
            self.clock = compare(fresh, _AGAIN)
            self.there()
        except Unreachable:
            self._look_for_it()
            return []
        return [self._put_right(each) for each in self._seen.elements() if each.time > latest]

    def _look_for_it(self) -> None:
        if self._is_looking:
            return
        self._is_looking = True
        start_thread(self._reconnect, "reconnect")

    def _note(self, is_found: bool) -> None:
        """Note whether the manager can be asked."""
        if self._was_found and is_found == self._is_lost:
            self._is_lost = not is_found
            is_linked = not is_address(self._tree.place)
            shown = "not shown" if is_linked else "shown when it is back"
            how = "is back" if is_found else f"is lost: what it logs meanwhile is {shown}"
            if not (is_found or is_linked):
                self._look_for_it()
            self._news.append(f"manager {self._tree.manager!r} of {self._tree.place} {how}")
            self._wakeup.ring()
        self._was_found |= is_found

    def _take(self, text: str) -> None:
        self._received.append(text)
        self._wakeup.ring()

    def _has_come(self, mark: str) -> bool:
        """Wait for a mark on the topic: what is logged from now on comes there, too."""
        until = time.monotonic() + _MARK_S
        wanted = f'{{"mark": "{mark}"}}'
        while wanted not in list(self._received):
            if not self._wakeup.wait([], max(0.0, until - time.monotonic())):
                return False
        self._wakeup.ring()
        return True

    def _present(self, text: str) -> list[LogEntry]:
        try:
            data = json.loads(text)
            self.left_out, self.unreadable = int(data["left_out"]), int(data["unreadable"])
            rows = list(data["entries"])
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            why = f"what manager {self._tree.manager!r} answers about its logs is no sense: {error}"
            raise Malformed(why) from error
        entries = [each for each in map(self._entry, rows) if each is not None]
        self._seen = Counter(entries)
        return sorted(map(self._put_right, entries), key=attrgetter("time"))

    def _entries(self, text: str) -> list[LogEntry]:
        """Return the records of a message; none of a mark."""
        try:
            data = json.loads(text)
            if "mark" in data:
                return []
            run, number, rows = str(data["run"]), int(data["number"]), list(data["entries"])
        except (ValueError, KeyError, TypeError, RecursionError):
            self.unreadable += 1
            return []
        if self._last[0] == run:
            self.lost += max(0, number - self._last[1] - 1)
        self._last = (run, number)
        return [each for each in map(self._entry, rows) if each is not None]

    def _entry(self, row: Any) -> LogEntry | None:
        try:
            moment, file, level, process, pid, component, source, message, exception = row
            if _TIME.fullmatch(moment) and level in LEVELS:
                self._latest = max(self._latest, moment)
                who = str(process), int(pid), str(component), str(source)
                return LogEntry(moment, str(file), level, *who, str(message), str(exception))
        except (TypeError, ValueError):
            pass
        self.unreadable += 1
        return None

    def _put_right(self, entry: LogEntry) -> LogEntry:
        try:
            there = datetime.fromisoformat(entry.time)
            here = (there - timedelta(seconds=self.clock.offset_s)).astimezone(UTC)
        except (ValueError, OverflowError):
            return entry._replace(host=self._tree.place)
        return entry._replace(
            time=_in_log(here),
            host=self._tree.place,
            offset_s=self.clock.offset_s,
            bound_s=self.clock.bound_at(here.timestamp()),
        )


def _in_log(moment: datetime) -> str:
    return f"{moment:%Y-%m-%dT%H:%M:%S.%f}Z"
