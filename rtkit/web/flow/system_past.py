"""Tells what all managers held before the server began to look: a process of its own.

It reads which managers there are, asks each for its last events, and writes the picture before the
first of them and all changes since, as the server tells changes. It takes time that the server has
not.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping, Sequence
from heapq import merge
from itertools import islice
from math import ceil
from time import monotonic
from typing import NamedTuple

from rtkit.api.live_records import (
    KnownManager,
    Record,
    SystemRecords,
    change_between,
    records_of,
)
from rtkit.errors import RtkitError
from rtkit.tree.connect import connect
from rtkit.web.feed import SeenAt, event_record
from rtkit.web.flow.manager_past import PastFacts, past_of
from rtkit.web.tool_filter import ToolFilter

_TIMEOUT_S = 10.0
_BOUND_S = 5.0
"""About how long the records of all moments may take; of large systems moments are put together."""


class AskedManager(NamedTuple):
    """A manager whose past is wanted.

    Attributes:
        address: What `connect` takes for it.
        where: Where paths lead to it.
    """

    address: str
    where: SeenAt

    def known(self, past: PastFacts) -> KnownManager:
        """Return it as it was."""
        return KnownManager(*self.where, past.facts)


def main() -> int:
    """Read the question from stdin and write the answer to stdout; return the exit status."""
    # Nothing waits for this: what controls, and what is looked at, goes first.
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    asked = json.load(sys.stdin)
    managers = [AskedManager(address, SeenAt(*where)) for address, where in asked["managers"]]
    try:
        answer = changes_of(managers, asked["host"], asked["until"])
    except RtkitError as error:
        print(error, file=sys.stderr)
        return 1
    json.dump(answer, sys.stdout, allow_nan=False)
    return 0


def changes_of(managers: Sequence[AskedManager], host: str, until: float) -> Record:
    """Return since when all managers are known, what was then, and what changed until a moment.

    Raises:
        RtkitError: The past of one is not known: then that of the whole system is not.
    """
    pasts = []
    for each in managers:
        with connect(each.address, _TIMEOUT_S) as tree:
            pasts.append(past_of(tree.dump()))
    first = min(past.steps[0].time for past in pasts)
    since = min(until, max(first, *(past.since for past in pasts)))
    present: dict[AskedManager, KnownManager] = {}
    rows = ([(each.time, number, each) for each in past.steps] for number, past in enumerate(pasts))
    steps = [row for row in merge(*rows, key=lambda row: row[:2]) if row[0] < until]
    later = [row for row in steps if row[0] > since]
    for _, number, step in steps[: len(steps) - len(later)]:
        present[managers[number]] = managers[number].known(step)
    began = monotonic()
    before = records = records_of(list(present.values()), host)
    each_s = max(monotonic() - began, 1e-4)
    size = max(1, ceil(len(later) * each_s / _BOUND_S))
    tools = [ToolFilter() for _ in managers]
    changes: list[Record] = []
    rest = iter(later)
    while group := list(islice(rest, size)):
        events = []
        for time, number, step in group:
            manager = managers[number]
            present[manager] = manager.known(step)
            of_components = tools[number].of_components(step.events)
            events += [event_record(each, time, manager.where, host) for each in of_components]
        after = records_of(list(present.values()), host)
        changes.append({"time": group[-1][0], **_changed(records, after), "events": events})
        records = after
    return {"since": since, "before": _lists(before), "after": _lists(records), "changes": changes}


def _changed(before: SystemRecords, after: SystemRecords) -> Record:
    change = change_between(before, after)
    return {**_lists(change.fresh), "gone": change.gone}


def _lists(records: SystemRecords) -> Mapping[str, list[Record]]:
    return {name: list(each.values()) for name, each in records._asdict().items()}


if __name__ == "__main__":
    sys.exit(main())
