"""Measured durations of steps, as costs in the scale of the default table.

Apart from `rtkit.deployment.planning.step_costs`, because commands that only carry steps out note
what these took (0035): they load no model of planning.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from math import floor, log10
from typing import NamedTuple

from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.planning.default_costs import DEFAULT_COSTS
from rtkit.errors import Malformed
from rtkit.fast_dataclass import Record, field
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import Transition

ENOUGH = 20
"""So many steps of a kind must have been measured before their mean counts."""

_MEMORY = 100
"""A mean is that of about so many steps, the latest ones."""
_MOST_TYPES = 500
_VERSION = 1
_OF_TYPES = ("create", "create_slave", "delete", "configure", "activate", "deactivate", "reset")
_PREFERRED = (1.0, 1.5, 2.2, 3.3, 4.7, 6.8, 10.0)
_LEAST = 0.01

_KINDS: Mapping[type, str] = {
    act.Load: "load",
    act.Unload: "unload",
    act.Delete: "delete",
    act.Connect: "connect",
    act.Attach: "connect",
    act.Disconnect: "disconnect",
    act.Detach: "disconnect",
    act.SetParameters: "configure",
    act.ActivateSet: "configure",
    act.RemoveSet: "configure",
    act.SetRate: "configure",
    act.SetContext: "configure",
    act.SetPolicy: "configure",
}
_TRANSITIONS = {
    Transition.ACTIVATE: "activate",
    Transition.DEACTIVATE: "deactivate",
    Transition.RESET: "reset",
}


class Mean(NamedTuple):
    """Mean duration of steps: their number, and the mean [s]."""

    steps: int
    seconds: float

    def with_one(self, seconds: float) -> Mean:
        """Return the mean with one more; the older ones are forgotten little by little."""
        count = min(self.steps + 1, _MEMORY)
        return Mean(count, self.seconds + (seconds - self.seconds) / count)


class Times(Record):
    """Measured durations of the steps of this installation.

    Attributes:
        means: By kind of step, or ``KIND TYPE`` for components of one type; the latest last.
    """

    means: Mapping[str, Mean] = field(default_factory=dict)

    def noting(self, taken: Iterable[tuple[Action, float]], types: Mapping[str, str]) -> Times:
        """Return the same with what actions took [s]; `types` are of components, by name."""
        means = dict(self.means)
        for action, seconds in taken:
            for name in _names(action, types):
                means[name] = means.pop(name, Mean(0, 0.0)).with_one(seconds)
        of_types = [name for name in means if " " in name]
        for name in of_types[: max(0, len(of_types) - _MOST_TYPES)]:
            del means[name]
        return Times(means)

    def costs(self, types: Mapping[str, str]) -> dict[str, float]:
        """Return what steps cost of which enough were measured, by kind and ``KIND COMPONENT``."""
        known = {name: mean for name, mean in self.means.items() if mean.steps >= ENOUGH}
        kinds = [kind for kind in DEFAULT_COSTS if kind in known]
        seconds = sum(known[kind].seconds for kind in kinds)
        if not seconds:
            return {}
        unit_s = seconds / sum(DEFAULT_COSTS[kind] for kind in kinds)
        found = {kind: _rounded(known[kind].seconds / unit_s) for kind in kinds}
        for component, type_ in types.items():
            for kind in _OF_TYPES:
                mean = known.get(f"{kind} {type_}")
                if mean is not None:
                    found[f"{kind} {component}"] = _rounded(mean.seconds / unit_s)
        return found


def times_to_text(times: Times) -> str:
    """Return what was measured as text for a file."""
    plain = {name: [mean.steps, round(mean.seconds, 6)] for name, mean in times.means.items()}
    return json.dumps({"version": _VERSION, "means": plain}, indent=1) + "\n"


def times_from_text(text: str) -> Times:
    """Rebuild what was measured.

    Raises:
        Malformed: It is damaged, or of another version.
    """
    try:
        plain = json.loads(text)
        if plain["version"] != _VERSION:
            raise Malformed(f"version {plain['version']!r} is not known")
        return Times(dict(_means(plain["means"])))
    except (ValueError, TypeError, KeyError, RecursionError) as error:
        raise Malformed(f"not what was measured: {error}") from error


def _means(plain: Mapping[str, tuple[int, float]]) -> Iterator[tuple[str, Mean]]:
    for name, (count, seconds) in plain.items():
        if name.partition(" ")[0] not in DEFAULT_COSTS:
            raise ValueError(f"no kind of step: {name}")
        if not (isinstance(count, int) and count > 0 and 0 <= float(seconds) < float("inf")):
            raise ValueError(f"not a count and seconds: {name}")
        yield name, Mean(min(count, _MEMORY), float(seconds))


def kind_of(action: Action) -> str:
    """Return which kind of step an action is; empty for what no plan has."""
    if isinstance(action, act.Create):
        return "create_slave" if parse_create(action.create).place else "create"
    if isinstance(action, act.ChangeState):
        return _TRANSITIONS.get(action.transition, "")
    return _KINDS.get(type(action), "")


def _names(action: Action, types: Mapping[str, str]) -> Iterator[str]:
    kind = kind_of(action)
    if not kind:
        return
    yield kind
    instance = getattr(action, "instance", "")
    if isinstance(action, act.Create):
        instance = parse_create(action.create).instance_name
    if kind in _OF_TYPES and types.get(instance):
        yield f"{kind} {types[instance]}"


def _rounded(cost: float) -> float:
    """Return the preferred number next to a cost: 1, 1.5, 2.2, 3.3, 4.7, 6.8 and their tenfold."""
    if cost <= _LEAST:
        return _LEAST
    scale = 10.0 ** floor(log10(cost))
    nearest = min(_PREFERRED, key=lambda each: abs(log10(each) - log10(cost / scale)))
    return float(f"{nearest * scale:.2g}")
