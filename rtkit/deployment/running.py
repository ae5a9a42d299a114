"""Plans that start, stop, disconnect and end a wanted system."""

from __future__ import annotations

from rtkit.deployment.actions import ChangeState, Delete, Disconnect
from rtkit.deployment.creation import absence, component_checks
from rtkit.deployment.live import Live, context_of, mismatch
from rtkit.deployment.plan import Plan, Step, layer
from rtkit.deployment.system import System, WantedComponent, WantedConnector
from rtkit.deployment.wiring import address, missing_end
from rtkit.rtc.enums import LifeCycleState, Transition


def start_plan(system: System, live: Live, *, wait: bool = True) -> Plan:
    """Return the activation of every component in each context of its profile, in its order."""
    turns = [(c, number) for c in system.components for number in range(len(c.contexts))]
    steps = [
        _change(turn, component, number, live, Transition.ACTIVATE, wait)
        for turn, (component, number) in enumerate(turns, 1)
    ]
    order = layer("start", steps, is_ordered=True, is_announced=True)
    return Plan(tuple(component_checks(system, live)), order)


def stop_plan(system: System, live: Live, *, wait: bool = True) -> Plan:
    """Return the deactivation of everything, in reverse order; nothing of it is required."""
    turns = [(c, number) for c in system.components for number in range(len(c.contexts))]
    steps = [
        _change(turn, component, number, live, Transition.DEACTIVATE, wait)
        for turn, (component, number) in enumerate(reversed(turns), 1)
    ]
    return Plan(layers=layer("stop", steps, is_ordered=True, is_announced=True))


def teardown_plan(system: System, live: Live, *, ends_components: bool = False) -> Plan:
    """Return the removal of every connection, and of the components in reverse order."""
    ends = reversed(system.components) if ends_components else ()
    return Plan(
        layers=(
            *layer("disconnect", (_removal(wire, system, live) for wire in system.connectors)),
            *layer("exit", (_end(component, live) for component in ends), is_ordered=True),
        )
    )


def active_now(system: System, live: Live) -> str:
    """Tell which components are active, for a user whose start or stop broke off."""
    active = [
        component.path
        for component in system.components
        if (facts := live.at(component.instance)) is not None
        and any(context.state is LifeCycleState.ACTIVE for context in facts.contexts)
    ]
    return f"active now: {', '.join(active) or 'none'}"


def left_now(system: System, live: Live) -> str:
    """Tell what of a system is still there, for a user whose teardown broke off."""
    ids = [wire.profile.connector_id for wire in system.connectors]
    left = [f"connection {id}" for id in ids if live.wire(id) is not None]
    left += [c.path for c in system.components if live.entry(c.instance) is not None]
    return f"left now: {', '.join(left) or 'none'}"


def _change(
    turn: int,
    component: WantedComponent,
    number: int,
    live: Live,
    transition: Transition,
    wait: bool,
) -> Step:
    id = component.contexts[number].id
    verb = transition.value.capitalize()
    text = f"{{{turn}}} {verb} {component.path} in execution context {id}"
    is_required = transition is Transition.ACTIVATE and component.is_required
    facts = live.at(component.instance)
    away = absence(component, live)
    if facts is None or away:
        missing = f"Component missing: {component.path}" if facts is None else away
        return Step(text, None, is_required, missing)
    context = context_of(facts, component, number)
    if context is None:
        why = f"No execution context {id} on component at path {component.path}"
        return Step(text, None, is_required, why)
    action = ChangeState(component.instance, context.id, transition, wait)
    return Step(text, action, is_required)


def _removal(wanted: WantedConnector, system: System, live: Live) -> Step:
    wire = wanted.profile
    source, target = (address(system, end) for end in wire.ports)
    text = f"Disconnect {source} from {target} with ID {wire.connector_id}"
    blocked = missing_end(system, live, wire, ())
    known = live.wire(wire.connector_id)
    if not blocked and (known is None or set(known.ports) != set(wire.ports)):
        blocked = f"No connection from {source} with ID {wire.connector_id}"
    return Step(text, None if blocked else Disconnect(wire.connector_id), blocked=blocked)


def _end(component: WantedComponent, live: Live) -> Step:
    text = f'Exit component "{component.id}", "{component.instance}" at path {component.path}'
    entry = live.entry(component.instance)
    if entry is None:
        return Step(text, None, blocked=f"Component missing: {component.path}")
    blocked = mismatch(component, entry)
    return Step(text, None if blocked else Delete(entry.instance), blocked=blocked)
