"""Findings of a static check, with their locations in the system profile, and its rules."""

from __future__ import annotations

from typing import NamedTuple

RULES: dict[str, str] = {
    "condition-circle": "Conditions wait for each other in a circle",
    "condition-target": "A condition names an execution context that is not there, or a bad time",
    "condition-wait": "A condition waits less long than what it waits for",
    "connector-direction": "A data connector joins two out ports, or two in ports",
    "connector-property": "A property of a data connector is not known, or makes no sense",
    "connector-reversed": "A data connector names its in port first",
    "context-kind": "An execution context is of another kind than the type's",
    "context-rate": "A rate is none, or another than the type's",
    "create-string": "A create string cannot be read",
    "data-type": "Data types do not match",
    "dataflow-type": "A port does not offer the dataflow type of its connector",
    "interface-type": "A port does not offer the interface type of its connector",
    "limits": "Components may use more than the host has, or no slave that is limited",
    "name-clash": "Two components have one name on one manager",
    "no-profile": "There is no RTC profile for a component",
    "parameter-constraint": "A value breaks the constraint of its parameter",
    "parameter-type": "A value is not of its parameter's type",
    "path-clash": "Two components are registered under one path",
    "placement": "A requirement about the place of a component, or where it may go, makes no sense",
    "port-direction": "A port has another direction than the type's",
    "service-interface": "Service ports have no interface in common",
    "service-polarity": "An interface is provided, or required, at both ends of a connector",
    "several-profiles": "Different RTC profiles describe one type",
    "subscription-type": "A port does not offer the subscription type of its connector",
    "supervision": "A property of restarts, health or limits makes no sense",
    "system-states": "The states of the system, or events between them, make no sense",
    "unconnected-service": "Nobody provides what a service port requires",
    "unknown-parameter": "A type has no such configuration parameter",
    "unknown-port": "A type has no such port",
    "unknown-property": "A property looks like one that rtkit knows, and is none",
    "unknown-set": "The active configuration set is none that can be active",
    "unreadable-profile": "An RTC profile cannot be read",
    "version": "The RTC profile is of another version than the component",
}
"""Subject of each rule, by its id."""


class ProfileLocation(NamedTuple):
    """A part of a profile: by the fields of the model that lead to it, each with a number.

    Attributes:
        steps: From the root on.
        field: Which of its attributes is meant; empty for the whole part.
    """

    steps: tuple[tuple[str, int], ...] = ()
    field: str = ""

    def below(self, field: str, number: int = 0) -> ProfileLocation:
        """Return a part of this one."""
        return ProfileLocation((*self.steps, (field, number)))

    def at(self, field: str) -> ProfileLocation:
        """Return an attribute of this one."""
        return ProfileLocation(self.steps, field)


TOP = ProfileLocation()


class StaticFinding(NamedTuple):
    """A finding of a static check.

    Attributes:
        severity: ``error``, ``warning`` or ``note``.
        rule: Id of the rule that it is about, one of `rtkit.static_check.finding.RULES`.
        text: The finding in one line.
        found: Text that stands there; None where nothing does.
        allowed: Allowed values, in words.
    """

    severity: str
    rule: str
    text: str
    place: ProfileLocation = TOP
    found: str | None = None
    allowed: str = ""
