"""Start conditions: the order of a system profile, checked, by which its actions start or stop.

`rtkit.deployment.execution` carries them out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rtkit.deployment.described import contexts_of
from rtkit.errors import InvalidDocument
from rtkit.fast_dataclass import dataclass
from rtkit.profile import rts_model as rts

UNORDERED = -1
"""Place of an action of which an order says nothing: before all others."""


class OrderTarget(NamedTuple):
    """A component in one of its execution contexts, by that one's number in the profile."""

    instance: str
    number: int


@dataclass(frozen=True, slots=True)
class StartCondition:
    """One entry of an order: a place, and at most one thing to wait for.

    Attributes:
        sequence: Place among the actions that can be done at the same time.
        wait_ms: Time after the beginning of the delayed part of the plan [ms].
        preceding: The action that comes first; None when there is none.
        is_sync: Wait for the state that it leads to, not only until it was sent.
        timeout_ms: How long to wait for it [ms]; 0 for no bound of its own.
    """

    sequence: int
    wait_ms: int = 0
    preceding: OrderTarget | None = None
    is_sync: bool = True
    timeout_ms: int = 0

    @property
    def is_delaying(self) -> bool:
        """Return whether there is anything to wait for."""
        return self.wait_ms > 0 or self.preceding is not None


Orders = Mapping[OrderTarget, tuple[StartCondition, ...]]
NO_ORDERS: Orders = {}


def sequence_of(conditions: Sequence[StartCondition]) -> int:
    """Return the place of an action that has these conditions."""
    return min((condition.sequence for condition in conditions), default=UNORDERED)


def start_orders(profile: rts.RtsProfile) -> Orders:
    """Return when each component is to be activated.

    Raises:
        InvalidDocument: A target that does not exist, a negative time, or conditions in a circle.
    """
    return _orders(profile.activation, "Activation", profile)


def stop_orders(profile: rts.RtsProfile) -> Orders:
    """Return when each component is to be deactivated; nothing when the profile leaves it open.

    Raises:
        InvalidDocument: A target that does not exist, a negative time, or conditions in a circle.
    """
    return _orders(profile.deactivation, "Deactivation", profile)


def _orders(order: rts.Order | None, name: str, profile: rts.RtsProfile) -> Orders:
    contexts = {
        component.instance_name: tuple(c.id for c in contexts_of(component.execution_contexts))
        for component in profile.components
    }
    found: dict[OrderTarget, tuple[StartCondition, ...]] = {}
    try:
        for entry in order.targets if order is not None else ():
            target = target_of(entry.target_component, contexts)
            found[target] = (*found.get(target, ()), *conditions_of(entry, contexts))
        circle = ring(found)
    except InvalidDocument as error:
        raise InvalidDocument(f"{name}: {error}") from error
    if circle:
        waits = " waits for ".join(named(target, contexts) for target in [*circle, circle[0]])
        raise InvalidDocument(f"{name}: conditions in a circle: {waits}")
    return found


def target_of(entry: rts.TargetComponent, contexts: Mapping[str, Sequence[str]]) -> OrderTarget:
    """Find what an entry names: a context by its id, else by its number.

    Args:
        entry: A target, or what comes before it.
        contexts: The ids of the execution contexts of each component.

    Raises:
        InvalidDocument: There is none.
    """
    name, id = entry.instance_name, entry.id
    ids = contexts.get(name)
    if ids is None:
        raise InvalidDocument(f"unknown target: component {name} is not listed")
    if id in ids:
        return OrderTarget(name, ids.index(id))
    is_number = id.isascii() and id.isdigit() and len(id) < 9
    if is_number and int(id) < len(ids):
        return OrderTarget(name, int(id))
    known = f"it has {', '.join(ids)}" if ids else "it has none"
    raise InvalidDocument(f"unknown target: execution context {id} of component {name} ({known})")


def conditions_of(
    entry: rts.OrderStep, contexts: Mapping[str, Sequence[str]]
) -> Iterator[StartCondition]:
    """Yield what the target of an entry waits for.

    Raises:
        InvalidDocument: Its predecessor does not exist, or a time is negative.
    """
    wait_ms = entry.wait_time.wait_time if entry.wait_time is not None else 0
    preceding = entry.preceding or rts.Preceding()
    timeout_ms = preceding.timeout or 0
    for what, value in (("waitTime", wait_ms), ("timeout", timeout_ms)):
        if value < 0:
            name = entry.target_component.instance_name
            raise InvalidDocument(f"{what} of component {name} is negative: {value}")
    is_sync = preceding.sending_timing in (None, "SYNC")
    for component in preceding.preceding_components:
        first = target_of(component, contexts)
        yield StartCondition(entry.sequence, 0, first, is_sync, timeout_ms)
    if wait_ms or not preceding.preceding_components:
        yield StartCondition(entry.sequence, wait_ms)


def ring(orders: Orders) -> list[OrderTarget]:
    """Return targets each of which waits for the next, the last one for the first; else none."""
    from graphlib import CycleError, TopologicalSorter

    waits = {
        target: [each.preceding for each in conditions if each.preceding is not None]
        for target, conditions in orders.items()
    }
    try:
        TopologicalSorter(waits).prepare()
    except CycleError as error:
        return [*reversed(error.args[1][1:])]
    return []


def named(target: OrderTarget, contexts: Mapping[str, Sequence[str]]) -> str:
    """Return a target in words."""
    ids = contexts[target.instance]
    return target.instance if len(ids) == 1 else f"{target.instance} in {ids[target.number]}"
