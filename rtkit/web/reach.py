"""Decides where the page is reached: on this host, or beyond by TLS, or when told insecure."""

from __future__ import annotations

import os
import socket
import ssl
from collections.abc import Callable
from typing import NamedTuple

from rtkit.errors import Refused
from rtkit.keys import reach
from rtkit.link import insecure
from rtkit.link.places import host_name
from rtkit.serving.acceptor import bound_to

HERE = "127.0.0.1"
"""The address of the page, which only this host reaches."""
_EVERYWHERE = frozenset({"0.0.0.0", "::"})


class WebReach(NamedTuple):
    """Place where the page listens, and the names by which browsers may ask for it.

    Attributes:
        listener: The socket.
        tls: What it shows to browsers; None without TLS.
        names: In lower case; besides them the address at which a request came in, if others do.
        is_public: Other hosts reach it.
    """

    listener: socket.socket
    tls: ssl.SSLContext | None
    names: frozenset[str]
    is_public: bool

    @property
    def scheme(self) -> str:
        """Return ``http``, or ``https`` with TLS."""
        return "http" if self.tls is None else "https"

    @property
    def site(self) -> str:
        """Return the address without its secret; of all addresses that of the host's name."""
        address, port = self.listener.getsockname()[:2]
        shown = host_name() if address in _EVERYWHERE else address
        return f"{self.scheme}://{f'[{shown}]' if ':' in shown else shown}:{port}/"

    def noted(self) -> Callable[[], object]:
        """Have ``rtls -l`` show it while others reach it without TLS; return what ends that."""
        return insecure.note(self.site) if self.is_public and self.tls is None else _nothing


def reach_of(
    address: str, port: int, cert: str, key: str, *, is_insecure: bool = False
) -> WebReach:
    """Return a page's place, which listens already.

    Args:
        address: Where to listen; ``127.0.0.1`` is reached from this host only.
        port: 0 for a free one.
        cert: File with the certificate, and those between it and its CA; empty for no TLS.
        key: File with its key.
        is_insecure: Other hosts may reach it without TLS.

    Raises:
        Refused: Others would reach it without TLS; the certificate or its key cannot be used.
        Unreachable: The port is taken, or the address is none of this host.
    """
    if bool(cert) != bool(key):
        raise Refused("--cert and --key go together: a certificate and its key")
    is_public = not reach.is_here(address)
    if is_public and not cert and not is_insecure:
        raise Refused(
            f"on this host only, not {address}: nothing would be encrypted"
            " (--cert FILE --key FILE, or --insecure)"
        )
    tls = _shown(cert, key) if cert else None
    listener = bound_to(port, address.strip("[]"))
    listener.listen(128)
    own = {host_name(), address.strip("[]")} - _EVERYWHERE if is_public else {HERE}
    names = frozenset(each.lower() for each in {"localhost", *own})
    return WebReach(listener, tls, names, is_public)


def _shown(cert: str, key: str) -> ssl.SSLContext:
    try:
        mode = os.stat(key).st_mode & 0o777
        if mode & 0o077:
            raise Refused(f"others can read it (mode {mode:o}): {key} (chmod 600 if none has)")
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_3
        context.load_cert_chain(cert, key)
    except ssl.SSLError as error:
        raise Refused(f"{cert} and {key} are no certificate and its key: {error.reason}") from error
    except OSError as error:
        raise Refused(f"cannot read {error.filename or cert}: {error.strerror}") from error
    return context


def _nothing() -> None:
    """End nothing: nothing was noted."""
