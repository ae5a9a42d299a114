"""Plans the second half of a recovery: connections, parameters, active sets."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rtkit.deployment import drift
from rtkit.deployment.actions import (
    MISSING,
    ActivateSet,
    Connect,
    SetParameters,
    SetPolicy,
    SetRate,
)
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.layered_plan import LayeredPlan, PlannedAction, layer
from rtkit.deployment.live_index import LiveIndex, absence
from rtkit.deployment.system import HIDDEN, WantedComponent, WantedConnector, WantedSystem, address
from rtkit.rtc.connector_properties import differing
from rtkit.rtc.profiles import ConnectorProfile


def wiring_plan(
    system: WantedSystem, live: LiveIndex, pending: Collection[str] = ()
) -> LayeredPlan:
    """Return what makes living components the wanted system; `pending` are those to be made."""
    data = [connector for connector in system.connectors if connector.is_data]
    service = [connector for connector in system.connectors if not connector.is_data]
    settings = [s for c in system.components for s in _parameters(c, live, pending)]
    settings += [s for c in system.components for s in _supervision(c, live, pending)]
    active = [s for c in system.components for s in _active_set(c, live, pending)]
    return LayeredPlan(
        layers=(
            *layer(
                "connect", (_connection(connector, system, live, pending) for connector in data)
            ),
            *layer(
                "connect", (_connection(connector, system, live, pending) for connector in service)
            ),
            *layer("configure", settings),
            *layer("activate sets", active),
        )
    )


def missing_end(
    system: WantedSystem, live: LiveIndex, connector: ConnectorProfile, pending: Collection[str]
) -> str:
    """Return which end of a connection is not there; empty when both are."""
    for word, end in zip(("Source", "Destination"), connector.ports, strict=True):
        if end.instance in pending:
            continue
        component = system.component(end.instance)
        why = absence(component, live)
        if why:
            is_there = live.at(end.instance) is not None
            return why if is_there else f"{word} component missing: {component.path}"
        facts = live.at(end.instance)
        if facts is not None and facts.port(end.port) is None:
            return f"{word} port missing: {address(system, end)}"
    return ""


def is_same_connector(known: ConnectorProfile | None, connector: ConnectorProfile) -> bool:
    """Return whether a connection exists just as wanted."""
    if known is None or set(known.ports) != set(connector.ports):
        return False
    return not differing(connector.properties, known.properties)


def _connection(
    wanted: WantedConnector, system: WantedSystem, live: LiveIndex, pending: Collection[str]
) -> PlannedAction:
    connector = wanted.profile
    source, target = (address(system, end) for end in connector.ports)
    text = (
        f"Connect {source} to {target} with ID {connector.connector_id}"
        f" and properties {dict(connector.properties)}"
    )
    blocked = missing_end(system, live, connector, pending)
    is_free = not {end.instance for end in connector.ports} & set(pending)
    holds = (
        not blocked
        and is_free
        and is_same_connector(live.connector(connector.connector_id), connector)
    )
    action = None if blocked or holds else Connect(connector)
    return PlannedAction(text, action, wanted.is_required, blocked, holds, f"{source} to {target}")


def _parameters(
    component: WantedComponent, live: LiveIndex, pending: Collection[str]
) -> Iterator[PlannedAction]:
    facts = live.at(component.instance)
    away = "" if component.instance in pending else absence(component, live)
    for set_id, values in component.sets.items():
        for name, value in values.items():
            text = (
                f'Set parameter "{name}" in set "{set_id}" on component'
                f' at path {component.path} to "{value}"'
            )
            if set_id.startswith(HIDDEN):
                # Hints that the component gives of itself: a profile keeps them, and no more.
                yield PlannedAction(text, None, holds=True)
            elif component.instance in pending:
                made_so = component.pattern is not None
                wanted = SetParameters(component.instance, set_id, {name: value}, _adds(set_id))
                action = None if made_so else wanted
                yield PlannedAction(text, action, holds=made_so, where=component.path)
            elif away or facts is None:
                yield PlannedAction(text, None, blocked=away)
            else:
                wanted = SetParameters(facts.instance, set_id, {name: value}, _adds(set_id))
                yield _parameter(text, facts, wanted, component.path)


def _adds(set_id: str) -> str:
    """Return whether a set is added that a component has not: every one has the default set."""
    return "" if set_id == "default" else MISSING


def _parameter(text: str, facts: ComponentFacts, wanted: SetParameters, path: str) -> PlannedAction:
    from rtkit.component.configuration.constraint_check import no_parameter, parameter_names

    ((name, value),) = wanted.values.items()
    present = facts.sets.get(wanted.set_id)
    known = parameter_names(facts.sets) if present is None else present
    if name not in known:
        return PlannedAction(text, None, blocked=no_parameter(name, known, path))
    if present is not None and present[name] == value:
        return PlannedAction(text, None, holds=True)
    return PlannedAction(text, wanted, where=path)


def _supervision(
    component: WantedComponent, live: LiveIndex, pending: Collection[str]
) -> Iterator[PlannedAction]:
    """Yield rates of contexts and the policy, where they are other or not known yet."""
    facts = live.at(component.instance)
    if component.instance in pending:
        pairs = zip(component.contexts, component.rates, strict=True)
        left = [(context.id, rate) for context, rate in pairs if rate and component.pattern is None]
        policy = None  # the create string states it
    elif facts is None or absence(component, live):
        return
    else:
        rates = drift.rates(component, facts)
        left = [(each.context, each.wanted) for each in rates if each.wanted != each.found]
        policy = drift.policy_difference(component, facts)
    at = f"component at path {component.path}"
    for context, rate in left:
        text = f"Set rate of execution context {context} on {at} to {drift.rate_text(rate)}"
        yield PlannedAction(text, SetRate(component.instance, context, rate), where=component.path)
    if policy is not None and policy.wanted != policy.found:
        action = SetPolicy(component.instance, component.policy or {})
        yield PlannedAction(f"Set policy on {at} to {policy.wanted}", action, where=component.path)


def _active_set(
    component: WantedComponent, live: LiveIndex, pending: Collection[str]
) -> Iterator[PlannedAction]:
    if not component.active_set:
        return
    text = (
        f'Set configuration set "{component.active_set}" active on component'
        f" at path {component.path}"
    )
    action = ActivateSet(component.instance, component.active_set)
    if component.instance in pending:
        made_so = component.pattern is not None
        yield PlannedAction(text, None if made_so else action, holds=made_so, where=component.path)
        return
    away = absence(component, live)
    facts = live.at(component.instance)
    holds = facts is not None and not away and facts.active_set == component.active_set
    todo = None if away or holds else action
    yield PlannedAction(text, todo, blocked=away, holds=holds, where=component.path)
