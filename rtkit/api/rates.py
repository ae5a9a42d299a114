"""Computes the rates of components from two successive readings of their metrics."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.metrics import (
    METRICS,
    PERIOD_S,
    ComponentMetrics,
    ContextMetrics,
    Metrics,
    ProcessMetrics,
)
from rtkit.rtc.profiles import ExecutionContextProfile

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

_READINGS = 3.0
"""For how many periods rates are waited for at most."""

Rates = Mapping[str, float]


class RateRow(NamedTuple):
    """Rates of one component; unknown or meaningless values are None.

    Attributes:
        path: Where it is in the tree.
        why: What a user should know besides the state: why it is in Error, is no more …
        context: Id of the execution context that is told of.
        asked_hz: Rate of that; None where its kind has none.
        reached_hz: Cycles per second; None where no cycle calls the component.
        mean_s: Time of a cycle [s].
        longest_s: Time of the longest one in the last second [s].
        cpu_percent: Processor time of its whole process, in percent of one processor.
        memory_bytes: Memory of its whole process.
        written_hz: Values per second, by out port.
        read_hz: Values per second, by in port.
        missed_hz: Periods per second at which nothing was done.
        latest_s: How late a cycle began at most in the last second [s].
    """

    path: str
    manager: str
    instance: str
    process: str
    pid: int
    state: str
    why: str
    context: str
    restarts: int
    asked_hz: float | None = None
    reached_hz: float | None = None
    mean_s: float | None = None
    longest_s: float | None = None
    cpu_percent: float | None = None
    memory_bytes: int | None = None
    written_hz: Rates | None = None
    read_hz: Rates | None = None
    missed_hz: float | None = None
    latest_s: float | None = None

    @property
    def out_hz(self) -> float | None:
        """Values written per second, to all out ports; None without any."""
        return sum(self.written_hz.values()) if self.written_hz else None

    @property
    def in_hz(self) -> float | None:
        """Values read per second, from all in ports; None without any."""
        return sum(self.read_hz.values()) if self.read_hz else None


class Totals(NamedTuple):
    """All processes of a manager together; None where it is not known yet."""

    cpu_percent: float | None
    memory_bytes: int


class Rater:
    """Keeps the last metrics of one manager, so that the next give rates."""

    def __init__(self) -> None:
        self._before: Metrics | None = None
        self._now: Metrics | None = None

    @property
    def has_rates(self) -> bool:
        """Return whether there are metrics of two moments."""
        return self._before is not None

    @property
    def is_whole(self) -> bool:
        """Return whether every process has reported its components' metrics both times."""
        both = (self._before, self._now)
        return all(each is not None and all(p.answered for p in each.processes) for each in both)

    def take(self, metrics: Metrics) -> None:
        """Take the next metrics."""
        is_same_run = self._now is not None and self._now.run == metrics.run
        self._before, self._now = self._now if is_same_run else None, metrics

    def totals(self) -> Totals:
        """Return the totals of all processes."""
        used = [
            (_cpu_percent(self._elapsed_s, old, new), new.memory_bytes or 0)
            for _, old, new in self._pairs()
        ]
        known = [cpu for cpu, _ in used if cpu is not None]
        return Totals(sum(known) if known else None, sum(memory for _, memory in used))

    def rows(self, facts: Snapshot, paths: Mapping[str, str]) -> Iterator[RateRow]:
        """Yield a row for each component that has a path, by instance name."""
        pairs = {pid: (old, new) for pid, old, new in self._pairs()}
        pids = {each.name: each.pid for each in facts.processes if each.state != "lost"}
        for component in facts.components:
            if component.instance in paths:
                pid = 0 if component.zombie else pids.get(component.process, 0)
                old, new = pairs.get(pid, (None, None))
                path = paths[component.instance]
                yield self._row(
                    _plain_row(component, path, facts.manager, pid), component, old, new
                )

    @property
    def _elapsed_s(self) -> float:
        if self._now is None or self._before is None:
            return 0.0
        return self._now.at_s - self._before.at_s

    def _pairs(self) -> Iterator[tuple[int, ProcessMetrics | None, ProcessMetrics]]:
        old = {each.pid: each for each in self._before.processes} if self._before else {}
        for new in self._now.processes if self._now is not None else ():
            yield new.pid, old.get(new.pid), new

    def _row(
        self,
        row: RateRow,
        component: ComponentFacts,
        old: ProcessMetrics | None,
        new: ProcessMetrics | None,
    ) -> RateRow:
        if new is None:
            return row
        elapsed_s = self._elapsed_s
        known: dict[str, Any] = {
            "cpu_percent": _cpu_percent(elapsed_s, old, new),
            "memory_bytes": new.memory_bytes,
        }
        before, after = _of(old, component.instance), _of(new, component.instance)
        if before is not None and after is not None and elapsed_s > 0:
            known["written_hz"] = _rates(before.written, after.written, elapsed_s)
            known["read_hz"] = _rates(before.read, after.read, elapsed_s)
            known |= _cycles(_context(before, row.context), _context(after, row.context), elapsed_s)
        return row._replace(**known)


def _plain_row(component: ComponentFacts, path: str, manager: str, pid: int) -> RateRow:
    context = _chosen(component)
    why = (
        component.zombie
        or component.trouble
        or component.cause
        or component.restart_status.trouble
        or component.waits
    )
    return RateRow(
        path,
        manager,
        component.instance,
        component.process,
        pid,
        "Zombie" if component.zombie else component.state,
        why,
        context.id if context else "",
        component.restart_status.restarts,
        asked_hz=context.rate if context is not None and context.rate > 0 else None,
    )


def _chosen(component: ComponentFacts) -> ExecutionContextProfile | None:
    """Return the context that drives a component: one that is running, else the first."""
    running = (context for context in component.contexts if context.is_running)
    return next(running, None) or next(iter(component.contexts), None)


def _of(process: ProcessMetrics | None, instance: str) -> ComponentMetrics | None:
    components = process.components if process is not None else ()
    return next((each for each in components if each.instance == instance), None)


def _context(metrics: ComponentMetrics, id: str) -> ContextMetrics | None:
    return next((each for each in metrics.contexts if each.id == id), None)


def _cycles(
    old: ContextMetrics | None, new: ContextMetrics | None, elapsed_s: float
) -> dict[str, Any]:
    if old is None or new is None or not new.has_work:
        return {}
    ticks = new.ticks - old.ticks
    missed = {"missed_hz": max(0, new.missed - old.missed) / elapsed_s}
    if ticks <= 0:
        return {"reached_hz": 0.0, **missed}
    return {
        **missed,
        "latest_s": new.latest_s,
        "reached_hz": ticks / elapsed_s,
        "mean_s": (new.busy_s - old.busy_s) / ticks,
        "longest_s": new.longest_s,
    }


def _rates(old: Mapping[str, int], new: Mapping[str, int], elapsed_s: float) -> dict[str, float]:
    return {name: max(0, count - old.get(name, 0)) / elapsed_s for name, count in new.items()}


def _cpu_percent(elapsed_s: float, old: ProcessMetrics | None, new: ProcessMetrics) -> float | None:
    if old is None or old.cpu_s is None or new.cpu_s is None or elapsed_s <= 0:
        return None
    return max(0.0, new.cpu_s - old.cpu_s) / elapsed_s * 100


def measured(tree: Tree) -> dict[str, RateRow]:
    """Return the rates of all components of a manager, which takes a second, by instance name.

    Raises:
        Unreachable: It does not answer.
    """
    from rtkit.deployment.delta import TREE
    from rtkit.tree.subscription import ManagerSubscription

    rater, until = Rater(), monotonic() + _READINGS * PERIOD_S
    with ManagerSubscription(tree, (TREE, METRICS)) as subscription:
        while not rater.has_rates and (left := until - monotonic()) > 0:
            for event in subscription.wait(left):
                if isinstance(event, Metrics):
                    rater.take(event)
        facts = subscription.facts
        paths = {each.instance: "" for each in facts.components}
        return {row.instance: row for row in rater.rows(facts, paths)}
