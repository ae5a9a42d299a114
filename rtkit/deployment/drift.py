"""Drift: differences of a live component from its profile beside values, connections and states.

Checks and plans both read it: rates and policies, which change while a component lives, and all
that changes only when the component is created again.

See decision 39.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.deployment.extension import policy_in
from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.live_index import own_context_of
from rtkit.deployment.system import HIDDEN, WantedComponent
from rtkit.errors import Malformed
from rtkit.rtc.create import CreateString, readable_create
from rtkit.rtc.data_types import is_same_type
from rtkit.rtc.enums import ExecutionKind

CREATE_STRING = "create string"
NO_POLICY = "none"
_COMPARED_ELSEWHERE = (
    "instance_name", "manager_name", "manager_address", "manager", "language", "members",
    "exported_ports",
)  # fmt: skip
"""Options of create strings that say a name, a place, or what sets say."""
_VALUES = "conf."
_OWN = "rtkit."


class Drift(NamedTuple):
    """One thing in which a component differs from its profile."""

    item: str
    wanted: str
    found: str

    def __str__(self) -> str:
        return f"its {self.item} is {self.found or 'none'}, not {self.wanted or 'none'}"


class Rate(NamedTuple):
    """Rate of an execution context [Hz]: the profile's and the present one."""

    context: str
    wanted: float
    found: float


def rates(component: WantedComponent, facts: ComponentFacts) -> Iterator[Rate]:
    """Yield the rates that a profile states for contexts that live, those that are so, too."""
    for number, wanted in enumerate(component.rates):
        context = own_context_of(facts, component, number) if wanted else None
        if context is not None and context.kind is ExecutionKind.PERIODIC:
            yield Rate(context.id, wanted, context.rate)


def rate_text(rate: float) -> str:
    """Return a rate as text; equal texts are equal rates."""
    return f"{rate:.10g}"


def policy_difference(component: WantedComponent, facts: ComponentFacts) -> Drift | None:
    """Return in what the policy of a component differs; None where the profile has none.

    Where it is the same in other words, both sides are.
    """
    if component.policy is None:
        return None
    found = policy_in(facts.create)
    wanted = policy_text(component.policy)
    is_same = _is_same_policy(component.policy, found)
    return Drift("policy", wanted, wanted if is_same else policy_text(found))


def policy_text(policy: Mapping[str, str]) -> str:
    """Return a policy in one line."""
    return ", ".join(f"{key}={policy[key]}" for key in sorted(policy)) or NO_POLICY


def _is_same_policy(one: Mapping[str, str], other: Mapping[str, str]) -> bool:
    if one == other:
        return True
    from rtkit.deployment.health import read_rules
    from rtkit.deployment.limits import read_limits
    from rtkit.deployment.placement.requirements import read_requirements
    from rtkit.deployment.supervision import RestartRule, read_policy

    try:
        if any(read(one) != read(other) for read in (read_limits, read_requirements)):
            return False
        # The manager states what the profile does not, so it must be the same whatever that is.
        return set(read_rules(one)) == set(read_rules(other)) and all(
            read_policy(one, default) == read_policy(other, default) for default in RestartRule
        )
    except Malformed:
        return False


def otherwise_made(component: WantedComponent, facts: ComponentFacts) -> Iterator[Drift]:
    """Yield what nothing but making a component again can change.

    Of one with code of its own that is its create string; a stand-in is what its profile states.
    """
    if component.pattern is not None and facts.is_stand_in:
        yield from _as_stand_in(component, facts)
    elif component.is_create_stated and component.pattern is None and not facts.is_stand_in:
        wanted, found = essence(component.create), essence(facts.create)
        if found and wanted != found:
            yield Drift(CREATE_STRING, wanted, found)


def essence(text: str) -> str:
    """Return of a create string what is compared with nothing else; empty if it cannot be read."""
    create = readable_create(text)
    left = {
        key: create.options[key]
        for key in sorted(create.options)
        if key not in _COMPARED_ELSEWHERE and not key.startswith((_VALUES, _OWN))
    }
    return str(CreateString(create.implementation_id, options=left))


def _as_stand_in(component: WantedComponent, facts: ComponentFacts) -> Iterator[Drift]:
    wanted = {port.name: port.port_type for port in component.ports}
    found = {port.name: port.port_type for port in facts.ports}
    if wanted != found:
        ports = [", ".join(f"{n} ({kind})" for n, kind in each.items()) for each in (wanted, found)]
        yield Drift("list of ports", *ports)
    yield from data_types(component, facts)
    for number, pattern in enumerate(component.contexts):
        context = own_context_of(facts, component, number)
        if context is None or context.kind is not pattern.kind:
            kind = "" if context is None else context.kind.value
            yield Drift(f"execution context {pattern.id}", pattern.kind.value, kind)
    for set_id, values in component.sets.items():
        present = facts.sets.get(set_id)
        lacking = [name for name in values if name not in (present or {})]
        if present is None or lacking:
            there = "missing" if present is None else ", ".join(present)
            yield Drift(f"set {set_id}", ", ".join(values) or "empty", there)


def data_types(component: WantedComponent, facts: ComponentFacts) -> Iterator[Drift]:
    """Yield the data types of ports that differ from those of a profile."""
    for port in component.ports:
        found = facts.port(port.name)
        if found is not None and not is_same_type(port.data_type, found.data_type):
            yield Drift(f"data type of port {port.name}", port.data_type, found.data_type)


def lacking_ports(component: WantedComponent, facts: ComponentFacts) -> list[str]:
    """Return the ports that a profile lists and a component has not."""
    return [port.name for port in component.ports if facts.port(port.name) is None]


def unnamed_ports(component: WantedComponent, facts: ComponentFacts) -> list[str]:
    """Return the ports that a component has, and its profile does not list though it lists some."""
    if not component.ports:
        return []
    return [port.name for port in facts.ports if component.port(port.name) is None]


def unnamed_parameters(
    component: WantedComponent, facts: ComponentFacts
) -> Iterator[tuple[str, str, str]]:
    """Yield set, name and value of parameters that a profile does not list though it lists some."""
    if all(set_id.startswith(HIDDEN) for set_id in component.sets):
        return
    for set_id, values in facts.sets.items():
        listed = component.sets.get(set_id, {})
        for name, value in () if set_id.startswith(HIDDEN) else values.items():
            if name not in listed:
                yield set_id, name, value


def constraint_differences(component: WantedComponent, facts: ComponentFacts) -> Iterator[Drift]:
    """Yield constraints of parameters that a component declares otherwise than its profile."""
    if not any(set_id.startswith(HIDDEN) for set_id in component.sets):
        return
    from rtkit.component.configuration.constraint_check import CONSTRAINT_SET

    declared = facts.sets.get(CONSTRAINT_SET, {})
    for name, wanted in component.sets.get(CONSTRAINT_SET, {}).items():
        found = declared.get(name)
        if found is not None and not _is_same_constraint(wanted, found):
            yield Drift(f"constraint of {name}", wanted, found)


def _is_same_constraint(one: str, other: str) -> bool:
    if one.strip() == other.strip():
        return True
    from rtkit.profile.constraint_text import parse_constraint

    try:
        return parse_constraint(one) == parse_constraint(other)
    except Malformed:
        return False
