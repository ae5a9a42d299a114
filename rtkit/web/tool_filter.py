"""Leaves out what happens to data tools: ten events for a value that somebody writes to a port.

What they do to components is told: their connectors come and go at the ports of these.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtkit.deployment.user_events import UserEvent


class ToolFilter:
    """Knows the processes of the data tools that are attached to one manager."""

    def __init__(self) -> None:
        """Know none yet."""
        self._processes: set[str] = set()

    def of_components(self, events: Sequence[UserEvent]) -> Iterator[UserEvent]:
        """Yield those of some events that are not about data tools, or their processes."""
        self._processes |= {each.process for each in events if each.is_tool}
        for each in events:
            is_process = not each.instance and bool(each.process)
            is_of_tool = is_process and each.process in self._processes
            if is_of_tool and each.event == "PROCESS_ENDED":
                self._processes.discard(each.process)
            if not (each.is_tool or is_of_tool):
                yield each
