"""Opens the TCP ports of a manager: that of its user, and that of others with certificates."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from rtkit.link.tcp_endpoint import Identity, introduce
from rtkit.manager.core.state import ManagerState
from rtkit.manager.endpoints.listening_process import TcpEndpoint, open_front, open_gateway
from rtkit.rtc.names import LOCAL
from rtkit.settings.configuration import tcp_endpoint_settings
from rtkit.settings.values import tls_endpoint

if TYPE_CHECKING:
    from zenoh import Session


def open_ports(
    state: ManagerState,
    session: Session,
    endpoint: TcpEndpoint | None,
    inner: str,
    warn: Callable[[str], None],
    stack: ExitStack,
) -> None:
    """Open the TCP port for this user, where it is wanted and can be had; and that for others."""
    identity = Identity(state.host, state.name, state.settings.text("manager.name"))
    withdraw = introduce(session, identity)
    try:
        if endpoint is not None:
            state.port = open_front(tcp_endpoint_settings(state.settings), endpoint, inner, warn)
            stack.callback(endpoint.close)
        state.properties["rtkit.tls_address"] = ""
        wanted = tls_endpoint(state.settings.text("net.tls"))
        if wanted is not None:
            gateway, port = open_gateway(wanted, inner)
            stack.callback(gateway.close)
            state.properties["rtkit.tls_address"] = f"{wanted[0]}:{port}"
    finally:
        stack.callback(withdraw)
    state.properties["rtkit.address"] = f"{LOCAL}:{state.port}" if state.port else ""
