"""Rule of every wire: other hosts reach what asks them for a certificate, or was told insecure.

Whatever listens asks here before it is bound.
"""

from __future__ import annotations

from ipaddress import ip_address

from rtkit.errors import Refused

HERE = ("", "localhost", "127.0.0.1")
BEHIND_TLS = frozenset({"tcps", "https", "mqtts", "tls"})
"""Schemes of which both sides show certificates."""
ON_LOOPBACK = frozenset({"ice"})
"""Schemes that stay on this host whatever is told: their messages are not even signed."""


def is_here(host: str) -> bool:
    """Return whether only this host reaches what listens at an address."""
    if host in HERE:
        return True
    try:
        return ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def check(scheme: str, host: str, *, is_insecure: bool = False) -> None:
    """Check whether to listen at the address of a host, or to talk with a broker there.

    Raises:
        Refused: Others could read along: it is not this host, nor behind mutual TLS.
    """
    if is_here(host) or scheme in BEHIND_TLS or (is_insecure and scheme not in ON_LOOPBACK):
        return
    hint = "" if scheme in ON_LOOPBACK else " (tcps, https and mqtts are; or --insecure)"
    raise Refused(f"on this host only, not {host}: nothing would be encrypted{hint}")
