"""Progress of work at hosts: the step that is done, and how much of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

_PARTS = 4
"""How often a step that counts is shown anew by lines."""


class HostStep(NamedTuple):
    """A step, ``sending 12 of 35 MB``; a `total` of 0 stands for a step that does not count."""

    text: str
    done: int = 0
    total: int = 0
    unit: str = ""

    def __str__(self) -> str:
        if not self.total:
            return self.text
        if self.unit == "MB":
            return f"{self.text} {self.done / 1e6:.1f} of {self.total / 1e6:.1f} MB"
        return f"{self.text} {self.done} of {self.total} {self.unit}"


Progress = Callable[[str, HostStep], object]
"""Is shown the host, and the step that begins or goes on there."""


def unshown(_host: str, _step: HostStep) -> None:
    """Show no progress."""


def by_lines(notify: Callable[[str], object]) -> Progress:
    """Return what tells progress by lines: each step as it begins, one that counts by quarters."""
    shown: dict[str, tuple[str, int]] = {}

    def show(host: str, step: HostStep) -> None:
        at = step.text, step.total and _PARTS * step.done // step.total
        if shown.get(host) != at:
            shown[host] = at
            notify(f"{host}: {step}")

    return show
