"""Follows all managers on a thread of its own, and publishes changes: records, rates, notices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from threading import Thread
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple

from rtkit.api.live_records import (
    KnownManager,
    KnownRights,
    Record,
    SystemRecords,
    records_of,
)
from rtkit.api.observers import ManagerSeen, ObservedEvent, Observers, place_of
from rtkit.api.rates import Rater
from rtkit.deployment.delta import TREE
from rtkit.deployment.metrics import METRICS, Metrics
from rtkit.errors import RtkitError
from rtkit.link.places import host_name
from rtkit.link.wakeup import Wakeup
from rtkit.rtc.manager_address import is_address
from rtkit.tree.subscription import SubscriptionEnded
from rtkit.web.tool_filter import ToolFilter

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.deployment.user_events import UserEvent

_REST = 4.0
"""After a look at a large system changes are gathered for so many times what the look took."""


class FeedUpdate(NamedTuple):
    """All that the feed publishes at once.

    Attributes:
        records: All that is known now.
        managers: Those that are known, with their facts.
        events: What happened, as ``rtwatch --json`` has it.
        rates: Rates of connectors and components; None where no metrics have come.
    """

    records: SystemRecords
    managers: Sequence[KnownManager]
    events: Sequence[Record]
    rates: Record | None


class SeenAt(NamedTuple):
    """Place of a manager, as `KnownManager` has it."""

    name: str
    place: str
    is_usual: bool


class SystemFeed:
    """The thread that follows; `close` ends it."""

    def __init__(
        self,
        session: Session,
        publish: Callable[[FeedUpdate], None],
        notice: Callable[[str], None],
        fail: Callable[[Exception], None],
    ) -> None:
        """Begin, once `start` is called.

        Args:
            session: Of the command; nobody else uses it from then on.
            publish: Called on the thread with what is new.
            notice: Called on the thread with what the user should know.
            fail: Called on the thread when it ends though nobody has asked for that.
        """
        self._session = session
        self._publish = publish
        self._notice = notice
        self._fail = fail
        self._host = host_name()
        self._records = SystemRecords.nothing()
        self._known: dict[str, KnownManager] = {}
        self._ended: dict[str, KnownManager] = {}
        self._rights: dict[str, KnownRights | None] = {}
        self._gathered: list[Record] = []
        self._due: float | None = None
        self._free_at = 0.0
        self._raters: dict[str, Rater] = {}
        self._tools: dict[str, ToolFilter] = {}
        self._ending = Wakeup()
        self._thread = Thread(target=self._run, name="feed", daemon=True)

    def start(self) -> None:
        """Begin to follow."""
        self._thread.start()

    def close(self) -> None:
        """Follow no more."""
        self._ending.ring()
        self._thread.join()
        self._ending.close()

    def _run(self) -> None:
        lines = (TREE, METRICS)
        try:
            with Observers(
                self._session, lines, is_wide=True, has_hosts=True, is_patient=True
            ) as observers:
                if observers.why is not None:
                    self._notice(f"{observers.why}; waiting for it")
                self._look(observers)
                self._publish_all(None)
                self._follow(observers)
        except Exception as error:
            self._fail(error)

    def _follow(self, observers: Observers) -> None:
        for events in observers.listen(None, (self._ending.fileno(),), lambda: self._due):
            if self._ending.hush():
                return
            self._gathered += [
                each for event in events for each in self._happened(observers, event)
            ]
            # Of a manager that has gone nothing flows any more.
            has_rates = any(isinstance(e.event, Metrics | SubscriptionEnded) for e in events)
            has_news = not all(isinstance(each.event, Metrics) for each in events)
            if self._due is None and (has_news or self._is_old(observers)):
                self._due = self._free_at
            if self._due is not None and monotonic() >= self._due:
                self._look(observers)
                self._publish_all(None)
            if has_rates:
                self._publish_all(self._rates())

    def _is_old(self, observers: Observers) -> bool:
        """Return whether a manager has told what is no event, as whom a context drives."""
        return any(
            name in self._known and self._known[name].facts is not subscription.facts
            for name, subscription in observers.subscriptions.items()
        )

    def _happened(self, observers: Observers, observed: ObservedEvent) -> Iterator[Record]:
        """Yield the records of an event; note what it says of the manager itself."""
        name, event = observed
        if isinstance(event, Metrics):
            self._raters.setdefault(name, Rater()).take(event)
        elif isinstance(event, ManagerSeen):
            self._ended.pop(name, None)
            self._notice(str(event))
        elif isinstance(event, SubscriptionEnded):
            self._note_end(name, event)
        else:
            where = SeenAt(observers.names[name], observers.places[name], not name)
            tools = self._tools.setdefault(name, ToolFilter())
            for each in tools.of_components(event.user_events):
                yield event_record(each, event.time, where, self._host)

    def _note_end(self, name: str, end: SubscriptionEnded) -> None:
        self._raters.pop(name, None)
        self._rights.pop(name, None)  # it comes back by the certificate that is there then
        last = self._known.pop(name, None)
        if last is not None and not end.is_orderly:
            self._ended[name] = last._replace(why=end.why)
        self._notice(f"{end.why}; waiting for it to come back")

    def _publish_all(self, rates: Record | None) -> None:
        managers = (*self._known.values(), *self._ended.values())
        events, self._gathered = self._gathered, []
        self._publish(FeedUpdate(self._records, managers, events, rates))

    def _look(self, observers: Observers) -> None:
        """Make all records anew, so seldom that it takes a small part of the time only."""
        began = monotonic()
        self._known = {
            name: KnownManager(
                observers.names[name],
                observers.places[name],
                not name,
                subscription.facts,
                rights=self._rights_at(name, observers.places[name]),
            )
            for name, subscription in observers.subscriptions.items()
        }
        managers = [*self._known.values(), *self._ended.values()]
        self._records = records_of(managers, self._host)
        now = monotonic()
        self._due = None
        self._free_at = now + _REST * (now - began)

    def _rights_at(self, name: str, place: str) -> KnownRights | None:
        """Return what the user is at a manager; the certificate is read once a connection."""
        if name not in self._rights:
            self._rights[name] = _own_rights() if is_address(place) else None
        return self._rights[name]

    def _rates(self) -> Record:
        """Return the rate of each connector, that of its out port, and of each component."""
        components: Record = {}
        written: dict[tuple[str, str], float] = {}
        for name, manager in self._known.items():
            rater = self._raters.get(name)
            if rater is None or not rater.has_rates:
                continue
            paths = {c.instance: manager.path(c, self._host) for c in manager.facts.components}
            for row in rater.rows(manager.facts, paths):
                load = row.mean_s * row.reached_hz if row.mean_s and row.reached_hz else None
                components[row.path] = {"hz": row.reached_hz, "load": load}
                written |= {(row.path, port): hz for port, hz in (row.written_hz or {}).items()}
        ends = (
            (id, (each["source"]["component"], each["source"]["port"]))
            for id, each in self._records.connectors.items()
        )
        return {
            "components": components,
            "connectors": {id: {"hz": written[end]} for id, end in ends if end in written},
        }


def event_record(event: UserEvent, time: float, where: SeenAt, host: str) -> Record:
    """Return an event of a manager as ``rtwatch --json`` has it."""
    is_usual, local = where.is_usual, where.place
    return {
        "time": time,
        "kind": event.kind,
        "path": place_of(where.name, event, host, is_usual=is_usual, local=local),
        "subject": event.subject,
        "event": event.event,
        "detail": event.detail,
    }


def _own_rights() -> KnownRights | None:
    """Return what the certificate of this user says; None if it cannot be read any more."""
    from rtkit.keys.authority import own

    try:
        shown = own()
    except RtkitError:
        return None  # it was changed since the connection was made; what is denied is told
    return KnownRights(shown.name, shown.role)
