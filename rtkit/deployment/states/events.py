"""Event conditions: components that are lost, properties that have a value."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.health import COMPARE
from rtkit.deployment.metrics import ComponentMetrics
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.deployment.states.variants import component_of
from rtkit.errors import Malformed
from rtkit.fast_dataclass import dataclass

LOST = "lost"
_CONDITION = re.compile(r"(\S+?)\s*(<=|>=|!=|<|>|=)\s*(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class EventCondition:
    """Condition under which an event happens.

    Attributes:
        name: Of its property, as ``rtget`` has it; empty where the component is lost.
    """

    component: str
    name: str = ""
    compare: str = ""
    value: str = ""

    def __str__(self) -> str:
        if not self.name:
            return f"{LOST} {self.component}"
        return f"{self.component}.{self.name} {self.compare} {self.value}"

    @property
    def needs_metrics(self) -> bool:
        """Return whether it can only be judged with metrics."""
        return self.name.endswith(".count")

    def holds(
        self, snapshot: Snapshot, metrics: Mapping[str, ComponentMetrics] | None = None
    ) -> bool:
        """Return whether it holds; what nobody knows holds not."""
        facts = snapshot.component(self.component)
        is_lost = facts is None or bool(facts.zombie)
        if not self.name or is_lost or facts is None:
            return is_lost and not self.name
        return self._is_met(facts, snapshot, (metrics or {}).get(self.component))

    def _is_met(
        self, facts: ComponentFacts, snapshot: Snapshot, metrics: ComponentMetrics | None
    ) -> bool:
        from rtkit.deployment.properties import of_component

        ends = OwnEnds.of(snapshot).ends(facts) if facts.members else {}
        shown = of_component(facts, snapshot.connectors, metrics, ends)
        value = next((each.value for each in shown if each.name == self.name), None)
        if value is None or (self.needs_metrics and metrics is None):
            return False
        text = str(value).strip()
        if self.compare in ("=", "!="):
            numbers = _number(text), _number(self.value)
            is_same = text == self.value or (numbers[0] is not None and numbers[0] == numbers[1])
            return is_same == (self.compare == "=")
        number = _number(text)
        return number is not None and COMPARE[self.compare](number, float(self.value))


def condition(text: str, sets: Mapping[str, Sequence[str]]) -> EventCondition:
    """Read a condition: ``lost Motor0``, or ``Battery0.configuration.default.level < 10``.

    Properties are those of ``rtget``; ``Motor0.state = Error`` for one.

    Raises:
        Malformed: It cannot be read, or names no component.
    """
    word, _, name = text.strip().partition(" ")
    if word == LOST:
        component, rest = component_of(name.strip(), sets)
        if rest:
            raise Malformed(f"no such component: {name.strip()}")
        return EventCondition(component)
    match = _CONDITION.fullmatch(text.strip())
    if match is None:
        raise Malformed(f"neither lost NAME nor NAME.PROPERTY = VALUE: {text!r}")
    name, compare, value = match.groups()
    component, rest = component_of(name, sets)
    if not rest:
        raise Malformed(f"names no property: {name}; {name}.state is one")
    if compare in COMPARE and _number(value) is None:
        raise Malformed(f"not a number: {value!r}")
    return EventCondition(component, rest, compare, value)


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None
