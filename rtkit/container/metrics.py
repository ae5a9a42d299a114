"""Collects metrics of the components of a process, on request; it keeps none."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rtkit.component.base import Component
from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.container.pacer import Work
from rtkit.deployment.metrics import ComponentMetrics, ContextMetrics
from rtkit.rtc.serde import encode

Worked = Callable[[ExecutionContext], Work]
"""Returns what a context has done so far."""


def metrics_of(components: Iterable[Component], worked: Worked) -> list[Any]:
    """Return the metrics of components in their transport form."""
    return [encode(_metrics(component, worked)) for component in components]


def _metrics(component: Component, worked: Worked) -> ComponentMetrics:
    contexts = tuple(
        _context(component, context, worked(context)) for context in component.participations
    )
    ports = component.ports.values()
    return ComponentMetrics(
        component.instance,
        contexts,
        {port.name: port.written for port in ports if isinstance(port, OutPort)},
        {port.name: port.read_count for port in ports if isinstance(port, InPort)},
    )


def _context(component: Component, context: ExecutionContext, work: Work) -> ContextMetrics:
    return ContextMetrics(
        context.handle_for(component),
        context.has_work_for(component),
        context.is_running,
        work.ticks,
        work.busy_ns / 1e9,
        work.longest_ns / 1e9,
        context.missed,
        work.latest_ns / 1e9,
    )
