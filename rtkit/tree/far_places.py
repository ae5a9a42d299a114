"""Resolves properties of other hosts: ``/HOST/SERVICE.NAME`` of services, ``/HOST.services``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.errors import Unreachable
from rtkit.link.host_links import is_linked
from rtkit.link.places import host_name, usual_manager
from rtkit.link.running import why_absent
from rtkit.property.codes import PropertyError
from rtkit.property.naming import EXTENSIONS
from rtkit.rtc.names import LOCAL
from rtkit.tree.property_targets import (
    OwnerKind,
    PropertyTarget,
    no_service,
    no_service_here,
    parse,
)
from rtkit.wires.zenoh.far_services import FarService, services_of

if TYPE_CHECKING:
    from rtkit.tree.live_properties import FarHost
    from rtkit.wires.property_client import PropertyClient


def far_place(
    place: PropertyTarget, steps: Sequence[str], here: Sequence[str], timeout_s: float
) -> tuple[PropertyTarget, OwnerKind]:
    """Return where a property of another host is, by the steps of its path.

    `here` are the services of this host, for the message if there is none of that name.

    Raises:
        PropertyError: ``no-service``: there is none.
        Unreachable: The host cannot be reached.
    """
    from rtkit.tree.live_properties import FarHost

    host, *rest = steps
    if not rest:
        host, dot, name = host.partition(".")
        rest = [name] if dot else []
    why = f"no link leads to host {host}, and it lets host {host_name()} ask no service"
    try:
        known = services_of(host, timeout_s)
    except Unreachable:
        if is_linked(host):
            raise
        known, why = [], why_absent(usual_manager())
    found = parse("/".join(["", LOCAL, *rest]), "/", known, LOCAL)
    if found.service:
        far = f"/{host}/{found.service}"
        return place._replace(service=far, name=found.name), "far"
    if is_linked(host) and found.name.split(".")[0] in ("", *FarHost.NAMES, *EXTENSIONS):
        return place._replace(service=f"/{host}", name=found.name), "far host"
    if not (is_linked(host) or known):
        raise no_service_here(place.name, here, f"; {why}")
    raise no_service("/".join(rest), known, f" on host {host}")


def open_far(path: str, timeout_s: float) -> PropertyClient:
    """Connect to a service of another host, ``/HOST/SERVICE``, or to what is known of the host.

    Raises:
        Unreachable: The host cannot be reached.
    """
    from rtkit.wires.waiting_client import WaitingClient

    far = FarService.parse(path)
    if not far.name:
        return far_host(path, timeout_s)
    return WaitingClient(lambda loop: far.connect(loop, timeout_s), timeout_s)


def far_host(path: str, timeout_s: float) -> FarHost:
    """Return another host, ``/HOST``, as a client."""
    from rtkit.tree.live_properties import FarHost

    def services() -> list[str]:
        try:
            return services_of(path.strip("/"), timeout_s)
        except Unreachable as error:
            raise PropertyError("no-service", str(error)) from error

    return FarHost(services)
