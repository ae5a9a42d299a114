"""Costs of steps: a default table, overridden by measured times, overridden by stated costs.

All costs are in the scale of the table: measured kinds together cost what the table states for
these kinds together. Costs are rounded coarsely, so that plans stay the same from day to day.

See decision 28.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.deployment.packages import NO_PACKAGES, Packages
from rtkit.deployment.planning.default_costs import DEFAULT_COSTS, INTERRUPTIONS
from rtkit.deployment.planning.model import HERE, cost_name
from rtkit.deployment.system import WantedComponent, WantedSystem
from rtkit.fast_dataclass import dataclass, field
from rtkit.rtc.names import split_manager

TABLE, MEASURED, PROFILE, USER = "table", "measured", "profile", "user"
"""Where a cost comes from."""
ORIGINS = (TABLE, MEASURED, PROFILE, USER)
"""Each goes before those before it."""


@dataclass(frozen=True, slots=True)
class Costs:
    """Costs of steps, with their sources.

    Attributes:
        values: Of each kind; ``KIND NAME`` for what concerns one component or thing only.
        origins: `MEASURED`, `PROFILE` or `USER`, by the same names; what is not named is `TABLE`.
    """

    values: Mapping[str, float] = field(default_factory=lambda: DEFAULT_COSTS)
    origins: Mapping[str, str] = field(default_factory=dict)

    def over(self, more: Mapping[str, float], origin: str) -> Costs:
        """Return the same with other costs over these."""
        kept = dict(self.values)
        origins = dict(self.origins)
        for kind in more.keys() & DEFAULT_COSTS.keys():
            # A cost stated for a whole kind takes precedence over those measured for single types.
            for name in [each for each in kept if each.startswith(f"{kind} ")]:
                if origins.get(name) == MEASURED:
                    del kept[name], origins[name]
        return Costs({**kept, **more}, {**origins, **dict.fromkeys(more, origin)})

    def origin(self, kind: str, subject: str) -> str:
        """Return where the cost of a step comes from."""
        return self.origins.get(cost_name(self.values, kind, subject), TABLE)


USUAL = Costs()
"""Costs of the table."""


def interruption(component: str, cost: float) -> dict[str, float]:
    """Return costs by which any interruption of a component costs so much."""
    return {f"{kind} {component}": cost for kind in INTERRUPTIONS}


def subjects(
    kind: str, system: WantedSystem, snapshot: Snapshot, packages: Packages = NO_PACKAGES
) -> set[str]:
    """Return the names of all that a kind of step may be done to: what is wanted, what lives."""
    match kind:
        case "start_manager":
            return {each.manager for each in (snapshot, *snapshot.others)}
        case "install" | "uninstall":
            homes = {c.instance: c.manager or snapshot.manager for c in system.components}
            needed = ((split_manager(homes[n])[1] or HERE, each) for n, each in packages.of.items())
            return {f"{host}/{each}" for host, each in needed} | packages.installed
        case "load" | "unload":
            return set(_modules(system, snapshot))
        case "connect" | "disconnect":
            connectors = [
                *(connector.profile for connector in system.connectors),
                *snapshot.connectors,
            ]
            return {connector.connector_id for connector in connectors}
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


def _modules(system: WantedSystem, snapshot: Snapshot) -> Iterator[str]:
    for component in system.components:
        if component.module:
            yield f"{component.manager or snapshot.manager}/{component.module}"
    for each in (snapshot, *snapshot.others):
        for module in each.modules:
            path = f"{each.manager}/{module.path}"
            yield from (path, f"{path}:{module.init}")
