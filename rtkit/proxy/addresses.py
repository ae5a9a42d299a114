"""Resolves addresses of a proxy: an owner to ask on one side, an endpoint to open on the other.

An address is ``SCHEME:REST`` of a wire of `rtkit.wires.table`, or a path of the tree.
"""

from __future__ import annotations

from rtkit.errors import Malformed
from rtkit.link import places
from rtkit.link.places import host_name
from rtkit.link.running import services
from rtkit.property.codes import PropertyError
from rtkit.property.naming import escape
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.blocking_connection import blocking_calls
from rtkit.wires.table import WIRES, scheme_of, wire_of
from rtkit.wires.wire import ProviderAddress, WireSettings


def source_of(address: str, cwd: str, settings: WireSettings) -> ProviderAddress:
    """Return the owner that an address stands for; `cwd` is the working directory in the tree.

    Raises:
        RtkitError: It is no address, or it has to be asked for its name and cannot be reached.
    """
    scheme = _scheme_of(address, "a way to a service")
    if not scheme:
        return _in_tree(address, cwd, settings)
    return wire_of(scheme).provider(address.removeprefix(f"{scheme}:"), settings)


def open_endpoint(address: str, owner: PropertyProvider, settings: WireSettings) -> str:
    """Open the endpoint of an address, on the loop; return its full address.

    Raises:
        RtkitError: It is no address, or the endpoint cannot be opened.
    """
    scheme = _scheme_of(address, "an endpoint") or "zenoh"
    settings.host.add(owner)
    return wire_of(scheme).open(address.removeprefix(f"{scheme}:"), owner, settings)


_KNOWN = f"there is {' '.join(f'{scheme}:' for scheme in WIRES)} and paths of the tree"


def _scheme_of(address: str, what: str) -> str:
    """Return the scheme of an address, empty for a path of the tree."""
    scheme = scheme_of(address)
    if not scheme and ":" in address.partition("/")[0]:
        raise Malformed(f"not {what}: {address} ({_KNOWN})")
    return scheme


def _in_tree(path: str, cwd: str, settings: WireSettings) -> ProviderAddress:
    from rtkit.tree.live_place import open_live, split, steps_of
    from rtkit.tree.property_targets import parse

    place = parse(path, cwd, places.services(), host_name())
    if place.service and not place.name:
        socket = places.service_socket(place.service)
        return wire_of("unix").provider(socket, settings)._replace(name=place.service)
    node, name = split(path, cwd)
    if node and not name:
        return ProviderAddress(
            blocking_calls(settings.host, lambda: open_live(node, settings.timeout_s)),
            escape(node.rpartition("/")[2].rpartition(".")[0]),
        )
    if not node and path.startswith("/"):
        from rtkit.tree.far_places import far_place
        from rtkit.wires.zenoh.far_services import FarService

        place, kind = far_place(place, steps_of(path, cwd), places.services(), settings.timeout_s)
        if kind == "far" and not place.name:
            return FarService.parse(place.service).provider(settings)
    known = " ".join(services()) or "none"
    raise PropertyError("no-service", f"no service: {path} (there is {known})")
