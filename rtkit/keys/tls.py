"""Mutual TLS with the keys of this user: TLS 1.3, where both sides show a certificate of the CA.

Version 1.3 has no renegotiation, and no tickets are given: each connection shows it again.
"""

from __future__ import annotations

import os
import ssl
from time import monotonic, time
from typing import Any, NamedTuple

from rtkit.errors import Refused, RtkitError
from rtkit.keys import folder
from rtkit.keys.roles import role_of

_LOOK_S = 0.2
"""How old what is known of the list of the revoked may be [s]."""


_FILES = (folder.CA_CERTIFICATE, folder.CERTIFICATE, folder.KEY, folder.REVOKED)


class Peer(NamedTuple):
    """Owner of the certificate on the other side.

    Attributes:
        ends: When it is good no longer [s since 1970].
    """

    name: str
    role: str
    serial: int
    ends: float


class Trust:
    """Trust in certificates by the folder of keys: its files are read anew when they change.

    Args:
        is_server: For connections that others make.
        is_brief: Look only once who is revoked, at the handshake: OpenSSL does, whose list need not
            be read by a library that takes 60 ms to load.

    Raises:
        NotFound: There are no keys.
        Refused: Others can read the key, or a file cannot be used.
    """

    def __init__(self, *, is_server: bool, is_brief: bool = False) -> None:
        self._protocol = ssl.PROTOCOL_TLS_SERVER if is_server else ssl.PROTOCOL_TLS_CLIENT
        # Later the process may be told of another folder: what it serves keeps this one.
        self._files = tuple(map(folder.file, _FILES))
        self._is_brief = is_brief
        self._stamp: tuple[object, ...] = ()
        self._context = self.context()
        self._revoked_stamp: object = None
        self._revoked: frozenset[int] = frozenset()
        self._looked_at = -_LOOK_S
        self._why = ""
        if not is_brief and (why := self._look()):
            raise Refused(why)

    def context(self) -> ssl.SSLContext:
        """Return what connections are made with."""
        stamp = tuple(map(_stamp, self._files[:3]))
        if stamp != self._stamp:
            self._context = _context(self._protocol, *self._files[:3])
            self._stamp = stamp
            if self._is_brief:
                _check_revoked(self._context, self._files[3])
        return self._context

    def refusal(self, peer: Peer, *, is_new: bool = False) -> str:
        """Return why a peer is not, or no longer, to be talked with; empty if it is.

        Of one that `is_new` what was revoked just now counts, too.
        """
        if not peer.name or not peer.role:
            return "a certificate without name or role"
        if time() > peer.ends:
            return f"the certificate of {peer.name} has expired"
        if self._is_brief:
            return ""
        now = monotonic()
        if is_new or now - self._looked_at >= _LOOK_S:
            self._looked_at, self._why = now, self._look()
        if self._why:
            return self._why
        return f"the certificate of {peer.name} is revoked" if peer.serial in self._revoked else ""

    def _look(self) -> str:
        """Read the list of the revoked if it has changed; return why it cannot be used."""
        ca, _, _, gone = self._files
        stamp = _stamp(gone)
        if stamp == self._revoked_stamp and not self._why:
            return ""
        from cryptography import x509

        from rtkit.keys.authority import revoked

        try:
            authority = x509.load_pem_x509_certificate(folder.read(ca))
            self._revoked = frozenset(revoked(folder.read(gone), authority))
        except (RtkitError, ValueError) as error:
            return f"who is revoked cannot be told: {error}"
        self._revoked_stamp = stamp
        return ""


def peer_of(tls: ssl.SSLSocket) -> Peer:
    """Return the identity on the other side of a connection, by a certificate of the CA."""
    shown: Any = tls.getpeercert() or {}
    pairs = [pair for part in shown.get("subject", ()) for pair in part]
    names = [value for key, value in pairs if key == "commonName"]
    uris = [value for kind, value in shown.get("subjectAltName", ()) if kind == "URI"]
    return Peer(
        names[0] if len(names) == 1 else "",
        role_of(uris),
        int(shown.get("serialNumber", "0"), 16),
        ssl.cert_time_to_seconds(shown["notAfter"]) if "notAfter" in shown else 0.0,
    )


def _context(protocol: ssl._SSLMethod, ca: str, shown: str, secret: str) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.minimum_version = ssl.TLSVersion.TLSv1_3
    context.verify_mode = ssl.CERT_REQUIRED
    if protocol == ssl.PROTOCOL_TLS_SERVER:
        context.num_tickets = 0
    authority = folder.read(ca)
    certificate = folder.opened(shown)
    try:
        key = folder.opened(secret)
        try:
            context.load_verify_locations(cadata=authority.decode("ascii"))
            # The checked file is read; a key that wants a password is none of ours.
            files = (f"/proc/self/fd/{certificate}", f"/proc/self/fd/{key}")
            context.load_cert_chain(*files, password=str)
        finally:
            os.close(key)
    except (ssl.SSLError, ValueError) as error:
        raise Refused(f"keys in {os.path.dirname(ca)} cannot be used: {error}") from None
    finally:
        os.close(certificate)
    return context


def _check_revoked(context: ssl.SSLContext, gone: str) -> None:
    """Have each handshake refuse who is revoked by a list of the CA."""
    descriptor = folder.opened(gone)
    try:
        context.load_verify_locations(cafile=f"/proc/self/fd/{descriptor}")
    except ssl.SSLError as error:
        raise Refused(f"who is revoked cannot be told: {gone}: {error}") from None
    finally:
        os.close(descriptor)
    context.verify_flags |= ssl.VERIFY_CRL_CHECK_LEAF


def _stamp(path: str) -> object:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns
