"""Reads crashes that are in no log yet, as records: their manager has not been started since."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.link import places
from rtkit.logs.logbook import LogEntry


def unseen_entries(manager: str) -> Iterator[LogEntry]:
    """Yield the records that the next start of a manager will add to its logs; none if it runs."""
    from rtkit.cli.shared.json_records import time_text
    from rtkit.container.exit_diagnostics import crash_text
    from rtkit.manager.predecessor.crashes import unseen_crashes
    from rtkit.manager.predecessor.unreported import checkpoints_of_the_dead, living_slaves

    if places.owner(manager) is not None:
        return
    dead = checkpoints_of_the_dead(manager, living_slaves(manager))
    for crash in unseen_crashes(manager, dead):
        time = f"{time_text(int(crash.words.time_s * 1e9))[:-4]}Z"
        file = f"{manager}.{crash.slave}" if crash.slave else manager
        for instance in crash.instances or ("",):
            yield LogEntry(
                time,
                file,
                "FATAL",
                crash.slave or manager,
                crash.pid,
                instance,
                "rtkit",
                *crash_text(crash.words),
            )
