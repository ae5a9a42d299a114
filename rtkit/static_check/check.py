"""Check a system before anything runs.

See decision 11.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtkit.deployment.limits import Capacity
from rtkit.profile.rts_model import RtsProfile
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.connectors import connector_findings
from rtkit.static_check.contexts import context_findings
from rtkit.static_check.finding import StaticFinding
from rtkit.static_check.names import name_findings
from rtkit.static_check.orders import order_findings
from rtkit.static_check.parameters import parameter_findings
from rtkit.static_check.policies import (
    limit_remarks,
    placement_findings,
    property_remarks,
    restart_findings,
)
from rtkit.static_check.ports import port_findings
from rtkit.static_check.services import service_findings
from rtkit.static_check.view import View

_RULES = (
    name_findings, port_findings, parameter_findings, context_findings, connector_findings,
    service_findings, order_findings, restart_findings, placement_findings,
    property_remarks,
)  # fmt: skip


def findings(
    profile: RtsProfile, catalogue: Catalogue, capacity: Callable[[], Capacity] = Capacity
) -> Iterator[StaticFinding]:
    """Yield all that is wrong with a system, as far as the types in `catalogue` are known.

    `capacity` is called where components have limits, and returns what their host has.
    """
    view = View(profile, catalogue)
    for look in _RULES:
        yield from look(view)
    yield from limit_remarks(view, capacity)
