"""Compares a live system with the wanted one and yields every deviation; none hides another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from rtkit.deployment import drift
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.live_index import LiveIndex, absence, context_of
from rtkit.deployment.system import HIDDEN, WantedComponent, WantedConnector, WantedSystem, address
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.connector_properties import differing
from rtkit.rtc.enums import UNKNOWN_STATE, LifeCycleState
from rtkit.rtc.profiles import PortRef

_CONSTRAINTS = "__constraints__"

NO_FILES: Mapping[str, str] = {}


@dataclass(frozen=True, slots=True)
class Deviation:
    """One difference between a profile and what lives.

    Attributes:
        kind: ``component``, ``connection``, ``property``, ``active-set``, ``parameter``,
            ``constraint``, ``port``, ``type``, ``rate``, ``policy``, ``place``, ``create``,
            ``code`` or ``state``.
        path: The component, or the ports of a connection.
        item: Part that differs there; empty for the component or the connection itself.
        wanted: Value that the profile states; empty where it states none.
        found: Value that lives; empty where none does.
    """

    kind: str
    path: str
    text: str
    is_required: bool
    item: str = ""
    wanted: str = ""
    found: str = ""


def deviations(
    system: WantedSystem,
    live: LiveIndex,
    state: LifeCycleState | None,
    present_code: Mapping[str, str] = NO_FILES,
    unmet: Mapping[str, str] = NO_FILES,
) -> Iterator[Deviation]:
    """Yield every deviation: components, connections, active sets, parameters, ports, states.

    With `state` None each component is to have no execution context at all (``Unknown``).
    `present_code` has the CRC-32 of files as they are: that one has changed since it was loaded is
    reported, and nothing required. `unmet` tells what components require that is not so where they
    live.
    """
    for component in system.components:
        why = absence(component, live)
        if live.why_unreachable(component.instance):
            # Whether it is required or not: nobody has looked.
            yield Deviation("component", component.path, why, True, "", component.id)
        elif why:
            namesake = live.at(component.instance)
            found = "" if namesake is None else namesake.type.id
            yield _of("component", component, why, "", component.id, found)
    for connector in system.connectors:
        if not any(live.why_unreachable(end.instance) for end in connector.profile.ports):
            yield from _connection(connector, system, live)
    for component in system.components:
        facts = live.at(component.instance)
        if facts is not None and facts.trouble:
            text = f"Component {component.path} does not answer ({facts.trouble})"
            yield _of("component", component, text, found=facts.trouble)
    there = [(c, facts) for c in system.components if (facts := _living(c, live)) is not None]
    for component, facts in there:
        if component.active_set and facts.active_set != component.active_set:
            text = (
                f"Wrong configuration set is active on {component.path}"
                f" (Active set: {facts.active_set})"
            )
            sides = ("active set", component.active_set, facts.active_set)
            yield _of("active-set", component, text, *sides)
    for component, facts in there:
        yield from _parameters(component, facts)
    for component, facts in there:
        yield from _manner(component, facts)
        if component.instance in unmet:
            why = unmet[component.instance]
            text = f"Component {component.path} is not where it may be: {why}"
            yield _of("place", component, text, found=why)
        file = facts.changed_code(present_code)
        if file:
            text = f"Component {component.path} runs code that has changed since ({file})"
            yield Deviation("code", component.path, text, False, found=file)
    for component, facts in there:
        yield from _states(component, facts, state)


def _of(
    kind: str,
    component: WantedComponent,
    text: str,
    item: str = "",
    wanted: str = "",
    found: str = "",
) -> Deviation:
    return Deviation(kind, component.path, text, component.is_required, item, wanted, found)


def diff_lines(deviations: Iterable[Deviation]) -> Iterator[str]:
    """Yield what the profile states behind ``-``, what lives behind ``+``."""
    for each in deviations:
        where = f"{each.path} {each.item}".rstrip()
        if each.wanted or each.item:
            yield f"-{where}  {each.wanted}"
        if each.found:
            yield f"+{where}  {each.found}"


def surplus(system: WantedSystem, live: LiveIndex) -> Iterator[Deviation]:
    """Yield what lives and is not in the profile: components, and connections of its components.

    Ports and parameters of its components, too, where it lists any of them.

    Nothing of it is required not to be there.
    """
    names = {component.instance for component in system.components}
    connectors = [connector.profile for connector in system.connectors]
    wanted = {connector.connector_id for connector in connectors}
    unmatched = {
        frozenset(connector.ports)
        for connector in connectors
        if live.connector(connector.connector_id) is None
    }
    for facts in live.snapshot.components:
        if facts.instance not in names:
            path = _path(facts)
            text = f"Component {path} is not in the profile"
            yield Deviation("component", path, text, False, found=facts.type.id)
    for component in system.components:
        living = _living(component, live)
        if living is not None:
            yield from _unnamed(component, living)
    for connector in live.snapshot.connectors:
        is_wanted = connector.connector_id in wanted or frozenset(connector.ports) in unmatched
        if not is_wanted and any(end.instance in names for end in connector.ports):
            path = " ".join(_port_path(live, end) for end in connector.ports)
            text = f"Connection {connector.connector_id} is not in the profile"
            yield Deviation("connection", path, text, False, found=connector.connector_id)


def _unnamed(component: WantedComponent, facts: ComponentFacts) -> Iterator[Deviation]:
    for name in drift.unnamed_ports(component, facts):
        text = f"Port {name} of component {component.path} is not in the profile"
        yield Deviation("port", f"{component.path}:{name}", text, False, found=name)
    for set_id, name, value in drift.unnamed_parameters(component, facts):
        text = f"Parameter {name} in set {set_id} of component {component.path}"
        where = f"{component.path} {set_id}.{name}"
        yield Deviation("parameter", where, f"{text} is not in the profile", False, found=value)


def _path(facts: ComponentFacts) -> str:
    return f"/{facts.names[0]}" if facts.names else facts.instance


def _port_path(live: LiveIndex, end: PortRef) -> str:
    facts = live.namesake(end.instance)
    return str(end) if facts is None else f"{_path(facts)}:{end.port}"


def check_lines(system: WantedSystem, state: str) -> Iterator[str]:
    """Yield what is compared, for a dry run."""
    for component in system.components:
        word, mark = ("required ", " (Required)") if component.is_required else ("", "")
        yield (
            f'Check for {word}component "{component.id}", "{component.instance}"'
            f" at path {component.path}{mark}"
        )
    for connector in system.connectors:
        source, target = (address(system, end) for end in connector.profile.ports)
        mark = " (Required)" if connector.is_required else ""
        id = connector.profile.connector_id
        yield f"Check for connection from {source} to {target} with ID {id}{mark}"
    for component in system.components:
        if component.active_set:
            path, set_id = component.path, component.active_set
            yield f'Check set "{set_id}" is active on component at path {path}'
    for component in system.components:
        for set_id, values in component.sets.items():
            for name, value in () if set_id.startswith(HIDDEN) else values.items():
                yield (
                    f'Check parameter "{name}" in set "{set_id}" on component'
                    f' at path {component.path} is "{value}"'
                )
    for component in system.components:
        yield from _manner_lines(component)
    for component in system.components:
        for context in component.contexts:
            yield (
                f"Check component at path {component.path} is in state {state}"
                f" in execution context {context.id}"
            )


def _manner_lines(component: WantedComponent) -> Iterator[str]:
    """Yield what is compared of how a component is, beside values and states."""
    at = f"component at path {component.path}"
    for port in component.ports:
        type_text = f' of data type "{port.data_type}"' if port.data_type else ""
        yield f'Check {at} has port "{port.name}"{type_text}'
    for set_id, values in component.sets.items():
        for name, value in values.items() if set_id == _CONSTRAINTS else ():
            yield f'Check constraint of "{name}" on {at} is "{value}"'
    for number, rate in enumerate(component.rates):
        if rate:
            context = component.contexts[number].id
            yield f"Check rate of execution context {context} of {at} is {drift.rate_text(rate)}"
    if component.policy is not None:
        yield f'Check policy of {at} is "{drift.policy_text(component.policy)}"'
    if component.is_create_stated:
        yield f'Check create string of {at} is "{drift.essence(component.create)}"'


def _living(component: WantedComponent, live: LiveIndex) -> ComponentFacts | None:
    return None if absence(component, live) else live.at(component.instance)


def _connection(
    wanted: WantedConnector, system: WantedSystem, live: LiveIndex
) -> Iterator[Deviation]:
    connector = wanted.profile
    source, target = (address(system, end) for end in connector.ports)
    path = f"{source} {target}"
    known = live.connector(connector.connector_id)
    if known is None or set(known.ports) != set(connector.ports):
        text = f"No connection between {source} and {target}"
        ids = ", ".join(other.connector_id for other in live.connectors_between(connector.ports))
        if ids:
            text += f" with ID {connector.connector_id} (there is {ids})"
        yield Deviation(
            "connection", path, text, wanted.is_required, "", connector.connector_id, ids
        )
        return
    for key in differing(connector.properties, known.properties):
        expected, found = connector.properties[key], known.properties.get(key, "")
        text = f"Property {key} of connection from {source} to {target} is incorrect."
        text += f" (value: {found})"
        yield Deviation("property", path, text, wanted.is_required, key, expected, found)


def _parameters(component: WantedComponent, facts: ComponentFacts) -> Iterator[Deviation]:
    for set_id, values in component.sets.items():
        present = facts.sets.get(set_id)
        for name, value in values.items():
            found = present.get(name) if present is not None else None
            if found == value or set_id.startswith(HIDDEN):
                continue
            where = f"Configuration parameter {name} in set {set_id} on component {component.path}"
            text = f"{where} is incorrect (value: {found})"
            if found is None:
                text = f"{where} is missing"
            sides = (f"{set_id}.{name}", value, found or "")
            yield _of("parameter", component, text, *sides)


def _manner(component: WantedComponent, facts: ComponentFacts) -> Iterator[Deviation]:
    """Yield in what a component is otherwise than wanted, beside values and states."""
    for each in drift.constraint_differences(component, facts):
        yield _deviation("constraint", component, each)
    # Of a stand-in its list of ports is reported as a whole.
    for name in () if facts.is_stand_in else drift.lacking_ports(component, facts):
        text = f"Component {component.path} has no port {name}"
        yield _of("port", component, text, f"port {name}", name)
    for each in () if facts.is_stand_in else drift.data_types(component, facts):
        yield _deviation("type", component, each)
    for rate in drift.rates(component, facts):
        wanted, found = drift.rate_text(rate.wanted), drift.rate_text(rate.found)
        if wanted != found:
            item = f"rate of execution context {rate.context}"
            yield _deviation("rate", component, drift.Drift(item, wanted, found))
    policy = drift.policy_difference(component, facts)
    if policy is not None and policy.wanted != policy.found:
        yield _deviation("policy", component, policy)
    for each in drift.otherwise_made(component, facts):
        yield _deviation("create", component, each)


def _deviation(kind: str, component: WantedComponent, each: drift.Drift) -> Deviation:
    item = each.item[0].upper() + each.item[1:]
    text = f"{item} of component {component.path} is incorrect (value: {each.found})"
    return _of(kind, component, text, *each)


def _states(
    component: WantedComponent, facts: ComponentFacts, state: LifeCycleState | None
) -> Iterator[Deviation]:
    if state is None:
        if facts.contexts:
            text = f"Component {component.path} is in incorrect state {facts.state}"
            sides = ("state", UNKNOWN_STATE, facts.state)
            yield _of("state", component, text, *sides)
        return
    for number, wanted in enumerate(component.contexts):
        context = context_of(facts, component, number)
        if context is None:
            text = f"Component {component.path} has no execution context {wanted.id}"
            sides = (f"execution context {wanted.id}", state.value, "")
            yield _of("state", component, text, *sides)
        elif context.state is not state:
            text = f"Component {component.path} is in incorrect state {context.state}"
            item = "state"
            if len(component.contexts) > 1:
                item = f"state in execution context {wanted.id}"
                text += f" in execution context {wanted.id}"
            if facts.cause:
                text += f" ({facts.cause})"
            sides = (item, state.value, context.state.value)
            yield _of("state", component, text, *sides)
