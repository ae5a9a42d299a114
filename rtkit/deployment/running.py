"""Plans that start, stop, disconnect and end a wanted system."""

from __future__ import annotations

from rtkit.deployment.actions import ChangeState, Delete, Disconnect
from rtkit.deployment.conditions import NO_ORDERS, Orders, OrderTarget
from rtkit.deployment.creation import component_checks
from rtkit.deployment.layered_plan import LayeredPlan, PlannedAction, layer
from rtkit.deployment.live_index import LiveIndex, absence, context_of, mismatch
from rtkit.deployment.start_schedule import (
    ScheduledAction,
    StartPlan,
    WatchedComponent,
    arrange,
    expected_order,
)
from rtkit.deployment.system import WantedComponent, WantedConnector, WantedSystem, address
from rtkit.deployment.wiring import missing_end
from rtkit.fast_dataclass import replace
from rtkit.rtc.enums import LifeCycleState, Transition


def start_plan(
    system: WantedSystem, live: LiveIndex, orders: Orders = NO_ORDERS, *, wait: bool = True
) -> StartPlan:
    """Return the activation of every component in each context of its profile, as ordered."""
    turns = _turns(system, live, Transition.ACTIVATE, wait)
    return arrange(Transition.ACTIVATE, turns, orders, tuple(component_checks(system, live)))


def stop_plan(
    system: WantedSystem,
    live: LiveIndex,
    orders: Orders = NO_ORDERS,
    *,
    started: Orders = NO_ORDERS,
    wait: bool = True,
) -> StartPlan:
    """Return the deactivation of everything; nothing of it is required.

    Without orders of its own it goes in reverse of the start, whose orders are `started`.
    """
    turns = _turns(system, live, Transition.DEACTIVATE, wait)
    if orders:
        return arrange(Transition.DEACTIVATE, reversed(turns), orders)
    order = expected_order(arrange(Transition.ACTIVATE, turns, started))
    places = {target: place for place, target in enumerate(order)}
    turns.sort(key=lambda turn: places[turn.target], reverse=True)
    return arrange(Transition.DEACTIVATE, turns)


def teardown_plan(
    system: WantedSystem, live: LiveIndex, *, ends_components: bool = False
) -> LayeredPlan:
    """Return the removal of every connection, and of the components in reverse order.

    Where the components end, that something is gone already is just what is wanted.
    """
    ends = reversed(system.components) if ends_components else ()
    removals = [_removal(connector, system, live) for connector in system.connectors]
    if ends_components:
        removals = [replace(step, blocked="", holds=step.action is None) for step in removals]
    return LayeredPlan(
        layers=(
            *layer("disconnect", removals),
            *layer("exit", (_end(component, live) for component in ends), is_ordered=True),
        )
    )


def active_now(system: WantedSystem, live: LiveIndex) -> str:
    """Report which components are active, for a user whose start or stop broke off."""
    active = [
        component.path
        for component in system.components
        if (facts := live.at(component.instance)) is not None
        and any(context.state is LifeCycleState.ACTIVE for context in facts.contexts)
    ]
    return f"active now: {', '.join(active) or 'none'}"


def left_now(system: WantedSystem, live: LiveIndex) -> str:
    """Report what of a system is still there, for a user whose teardown broke off."""
    ids = [connector.profile.connector_id for connector in system.connectors]
    left = [f"connection {id}" for id in ids if live.connector(id) is not None]
    left += [c.path for c in system.components if live.entry(c.instance) is not None]
    return f"left now: {', '.join(left) or 'none'}"


def _turns(
    system: WantedSystem, live: LiveIndex, transition: Transition, wait: bool
) -> list[ScheduledAction]:
    return [
        _turn(component, number, live, transition, wait)
        for component in system.components
        for number in range(len(component.contexts))
    ]


def _turn(
    component: WantedComponent, number: int, live: LiveIndex, transition: Transition, wait: bool
) -> ScheduledAction:
    id = component.contexts[number].id
    facts = live.at(component.instance)
    context = context_of(facts, component, number) if facts is not None else None
    name = component.path
    if len(component.contexts) > 1:
        name += f" in execution context {id}"
    watched = WatchedComponent(
        facts.instance if facts is not None else component.instance,
        context.id if context is not None else id,
    )
    text = f"{transition.value.capitalize()} {component.path} in execution context {id}"
    is_required = transition is Transition.ACTIVATE and component.is_required
    blocked = absence(component, live)
    if facts is None:
        blocked = f"Component missing: {component.path}"
    elif not blocked and context is None:
        blocked = f"No execution context {id} on component at path {component.path}"
    action = None
    if not blocked:
        action = ChangeState(watched.instance, watched.context, transition, wait)
    step = PlannedAction(text, action, is_required, blocked, where=component.path)
    return ScheduledAction(OrderTarget(component.instance, number), name, watched, step)


def _removal(wanted: WantedConnector, system: WantedSystem, live: LiveIndex) -> PlannedAction:
    connector = wanted.profile
    source, target = (address(system, end) for end in connector.ports)
    text = f"Disconnect {source} from {target} with ID {connector.connector_id}"
    blocked = missing_end(system, live, connector, ())
    known = live.connector(connector.connector_id)
    if not blocked and (known is None or set(known.ports) != set(connector.ports)):
        blocked = f"No connection from {source} with ID {connector.connector_id}"
    return PlannedAction(
        text, None if blocked else Disconnect(connector.connector_id), blocked=blocked
    )


def _end(component: WantedComponent, live: LiveIndex) -> PlannedAction:
    text = f'Exit component "{component.id}", "{component.instance}" at path {component.path}'
    entry = live.entry(component.instance)
    if entry is None:
        return PlannedAction(text, None, holds=True)
    blocked = mismatch(component, entry)
    return PlannedAction(text, None if blocked else Delete(entry.instance), blocked=blocked)
