"""Checks, before a plan runs, that this host can reserve the system's limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.deployment.extension import LIMIT
from rtkit.errors import Impossible, RtkitError

if TYPE_CHECKING:
    from collections.abc import Collection

    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.system import WantedSystem


def check_reserved(app: App, system: WantedSystem, snapshot: Snapshot) -> None:
    """Check that this host has what components may use together, those of other managers too.

    Raises:
        Impossible: It has not; tells the numbers.
    """
    policies = (component.policy or {} for component in system.components)
    if not any(key.startswith(LIMIT) for policy in policies for key in policy):
        return
    from rtkit.deployment.limits import overbooked, reserved
    from rtkit.manager.limits.capacity import capacity

    managers = {each.manager for each in (snapshot, *snapshot.others)}
    elsewhere = _elsewhere(app, managers) if app.finds_managers else {}
    why = overbooked(reserved(system, snapshot.components, elsewhere), capacity())
    if why:
        raise Impossible(why)


def _elsewhere(app: App, managers: Collection[str]) -> dict[str, tuple[ComponentFacts, ...]]:
    """Return the components of the other managers of this host, by manager."""
    from rtkit.link import running
    from rtkit.tree.connect import connect

    found = {}
    for name in running.managers():
        if name not in managers:
            try:
                with connect(name, app.timeout_s) as tree:
                    found[name] = tree.snapshot().components
            except RtkitError as error:
                app.tell(f"what manager {name} has reserved is not known: {error}")
    return found
