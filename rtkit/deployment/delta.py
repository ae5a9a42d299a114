"""Deltas: the numbered changes of a manager's facts, and the snapshot that a subscriber keeps.

A subscriber takes one full snapshot and then receives deltas, which are numbered. So it knows at
any time what the manager knows. A gap in the numbers shows a lost delta, and the subscriber takes
a new snapshot.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeVar

from rtkit.deployment.facts import ComponentFacts, Followed, ProcessFacts, Snapshot
from rtkit.fast_dataclass import dataclass, replace
from rtkit.rtc.profiles import ConnectorProfile

TREE = "tree"
"""The line on which news of the tree are told."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Delta:
    """Changes since the delta of the number before.

    Attributes:
        run: The life of the manager in which this is sent.
        number: Counts the deltas of that life.
        time: When it was sent [s since 1970].
        components: Those that are new or other than before.
        gone: Instance names of those that are not there any more.
        connectors: Those that were made or changed.
        cut: Ids of those that are not there any more.
        processes: Those that are new or other than before.
        ended: Pids of those that are not there any more.
        names: Paths of the manager itself, when those have changed.
        systems: All that are followed, when one of them has changed.
        is_last: The manager ends; none follow.
    """

    run: str
    number: int
    time: float = 0.0
    components: tuple[ComponentFacts, ...] = ()
    gone: tuple[str, ...] = ()
    connectors: tuple[ConnectorProfile, ...] = ()
    cut: tuple[str, ...] = ()
    processes: tuple[ProcessFacts, ...] = ()
    ended: tuple[int, ...] = ()
    names: tuple[str, ...] | None = None
    systems: tuple[Followed, ...] | None = None
    is_last: bool = False


@dataclass(frozen=True, slots=True)
class FullSnapshot:
    """Everything that a manager knows, and the number of the last delta in it."""

    run: str
    number: int
    facts: Snapshot


class LiveFacts:
    """Facts of a manager that deltas change, each at what it changes, however many there are.

    Attributes:
        components: By instance name.
        connectors: By id.
        processes: By pid.
        systems: That are followed.
    """

    def __init__(self, snapshot: Snapshot) -> None:
        self._snapshot: Snapshot | None = snapshot
        self._begin = snapshot
        self.components = {each.instance: each for each in snapshot.components}
        self.connectors = {each.connector_id: each for each in snapshot.connectors}
        self.processes = {each.pid: each for each in snapshot.processes}
        self._names, self.systems = snapshot.names, snapshot.systems

    @property
    def snapshot(self) -> Snapshot:
        """All of them as they are now."""
        if self._snapshot is None:
            self._snapshot = replace(
                self._begin,
                components=tuple(self.components.values()),
                connectors=tuple(self.connectors.values()),
                processes=tuple(self.processes.values()),
                names=self._names,
                systems=self.systems,
            )
        return self._snapshot

    def apply(self, delta: Delta) -> None:
        """Change them as a delta says."""
        self._snapshot = None
        _merge(self.components, delta.components, delta.gone, "instance")
        _merge(self.connectors, delta.connectors, delta.cut, "connector_id")
        _merge(self.processes, delta.processes, delta.ended, "pid")
        self._names = self._names if delta.names is None else delta.names
        self.systems = self.systems if delta.systems is None else delta.systems


def delta_between(before: Snapshot, after: Snapshot, run: str, number: int) -> Delta:
    """Return what changed from one moment to another."""
    components, gone = changed(before.components, after.components, "instance")
    connectors, cut = changed(before.connectors, after.connectors, "connector_id")
    processes, ended = changed(before.processes, after.processes, "pid")
    return Delta(
        run,
        number,
        components=components,
        gone=gone,
        connectors=connectors,
        cut=cut,
        processes=processes,
        ended=ended,
        names=after.names if after.names != before.names else None,
        systems=after.systems if after.systems != before.systems else None,
    )


def applied(facts: Snapshot, delta: Delta) -> Snapshot:
    """Return the facts as they are after a delta."""
    live = LiveFacts(facts)
    live.apply(delta)
    return live.snapshot


def changed(
    before: Iterable[T], after: Iterable[T], key: str
) -> tuple[tuple[T, ...], tuple[Any, ...]]:
    """Return the rows that are new or other than before, and the keys of those that are gone."""
    known = {getattr(each, key): each for each in before}
    fresh = []
    for each in after:
        old = known.pop(getattr(each, key), None)
        if old is not each and old != each:
            fresh.append(each)
    return tuple(fresh), tuple(known)


def _merge(known: dict[Any, T], fresh: Iterable[T], gone: Iterable[object], key: str) -> None:
    for name in gone:
        known.pop(name, None)
    for each in fresh:
        known[getattr(each, key)] = each
