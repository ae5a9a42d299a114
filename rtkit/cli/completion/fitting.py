"""Matches ports with ports: the rule of `rtkit.component.check` for ports as plain facts."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.cli.completion.live import Plain
from rtkit.rtc.data_types import is_same_type

_SERVICE = "CorbaPort"


def is_fit(one: Plain, other: Plain) -> bool:
    """Return whether direction, data type and interfaces let two ports be connected."""
    kinds = (one["port_type"], other["port_type"])
    if _SERVICE in kinds:
        return kinds[0] == kinds[1] and _meet(one, other)
    return kinds[0] != kinds[1] and is_same_type(_data_type(one), _data_type(other))


def _data_type(port: Plain) -> str:
    return str(port.get("properties", {}).get("dataport.data_type", ""))


def _meet(one: Plain, other: Plain) -> bool:
    mine, its = one.get("interfaces", ()), other.get("interfaces", ())
    pairs = ((m, i) for m in mine for i in its if m["type_name"] == i["type_name"])
    return not (mine and its) or any(m["polarity"] != i["polarity"] for m, i in pairs)


def fits(components: Iterable[Plain], instance: str, port: Plain) -> set[str]:
    """Return the components that have a port which goes with one of a component."""
    found = set()
    verdicts: dict[tuple[str, ...], bool] = {}
    for component in components:
        for each in component.get("ports", ()):
            if component["instance"] == instance and each["name"] == port["name"]:
                continue
            key = (each["port_type"], _data_type(each), str(each.get("interfaces", "")))
            if key not in verdicts:
                verdicts[key] = is_fit(port, each)
            if verdicts[key]:
                found.add(component["instance"])
                break
    return found
