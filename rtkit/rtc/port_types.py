"""Rule of ports: which can be connected, which is named first, how profiles state their types."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import eq

from rtkit.rtc.enums import Polarity, PortType
from rtkit.rtc.profiles import PortInterfaceProfile

WRONG_TYPE = "Wrong port type."
_STATED = {
    "in": PortType.IN,
    "out": PortType.OUT,
    **{kind.value.lower(): kind for kind in (PortType.IN, PortType.OUT)},
}

Interfaces = Sequence[PortInterfaceProfile]


def types_fit(types: Sequence[PortType]) -> bool:
    """Return whether ports of these types go together: services, or data out and data in."""
    if PortType.SERVICE in types:
        return all(each == PortType.SERVICE for each in types)
    return len(types) < 2 or {PortType.IN, PortType.OUT} <= set(types)


def are_reversed(types: Sequence[PortType | None]) -> bool:
    """Return whether the in port of a pair stands first: a connector names its out port first."""
    return tuple(types) == (PortType.IN, PortType.OUT)


def stated_port_type(text: str) -> PortType | None:
    """Return the type of a data port that a system profile states, None where it states none."""
    return _STATED.get(text.strip().lower())


def declared_port_type(text: str) -> PortType:
    """Return the type of a data port that a component profile declares; an event port is an in."""
    return PortType.OUT if text == PortType.OUT else PortType.IN


def shared_interfaces(
    one: Interfaces, other: Interfaces, is_same: Callable[[str, str], bool] = eq
) -> list[tuple[PortInterfaceProfile, PortInterfaceProfile]]:
    """Return the pairs of interfaces of one type, of two service ports.

    Types of profiles, which may leave the module out, are compared by `is_same_type`.
    """
    return [(mine, its) for mine in one for its in other if is_same(mine.type_name, its.type_name)]


def provides(one: Interfaces, other: Interfaces, is_same: Callable[[str, str], bool] = eq) -> bool:
    """Return whether a service port provides what another one requires."""
    return any(
        mine.polarity == Polarity.PROVIDED and its.polarity == Polarity.REQUIRED
        for mine, its in shared_interfaces(one, other, is_same)
    )


def interfaces_fit(
    one: Interfaces, other: Interfaces, is_same: Callable[[str, str], bool] = eq
) -> bool:
    """Return whether two service ports go together; one that lists nothing goes with all."""
    is_met = provides(one, other, is_same) or provides(other, one, is_same)
    return is_met or not (one and other)
