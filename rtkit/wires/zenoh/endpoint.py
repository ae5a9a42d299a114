"""Zenoh endpoint of a service: answers queries of kept values at once, others on the loop."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable

from rtkit.errors import Unreachable
from rtkit.link import places, zenoh_keys
from rtkit.link.places import host_name, remove_socket
from rtkit.link.zenoh import await_answerer, open_listener, unix_endpoint
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.query_server import QueryServer
from rtkit.wires.zenoh.queries import PropertyEndpoint

_FOUND_S = 1.0
"""How long is waited until services of other hosts can find it [s]: who begins next may ask it."""
_RETRY = '{"period_init_ms": 500, "period_max_ms": 5000, "period_increase_factor": 2}'


def open_zenoh(
    host: PropertyEventLoop, service: PropertyProvider, hosts: Iterable[str] = ()
) -> None:
    """Answer queries for a service, on a socket of its own and through the manager of this host.

    Services of other `hosts` may ask it, too.

    Raises:
        Refused: The path of the socket does not do.
        Unreachable: The socket cannot be made.
    """
    path = places.check_socket_length(places.service_key_socket(service.name))
    with contextlib.suppress(FileNotFoundError):
        os.unlink(path)  # of one that was killed: the name is ours since the line endpoint is open
    manager = unix_endpoint(places.manager_socket(places.usual_manager()))
    more = {"connect/endpoints": json.dumps([manager]), "connect/retry": _RETRY}
    session = open_listener(unix_endpoint(path), more=more)
    host.at_end(lambda: remove_socket(path))
    host.at_end(session.close)
    keys = {"user": zenoh_keys.property_service(host_name(), service.name)}
    # 0080: who asks stands in the key, and links let each host ask by its own name only.
    keys |= {each: zenoh_keys.service_for(host_name(), service.name, each) for each in hosts}
    for identity, key in keys.items():
        query_server = QueryServer(host, service, "zenoh", identity)
        endpoint = PropertyEndpoint(session, key, query_server.take)
        query_server.send = endpoint.send
        host.at_end(endpoint.withdraw)
    if places.owner(places.usual_manager()):
        with contextlib.suppress(Unreachable):  # it ends, or is slow: found a little later, then
            await_answerer(manager, zenoh_keys.of_target(keys["user"], "name"), _FOUND_S)
