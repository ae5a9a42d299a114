"""Mutual TLS on sockets of endpoints and clients, for any wire over TCP.

A client is known by its certificate: it is let in when that is good, for as long as it is, and what
it SETs is on record.
"""

from __future__ import annotations

import socket
import ssl
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable
from logging import getLogger
from time import monotonic
from typing import Any

from rtkit.errors import RtkitError, Unreachable
from rtkit.keys import audit
from rtkit.keys.roles import RoleAccess
from rtkit.keys.tls import Peer, Trust, peer_of
from rtkit.property.access import DEFAULT_LIMITS, EndpointLimits
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer
from rtkit.property.requests import PropertyRequest
from rtkit.serving.acceptor import Acceptor
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.quota import EndpointQuota
from rtkit.serving.socket_client import SocketClient

PATIENCE_S = 5.0
"""How long a client may take until it has shown its certificate [s]."""
_RECORD = 1 << 14
"""Bytes of the largest record: of what is read in such pieces nothing stays behind in OpenSSL."""
_OTHER_HOST = (62, 64)
"""Codes of OpenSSL: the certificate is not for that name, that address."""
_REASONS = {
    "CERTIFICATE_REQUIRED": "it wants a certificate (rtkeys)",
    "HANDSHAKE_FAILURE": "it wants a certificate (rtkeys)",
    "CERTIFICATE_EXPIRED": "the certificate of this user has expired (rtkeys show)",
    "UNKNOWN_CA": "it does not know the CA of this user's certificate",
    "BAD_CERTIFICATE": "it does not take the certificate of this user",
}


class SecureStream:
    """Socket behind TLS, which behaves as a plain one.

    Args:
        tls: The socket.
        timeout_s: How long it waits where it may [s].
    """

    def __init__(self, tls: ssl.SSLSocket, timeout_s: float = 0.0) -> None:
        self.tls = tls
        self._timeout_s = timeout_s

    def recv(self, size: int, flags: int = 0) -> bytes:
        """Return what has come, more than asked for if it came as one record."""
        if flags:  # what is asked for is not to wait
            self.tls.settimeout(0)
        try:
            return self.tls.recv(max(size, _RECORD))
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError, TimeoutError):
            raise BlockingIOError from None
        except ssl.SSLError as error:
            raise meaning_of(error) from None
        finally:
            if flags:
                self.tls.settimeout(self._timeout_s)

    def send(self, data: Any) -> int:
        """Send as much as is taken; return how much that was."""
        try:
            return self.tls.send(memoryview(data)[:_RECORD])
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError, TimeoutError):
            raise BlockingIOError from None

    def sendall(self, data: bytes) -> None:
        """Send all of it."""
        view = memoryview(data)
        while view:
            view = view[self.send(view) :]

    def fileno(self) -> int:
        """Return its descriptor."""
        return self.tls.fileno()

    def setblocking(self, flag: bool, /) -> None:
        """Wait in `recv` and `send` as long as it may, or not."""
        self.settimeout(self._timeout_s if flag else 0.0)

    def settimeout(self, timeout_s: float) -> None:
        """Wait so long in `recv` and `send` [s]."""
        self._timeout_s = timeout_s
        self.tls.settimeout(timeout_s)

    def setsockopt(self, *args: Any) -> None:
        """Set an option of the socket."""
        self.tls.setsockopt(*args)

    def shutdown(self, how: int) -> None:
        """Send nothing more."""
        self.tls.shutdown(how)

    def close(self) -> None:
        """Be open no longer."""
        self.tls.close()


def meaning_of(error: ssl.SSLError) -> Exception:
    """Return what a failure of TLS means to a user."""
    text = (error.reason or "").upper()
    for reason, why in _REASONS.items():
        if reason in text:
            return PropertyError("denied", why)
    return OSError(error.errno, f"TLS: {error.reason or error}".lower().replace("_", " "))


def _cure(code: int, host: str) -> str:
    """Return what helps where a certificate does not name the host that was asked."""
    if code not in _OTHER_HOST:
        return ""
    return f" (rtkeys issue NAME --role ROLE --host {host} makes one that is)"


def connected(
    host: str, port: int, timeout_s: float, kind: type[ssl.SSLSocket] = ssl.SSLSocket
) -> SecureStream:
    """Connect to an endpoint, show the certificate of this user, and look at the other one.

    Args:
        host: Its name or address, which has to be in its certificate.
        port: Where it listens.
        timeout_s: Bound on all of it [s].
        kind: Class of the socket that is made.

    Raises:
        Unreachable: Nobody listens there, or it speaks no TLS.
        PropertyError: ``denied``: it is not who it should be.
        NotFound: There are no keys.
    """
    trust = Trust(is_server=False, is_brief=True)
    host = host.strip("[]")
    where = f"{host}:{port}"
    try:
        end = socket.create_connection((host, port), timeout_s)
    except OSError as error:
        raise Unreachable(f"cannot reach {where}: {error.strerror or error}") from error
    end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    try:
        context = trust.context()
        context.sslsocket_class = kind
        tls = context.wrap_socket(end, server_hostname=host)
    except ssl.SSLCertVerificationError as error:
        end.close()
        why = f"{error.verify_message}{_cure(error.verify_code, host)}"
        raise PropertyError("denied", f"{where} is not trusted: {why}") from None
    except TimeoutError:
        end.close()
        raise Unreachable(f"no answer within {timeout_s:.3g} s") from None
    except OSError as error:
        end.close()
        meant = meaning_of(error) if isinstance(error, ssl.SSLError) else error
        text = getattr(meant, "strerror", "") or str(meant)
        raise Unreachable(f"no TLS with {where}: {text}") from None
    if why := trust.refusal(peer_of(tls)):
        tls.close()
        raise PropertyError("denied", f"{where} is not trusted: {why}")
    return SecureStream(tls, timeout_s)


class SecureClient(SocketClient, ABC):
    """Client that shows a certificate, before a class that speaks a protocol with it.

    Attributes:
        trust: Says who may come in; given by the endpoint.
        peer: Who it is, None until it has shown that.
        address: Where it is.
        wire: Of the endpoint, for the record.
    """

    trust: Trust
    peer: Peer | None = None
    address = ""
    wire = ""
    _end: SecureStream

    @abstractmethod
    def refusal_to_send(self, why: str) -> bytes:
        """Return what tells a client that it is denied."""

    def ready(self, mask: int) -> bool:
        """See `IOHandler.ready`."""
        return bool(super().ready(mask)) if self.peer is not None or self._enter() else False

    def check(self, now: float) -> None:
        """See `IOHandler.check`: who is revoked, or whose certificate ends, is cut."""
        if self.peer is None:
            if now - self._moved_at > PATIENCE_S:
                self.close()
        elif self.trust.refusal(self.peer):
            self.close()
        else:
            super().check(now)

    def _enter(self) -> bool:
        """Go on with the handshake; return whether the client is in."""
        try:
            self._end.tls.do_handshake()
        except (ssl.SSLWantReadError, ssl.SSLWantWriteError):
            return False
        except (OSError, ValueError):
            self.close()
            return False
        peer = peer_of(self._end.tls)
        why = self.trust.refusal(peer, is_new=True)
        if why:
            self._record(peer, "enter", f"denied: {why}")
            try:
                self._end.send(self.refusal_to_send(why))
            except OSError:
                self._is_closing = True  # it does not wait for the word
            self.close()
            return False
        self.peer, self.identity = peer, peer.name
        self.access = RoleAccess(self.access.rules, peer.role)
        self._moved_at = monotonic()
        return True

    def _record(self, peer: Peer, what: str, result: str, value: object = None) -> None:
        try:
            audit.record(peer, self.address, self.wire, what, result, value)
        except (OSError, RtkitError) as error:
            getLogger("rtkit.properties").error("no record of %s: %s", what, error)

    def audited(self, ask: PropertyRequest, service: str) -> PropertyRequest:
        """See `Requester.audited`."""
        peer, answer = self.peer, ask.answer
        name = ask.target.partition("?")[0]
        if peer is None:
            return ask
        is_change = ask.payload is not None and not name.endswith(".listen")

        def answered(reply: Answer) -> None:
            result = f"{reply.error}: {reply.payload!s}" if reply.error else "done"
            if is_change:
                self._record(peer, f"SET {service}.{name}", result, ask.payload)
            elif reply.error == "denied":
                self._record(peer, f"GET {service}.{name}", result)
            answer(reply)

        return ask._replace(answer=answered)


class SecureAcceptor(Acceptor):
    """Port for clients that show a certificate of the CA.

    Args:
        wire: What it is called in rules.
        client: Makes what serves a client behind a stream.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        end: socket.socket,
        trust: Trust,
        wire: str,
        client: Callable[[SecureStream, EndpointQuota], SecureClient],
        limits: EndpointLimits = DEFAULT_LIMITS,
    ) -> None:
        self._trust, self._wire, self._client = trust, wire, client
        super().__init__(host, end, wire, limits)

    def admit(self, client: socket.socket) -> SecureClient | str:
        """See `Acceptor.enter`."""
        try:
            address = str(client.getpeername()[0])
            client.setblocking(False)
            client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            tls = self._trust.context().wrap_socket(
                client, server_side=True, do_handshake_on_connect=False
            )
        except (OSError, RtkitError) as error:
            return f"denied {error}"
        made = self._client(SecureStream(tls), self._quota)
        made.trust, made.address, made.wire = self._trust, address, self._wire
        return made

    def _make_room(self) -> bool:
        """See `Acceptor._make_room`; else whoever has most connections loses his oldest one."""
        if super()._make_room():
            return True
        counts = Counter(each.identity for each in self._clients)
        name, most = counts.most_common(1)[0]
        if most > 1:
            next(each for each in self._clients if each.identity == name).close()
            self._forget()
        return most > 1

    def reject(self, why: str) -> bytes:
        """See `Acceptor.reject`: before TLS there are no words."""
        return b""
