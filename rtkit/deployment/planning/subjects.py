"""Subjects of steps: the names by which stated costs refer to single steps of a deployment."""

from __future__ import annotations

from collections.abc import Iterator

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.system import WantedComponent, WantedSystem


def subjects(kind: str, system: WantedSystem, snapshot: Snapshot) -> set[str]:
    """Return the names of all that a kind of step may be done to: what is wanted, what lives."""
    match kind:
        case "start_manager":
            return set(_managers(snapshot))
        case "load" | "unload":
            return set(_modules(system, snapshot))
        case "connect" | "disconnect":
            wires = [*(wire.profile for wire in system.connectors), *snapshot.connectors]
            return {wire.connector_id for wire in wires}
    components: list[WantedComponent | ComponentFacts] = [*system.components, *snapshot.components]
    names = {each.instance for each in components}
    if kind == "configure":
        names.update(
            f"{each.instance}.{set_id}.{parameter}"
            for each in components
            for set_id, values in each.sets.items()
            for parameter in values
        )
    return names


def _managers(snapshot: Snapshot) -> Iterator[str]:
    return (each.manager for each in (snapshot, *snapshot.others))


def _modules(system: WantedSystem, snapshot: Snapshot) -> Iterator[str]:
    for component in system.components:
        if component.module:
            yield f"{component.manager or snapshot.manager}/{component.module}"
    for each in (snapshot, *snapshot.others):
        for module in each.modules:
            path = f"{each.manager}/{module.path}"
            yield from (path, f"{path}:{module.init}")
