"""Reservations: computes how much of a host the components of a system may use together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rtkit.deployment.facts import ComponentFacts
from rtkit.deployment.limits import SlaveLimits, limits_in, read_limits
from rtkit.deployment.system import WantedSystem


def wanted_limits(system: WantedSystem) -> dict[str, SlaveLimits]:
    """Return the limits that a system states for its components, by instance; empty ones too."""
    said = {c.instance: c.policy for c in system.components if c.policy is not None}
    return {instance: read_limits(policy) for instance, policy in said.items()}


def reserved(
    system: WantedSystem,
    living: Iterable[ComponentFacts],
    elsewhere: Mapping[str, Iterable[ComponentFacts]],
) -> dict[str, SlaveLimits]:
    """Return what each component of a host may use when the system is up, by its name.

    Args:
        system: What is wanted.
        living: What lives in the managers of the system.
        elsewhere: What lives in other managers of the host, by their names.
    """
    found = {each.instance: limits_in(each.create) for each in living if not each.zombie}
    found.update(wanted_limits(system))
    for manager, components in elsewhere.items():
        more = {each.instance: limits_in(each.create) for each in components if not each.zombie}
        found.update({f"{instance} in {manager}": had for instance, had in more.items()})
    return found
