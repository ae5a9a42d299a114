"""State that the rooms of the server share: the live system, open pages, folders, and jobs."""

from __future__ import annotations

from collections import deque
from collections.abc import Awaitable, Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from rtkit.api.live_records import Record, SystemRecords, change_between
from rtkit.errors import Denied
from rtkit.link.places import host_name
from rtkit.version import __version__
from rtkit.web.audit.audit_log import AuditLog
from rtkit.web.feed import FeedUpdate
from rtkit.web.flow.kept_changes import KeptChanges
from rtkit.web.jobs.jobs import Jobs
from rtkit.web.pages import Pages

if TYPE_CHECKING:
    from rtkit.api.client import Client
    from rtkit.api.live_records import KnownManager
    from rtkit.api.session import Session

MOST_PAGES = 64
_KEPT_EVENTS = 10_000


class WebSite:
    """The live system as of now, and whether it may be changed.

    Attributes:
        session: The connection to managers; the thread of the feed uses it.
        folders: Those whose files may be read and written; their paths have no links.
        is_read_only: Nothing may be changed.
        host: The name of this host.
        pages: Those that are open.
        jobs: Commands that go on for some time.
        audit: What pages and scripts have changed.
        update: What the feed has told last.
        revision: Grows with each change.
        events: The last ones, with their times.
        closers: Called, one after the other, before the server ends.
        past: The changes that have led here.
        when_begun: Called once the first look has found something.
        is_known: The feed has looked once, whether or not it has found something.
    """

    def __init__(
        self,
        session: Session,
        folders: Sequence[str],
        log: Callable[[str], object],
        *,
        is_read_only: bool,
    ) -> None:
        """Know nothing yet; each change is a line that `log` is called with."""
        self.session = session
        self.folders = folders
        self.is_read_only = is_read_only
        self.host = host_name()
        self.pages = Pages(MOST_PAGES)
        self.jobs = Jobs(self.pages)
        self.audit = AuditLog(self.pages, log)
        self.update = FeedUpdate(SystemRecords.nothing(), (), (), None)
        self.revision = 0
        self.events: deque[Record] = deque(maxlen=_KEPT_EVENTS)
        self.closers: list[Callable[[], Awaitable[object]]] = [self.jobs.close, self.audit.close]
        self.past = KeptChanges()
        self.when_begun: list[Callable[[], object]] = []
        self.is_known = False

    @property
    def records(self) -> SystemRecords:
        """Return what lives."""
        return self.update.records

    @property
    def managers(self) -> Sequence[KnownManager]:
        """Return the managers, with all that they tell."""
        return self.update.managers

    @cached_property
    def client(self) -> Client:
        """The client for properties of services, wherever they are."""
        from rtkit.api.client import Client

        return Client()

    def close(self) -> None:
        """End the connections to services."""
        if "client" in vars(self):
            self.client.close()

    def take(self, update: FeedUpdate) -> Record | None:
        """Take what the feed tells; return what has changed by it, None for nothing."""
        is_first, self.is_known = not self.is_known, True
        change = change_between(self.records, update.records)
        self.update = update
        self.events.extend(update.events)
        if not change and not update.events:
            return None
        self.revision += 1
        fresh = {name: list(each.values()) for name, each in change.fresh._asdict().items()}
        change_record = {
            "revision": self.revision, **fresh, "gone": change.gone, "events": list(update.events),
        }  # fmt: skip
        if is_first:
            change_record["time"] = self.past.begin(update.records, self.revision)
            for call in self.when_begun:
                call()
        else:
            self.past.stamp(change_record)
        return change_record

    def add_earlier(self, events: Sequence[Record]) -> None:
        """Know events that happened before all others, as far as there is room."""
        room = _KEPT_EVENTS - len(self.events)
        self.events.extendleft(reversed(events[-room:] if room else ()))

    def picture(self) -> Record:
        """Return everything that is known now."""
        records = {name: list(each.values()) for name, each in self.records._asdict().items()}
        return {
            "revision": self.revision,
            "host": self.host,
            "version": __version__,
            "read_only": self.is_read_only,
            "jobs": self.jobs.records(),
            "since": self.past.since,
            **records,
        }

    def check_change(self) -> None:
        """Return if something may be changed.

        Raises:
            Denied: The page is read-only.
        """
        if self.is_read_only:
            raise Denied("this page is read-only")
