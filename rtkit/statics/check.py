"""Check a system before anything runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rtkit.deployment.limits import Capacity
from rtkit.profile.rts_model import RtsProfile
from rtkit.statics.catalogue import Catalogue
from rtkit.statics.connectors import connector_remarks
from rtkit.statics.contexts import context_remarks
from rtkit.statics.limits import limit_remarks
from rtkit.statics.names import name_remarks
from rtkit.statics.orders import order_remarks
from rtkit.statics.parameters import parameter_remarks
from rtkit.statics.ports import port_remarks
from rtkit.statics.properties import property_remarks
from rtkit.statics.remark import Remark
from rtkit.statics.services import service_remarks
from rtkit.statics.upkeep import upkeep_remarks
from rtkit.statics.view import View

_RULES = (
    name_remarks,
    port_remarks,
    parameter_remarks,
    context_remarks,
    connector_remarks,
    service_remarks,
    order_remarks,
    upkeep_remarks,
    property_remarks,
)


def remarks(
    profile: RtsProfile, catalogue: Catalogue, capacity: Callable[[], Capacity] = Capacity
) -> Iterator[Remark]:
    """Yield all that is wrong with a system, as far as the types in `catalogue` tell.

    `capacity` is called where components have limits, and returns what their host has.
    """
    view = View(profile, catalogue)
    for look in _RULES:
        yield from look(view)
    yield from limit_remarks(view, capacity)
