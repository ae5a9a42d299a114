"""Activity of components: their metrics and states, as the managers of some places report them."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.api.observers import Observers, is_covered, place_of
from rtkit.api.rates import Rater, RateRow
from rtkit.cli.observing.top.page import memory, short
from rtkit.cli.shared.app import App
from rtkit.report.finding import counted
from rtkit.rtc.names import LOCAL

if TYPE_CHECKING:
    from rtkit.api.observers import ObservedEvent
    from rtkit.tree.scope import Scope

SILENT_S = 3.0
"""Time without metrics after which the page calls them old [s]."""


class Top:
    """Metrics and states of the components of some managers.

    Attributes:
        subscriptions: Subscriptions to the managers.
        time: Time of the last metrics [s since 1970].
        received_at: Time of their arrival, monotonic [s].
    """

    def __init__(self, app: App, subscriptions: Observers, scopes: Sequence[Scope]) -> None:
        self.app = app
        self.subscriptions = subscriptions
        self.time = time.time()
        self.received_at = time.monotonic()
        self._scopes = scopes
        self._host = app.tree.host
        self._raters: dict[str, Rater] = {}

    def take(self, events: Sequence[ObservedEvent]) -> bool:
        """Take events in; return whether there were metrics among them."""
        from rtkit.deployment.metrics import Metrics

        has_metrics = False
        for manager, event in events:
            if isinstance(event, Metrics):
                self._raters.setdefault(manager, Rater()).take(event)
                self.time, has_metrics = event.time, True
                self.received_at = time.monotonic()
        for manager in list(self._raters):
            if manager not in self.subscriptions.subscriptions:
                del self._raters[manager]
        return has_metrics

    @property
    def has_rates(self) -> bool:
        """Return whether all managers have reported metrics twice."""
        raters = self._raters
        return bool(raters) and all(
            name in raters and raters[name].has_rates for name in self.subscriptions.subscriptions
        )

    @property
    def is_whole(self) -> bool:
        """Return whether every process has answered both times."""
        return all(rater.is_whole for rater in self._raters.values())

    def rows(self) -> list[RateRow]:
        """Return a row for each component."""
        return [row for name in self.subscriptions.subscriptions for row in self._rows(name)]

    def _rows(self, manager: str) -> Iterator[RateRow]:
        facts = self.subscriptions.subscriptions[manager].facts
        place = self.subscriptions.places[manager]
        paths = {
            each.instance: place_of(
                facts.manager, each, self._host, is_usual=not manager, local=place
            )
            for each in facts.components
            if is_covered(self._scopes, manager, each, self._host)
        }
        shown = {instance: path.removeprefix(f"/{LOCAL}/") for instance, path in paths.items()}
        yield from self._raters.setdefault(manager, Rater()).rows(facts, shown)

    def summary(self, rows: Sequence[RateRow]) -> str:
        """Return one line about all of it."""
        states = Counter(row.state for row in rows)
        counts = ", ".join(f"{count} {state}" for state, count in sorted(states.items()))
        totals = [rater.totals() for rater in self._raters.values()]
        cpu = [each.cpu_percent for each in totals if each.cpu_percent is not None]
        size = sum(each.memory_bytes for each in totals)
        used = f"CPU {short(sum(cpu) if cpu else None)}%  memory {memory(size)}"
        clock = time.strftime("%H:%M:%S", time.localtime(self.time))
        many = counted(len(rows), "component")
        silent_s = time.monotonic() - self.received_at
        late = f"  (no figures for {silent_s:.0f} s)" if silent_s > SILENT_S else ""
        return f"{clock}{late}  {many}{': ' * bool(counts)}{counts}  {used}"
