"""Connects to a manager: by its name on this host, or by the address of its TCP endpoint."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from rtkit.errors import Unreachable
from rtkit.link.places import host_name, manager_socket, owner, usual_manager
from rtkit.tree.api import as_text
from rtkit.tree.client import DEFAULT_TIMEOUT_S, Tree, bounded

if TYPE_CHECKING:
    from rtkit.rtc.manager_address import Address

_EMPTY_HELLO = b"\x16\x03\x01\x00\x04\x01\x00\x00\x00"
_ALERT, _ALERT_S = b"\x15", 1.0
"""How a greeting of TLS that holds nothing is answered, and within which time [s]."""


def connect(
    manager: str = "", timeout_s: float = DEFAULT_TIMEOUT_S, kind: type[Tree] = Tree
) -> Tree:
    """Connect to a manager of this host, by default the one that the settings name.

    `manager` may also be an address, ``localhost:2811`` or ``corbaloc::localhost:2811``, or one of
    a linked host, ``robot1/manager``. What is returned is of the `kind`.

    Raises:
        Unreachable: It does not run, or does not answer within `timeout_s` [s].
        Refused: Another user can have laid its socket.
    """
    if not manager and "RTKIT_MANAGER" not in os.environ:
        from rtkit.settings import layers

        layers.read().apply()
    name = as_text(manager, "a manager's name") or usual_manager()
    if ":" in name:
        from rtkit.rtc.manager_address import parse_address

        return connect_at(parse_address(name), timeout_s, kind)
    if "/" in name:
        host, _, manager = name.partition("/")
        return connect_far(host, manager, timeout_s, kind)
    from rtkit.link.requests.manager_link import open_link
    from rtkit.link.running import why_absent

    if not os.path.exists(manager_socket(name)):
        raise Unreachable(why_absent(name))
    host = host_name()
    try:
        link = open_link(name, host, bounded(timeout_s))
    except Unreachable as error:
        if owner(name) is None:
            raise Unreachable(why_absent(name)) from error
        raise Unreachable(f"manager {name!r} does not answer within {timeout_s:g} s") from error
    tree = kind(link, host, name, timeout_s)
    tree.has_ended = lambda: owner(name) is None
    return tree


def connect_far(
    host: str, manager: str, timeout_s: float = DEFAULT_TIMEOUT_S, kind: type[Tree] = Tree
) -> Tree:
    """Connect to a manager of another host, over the link that a manager here has to that host.

    Raises:
        Unreachable: There is no link, or it is lost; says why.
        Refused: Another user can have laid the socket of the manager here.
    """
    from rtkit.link import host_links

    link = host_links.read(host)
    if link.why:
        raise Unreachable(f"host {host} cannot be reached: {link.why}")
    if manager not in ("", link.far_manager):
        raise Unreachable(
            f"manager {manager} of host {host} cannot be reached: the link to that host leads to"
            f" its manager {link.far_manager}"
        )
    near = connect(link.manager, timeout_s, kind)
    tree = kind(near.link, host, manager or link.far_manager, timeout_s)
    tree.place = host
    return tree


def is_behind_tls(tree: Tree) -> bool:
    """Return whether a manager is reached by a certificate, at its port for those."""
    from rtkit.rtc.manager_address import is_address

    return is_address(tree.place)


def near_of(tree: Tree) -> Tree:
    """Return a connection to the manager of this host that links the one of a tree.

    It is that tree itself where that is of this host; else it shares its link.

    Raises:
        Unreachable: There is no link.
    """
    from rtkit.link import host_links
    from rtkit.rtc.names import is_local_host

    if is_local_host(tree.host, host_name()):
        return tree
    return Tree(tree.link, host_name(), host_links.read(tree.host).manager, tree.timeout_s)


def connect_at(
    address: Address, timeout_s: float = DEFAULT_TIMEOUT_S, kind: type[Tree] = Tree
) -> Tree:
    """Connect to the manager that listens at an address, with TLS where that is of another host.

    Raises:
        Unreachable: None of this user answers there, or another one than was meant.
        Refused: The secret or certificate of this user cannot be used.
        NotFound: It takes a certificate, and there is none.
    """
    from rtkit.rtc.names import is_local_host

    if not is_local_host(address.host, host_name()):
        return _connect_secure(address, timeout_s, kind)
    from rtkit.link import secret, tcp_endpoint
    from rtkit.link.zenoh import ZenohLink

    try:
        session = tcp_endpoint.log_in(address.port, secret.read(), bounded(timeout_s))
    except Unreachable as error:
        if not tcp_endpoint.is_free(address.port):
            if _takes_certificates(address):
                return _connect_secure(address, timeout_s, kind)
            why = "is in use, and lets nobody in: it is busy, or no manager of this user"
            raise Unreachable(f"{address} {why}") from error
        hint = f"start one there with: rtmgr start NAME -p {address.port}"
        raise Unreachable(f"no manager of this user listens at {address} ({hint})") from error
    try:
        identity = tcp_endpoint.ask_identity(session, bounded(timeout_s))
        if address.id not in ("", identity.id, identity.manager):
            raise Unreachable(f"the manager at {address} is {identity.manager}, not {address.id}")
    except Unreachable:
        session.close()  # type: ignore[no-untyped-call]
        raise
    return kind(ZenohLink(session), identity.host, identity.manager, timeout_s)


def _takes_certificates(address: Address) -> bool:
    """Return whether what listens at an address of this host speaks TLS."""
    import socket

    with socket.create_connection((address.host, address.port), _ALERT_S) as end:
        end.settimeout(_ALERT_S)
        try:
            end.sendall(_EMPTY_HELLO)
            return end.recv(1) == _ALERT
        except OSError:
            return False


def _connect_secure(address: Address, timeout_s: float, kind: type[Tree]) -> Tree:
    from rtkit.tree.secure_link import connect_secure

    link, host, manager, id = connect_secure(address.host, address.port, bounded(timeout_s))
    if address.id not in ("", id, manager):
        link.close()
        raise Unreachable(f"the manager at {address} is {manager}, not {address.id}")
    tree = kind(link, host, manager, timeout_s)
    tree.place = f"{address.host}:{address.port}"
    return tree


def connect_near(address: Address, timeout_s: float = DEFAULT_TIMEOUT_S) -> tuple[Tree, str]:
    """Connect to what an address stands for; return the slave too that it means, "" for none.

    Where no manager of this user has that port, the usual port stands for the manager of the
    address's id, and any other for a slave of it, as in create strings.

    Raises:
        Unreachable: There is no such manager.
    """
    from rtkit.rtc.manager_address import DEFAULT_ID
    from rtkit.rtc.names import is_local_host

    name = address.id or DEFAULT_ID
    if not is_local_host(address.host, host_name()):
        return connect_at(address, timeout_s), ""
    try:
        return connect_at(address, timeout_s), ""
    except Unreachable as error:
        try:
            tree = connect(name, timeout_s)
        except Unreachable:
            raise error from None
    return tree, slave_at(address, name)


def slave_at(address: Address, manager: str) -> str:
    """Return the slave of a manager that an address stands for, "" for the manager itself."""
    from rtkit.rtc.manager_address import DEFAULT_PORT

    return "" if address.port == DEFAULT_PORT else f"{manager}_{address.port}"
