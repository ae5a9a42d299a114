"""Metrics of components and processes: counters since the start, reported once a second.

Metrics are counters, so a lost report costs detail only: rates are differences.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.fast_dataclass import dataclass, field

METRICS = "figures"
"""The topic on which metrics are sent."""

PERIOD_S = 1.0
"""How often [s]."""


@dataclass(frozen=True, slots=True)
class ContextMetrics:
    """Metrics of a component in one of its execution contexts.

    Attributes:
        has_work: Whether a cycle calls it: it is Active and has something to execute.
        is_running: Whether the context is.
        ticks: Cycles of the context.
        busy_s: Time that they took together [s].
        longest_s: Time of the longest one since the last metrics [s].
        missed: Periods at which nothing was done.
        latest_s: How late a cycle began at most since the last metrics [s].
    """

    id: str
    has_work: bool
    is_running: bool
    ticks: int
    busy_s: float
    longest_s: float
    missed: int = 0
    latest_s: float = 0.0


@dataclass(frozen=True, slots=True)
class ComponentMetrics:
    """Metrics of a component.

    Attributes:
        written: Values written to each out port.
        read: Values read from each in port.
    """

    instance: str
    contexts: tuple[ContextMetrics, ...] = ()
    written: Mapping[str, int] = field(default_factory=dict)
    read: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ProcessMetrics:
    """Metrics of a process.

    Attributes:
        answered: Whether it reported its components' metrics; else there are none.
        cpu_s: Processor time that it used [s]; None where the kernel does not report it.
        memory_bytes: Memory that it occupies; None likewise.
    """

    pid: int
    name: str
    answered: bool
    components: tuple[ComponentMetrics, ...] = ()
    cpu_s: float | None = None
    memory_bytes: int | None = None


@dataclass(frozen=True, slots=True)
class Metrics:
    """All metrics of a manager, at one moment.

    Attributes:
        run: The life of the manager in which this is sent.
        number: Counts the metrics of that life.
        time: When they were sent [s since 1970].
        at_s: The same, monotonic [s]; for differences.
    """

    run: str
    number: int
    processes: tuple[ProcessMetrics, ...]
    time: float = 0.0
    at_s: float = 0.0
