"""Checks orders (Activation …): conditions that name nothing, or go in a circle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rtkit.deployment.conditions import (
    OrderTarget,
    StartCondition,
    conditions_of,
    named,
    ring,
    target_of,
)
from rtkit.deployment.described import contexts_of
from rtkit.errors import InvalidDocument
from rtkit.profile.rts_model import Order
from rtkit.profile.rts_spec import ORDERS
from rtkit.report.finding import ERROR
from rtkit.static_check.finding import TOP, ProfileLocation, StaticFinding
from rtkit.static_check.view import View

_MOST = 100  # circles of one order that are reported
_NAMES = 20  # of a circle that are shown
_Orders = dict[OrderTarget, tuple[StartCondition, ...]]


def order_findings(view: View) -> Iterator[StaticFinding]:
    """Yield what is wrong with the orders."""
    contexts = {
        part.name: tuple(each.id for each in contexts_of(part.component.execution_contexts))
        for part in view.parts
    }
    for field, name in ORDERS:
        order = getattr(view.profile, field)
        if order is not None:
            yield from _order(order, name, TOP.below(field), contexts)


def _order(
    order: Order, name: str, place: ProfileLocation, contexts: Mapping[str, Sequence[str]]
) -> Iterator[StaticFinding]:
    found: _Orders = {}
    bounded: list[tuple[OrderTarget, StartCondition, ProfileLocation]] = []
    places: dict[OrderTarget, ProfileLocation] = {}
    for number, entry in enumerate(order.targets):
        where = place.below("targets", number)
        try:
            target = target_of(entry.target_component, contexts)
            conditions = tuple(conditions_of(entry, contexts))
        except InvalidDocument as error:
            yield StaticFinding(ERROR, "condition-target", f"{name}: {error}", where)
            continue
        found[target] = (*found.get(target, ()), *conditions)
        limit = where.below("preceding").at("timeout")
        bounded += [(target, each, limit) for each in conditions if each.timeout_ms]
        places.setdefault(target, where)
    for _ in range(_MOST):
        circle = ring(found)
        if not circle:
            break
        waits = _waits_text([named(target, contexts) for target in [*circle, circle[0]]])
        text = f"{name}: conditions in a circle: {waits}"
        yield StaticFinding(ERROR, "condition-circle", text, places[circle[0]], waits)
        apart = set(circle)
        for target in circle:
            found[target] = tuple(c for c in found[target] if c.preceding not in apart)
    else:
        return
    first = _earliest_ms(found)
    for target, condition, where in bounded:
        assert condition.preceding is not None
        beginning = first.get(condition.preceding, 0)
        if beginning + condition.is_sync > condition.timeout_ms:
            waiting, other = named(target, contexts), named(condition.preceding, contexts)
            text = (
                f"{name}: {waiting} waits at most {condition.timeout_ms} ms for {other}, whose turn"
                f" comes after {beginning} ms"
            )
            allowed = f"more than {beginning}, or 0 for no bound"
            found_ms = str(condition.timeout_ms)
            yield StaticFinding(ERROR, "condition-wait", text, where, found_ms, allowed)


def _earliest_ms(orders: _Orders) -> dict[OrderTarget, int]:
    """Return when each target's turn comes if nothing takes time [ms]; orders have no circle."""
    from graphlib import TopologicalSorter

    before = {
        target: [c.preceding for c in conditions if c.preceding is not None]
        for target, conditions in orders.items()
    }
    first: dict[OrderTarget, int] = {}
    for target in TopologicalSorter(before).static_order():
        waits = [c.wait_ms for c in orders.get(target, ())]
        first[target] = max([0, *waits, *(first[each] for each in before.get(target, ()))])
    return first


def _waits_text(names: list[str]) -> str:
    if len(names) > _NAMES:
        half = _NAMES // 2
        names = [*names[:half], f"… {len(names) - 2 * half} more …", *names[-half:]]
    return " waits for ".join(names)
