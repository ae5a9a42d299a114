"""Connects to a manager by its address: through its front door, with the secret of this user."""

from __future__ import annotations

import os

from rtkit.errors import Unreachable
from rtkit.rtc.address import DEFAULT_ID, DEFAULT_PORT, Address
from rtkit.rtc.names import is_local_host
from rtkit.tree.client import DEFAULT_TIMEOUT_S, Tree, bounded, connect


def connect_at(address: Address, timeout_s: float = DEFAULT_TIMEOUT_S) -> Tree:
    """Connect to the manager that listens at an address.

    Raises:
        Unreachable: None of this user answers there, or another one than was meant.
        Refused: The secret of this user cannot be used.
    """
    from rtkit.link import door, secret
    from rtkit.link.zenoh import ZenohLink

    if not is_local_host(address.host, os.uname().nodename):
        raise Unreachable(f"managers of other hosts cannot be reached yet: {address}")
    try:
        session = door.enter(address.port, secret.read(), bounded(timeout_s))
    except Unreachable as error:
        raise Unreachable(f"no manager of this user listens at {address}") from error
    try:
        identity = door.ask_identity(session, bounded(timeout_s))
        if address.id not in ("", identity.id, identity.manager):
            raise Unreachable(f"the manager at {address} is {identity.manager}, not {address.id}")
    except Unreachable:
        session.close()  # type: ignore[no-untyped-call]
        raise
    return Tree(ZenohLink(session), identity.host, identity.manager, timeout_s)


def connect_near(address: Address, timeout_s: float = DEFAULT_TIMEOUT_S) -> tuple[Tree, str]:
    """Connect to what an address stands for; return the slave too that it means, "" for none.

    Where no manager of this user has that port, the usual port stands for the manager of the
    address's id, and any other for a slave of it, as in create strings.

    Raises:
        Unreachable: There is no such manager.
    """
    name = address.id or DEFAULT_ID
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
    return "" if address.port == DEFAULT_PORT else f"{manager}_{address.port}"
