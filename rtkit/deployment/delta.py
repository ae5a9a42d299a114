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
    return replace(
        facts,
        components=_merged(facts.components, delta.components, delta.gone, "instance"),
        connectors=_merged(facts.connectors, delta.connectors, delta.cut, "connector_id"),
        processes=_merged(facts.processes, delta.processes, delta.ended, "pid"),
        names=facts.names if delta.names is None else delta.names,
        systems=facts.systems if delta.systems is None else delta.systems,
    )


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


def _merged(
    present: tuple[T, ...], fresh: tuple[T, ...], gone: Iterable[object], key: str
) -> tuple[T, ...]:
    if not fresh and not gone:
        return present
    known = {getattr(each, key): each for each in present}
    for name in gone:
        known.pop(name, None)
    for each in fresh:
        known[getattr(each, key)] = each
    return tuple(known.values())
