"""TCP endpoint of a manager: a port of this host, for clients that know the user's secret.

It is a session of its own, in front of the one on the Unix socket, because one session cannot ask
for a password on one of its endpoints only.
"""

from __future__ import annotations

import json
import resource
import socket
import time
from collections.abc import Callable
from typing import NamedTuple

import zenoh

from rtkit.errors import Malformed, Unreachable
from rtkit.link import zenoh_keys
from rtkit.link.secret import Secret
from rtkit.link.zenoh import ask, open_client, open_listener

LOOPBACK = "127.0.0.1"
_ROUTE_S = 5.0
_AGAIN_S = 0.005
_PATIENCE_S = 0.25
"""How long the first question about a manager may be without an answer until it is repeated [s]."""
_INTRODUCE_S = 1.0
"""How long who connects has to prove that he knows the secret [s]."""
_MOST = 500
"""How many clients may be let in at a time, and how many may be about to prove that they may."""
_SHARE = 8
"""Which part of all descriptors each of those may take at most: slaves and the Unix socket need the
rest."""


class Identity(NamedTuple):
    """Identity of a manager: its host, its name there, and its id in direct addresses."""

    host: str
    manager: str
    id: str


def introduce(session: zenoh.Session, identity: Identity) -> Callable[[], object]:
    """Answer for a manager's identity on its session; return the function that withdraws it."""
    key, text = zenoh_keys.introduction(), json.dumps(identity)

    def asked(query: zenoh.Query) -> None:
        query.reply(key, text)
        query.drop()  # type: ignore[no-untyped-call]

    handler = zenoh.handlers.Callback(asked, indirect=False)
    return session.declare_queryable(key, handler).undeclare


def open_endpoint(port: int, inner_endpoint: str, secret_file: str) -> zenoh.Session:
    """Open a port to those who know the secret; it leads to the session at `inner_endpoint`.

    Raises:
        Unreachable: The port is taken, or the endpoint leads nowhere.
    """
    most = str(min(_MOST, resource.getrlimit(resource.RLIMIT_NOFILE)[0] // _SHARE))
    more = {
        "connect/endpoints": json.dumps([inner_endpoint]),
        "transport/auth/usrpwd/dictionary_file": json.dumps(secret_file),
        "transport/unicast/accept_timeout": str(int(_INTRODUCE_S * 1000)),
        "transport/unicast/accept_pending": most,
        "transport/unicast/max_sessions": most,
    }
    session = open_listener(f"tcp/{LOOPBACK}:{port}", more=more)
    try:
        ask_identity(session, _ROUTE_S)
    except Unreachable:
        session.close()  # type: ignore[no-untyped-call]
        raise
    return session


def free_port() -> int:
    """Return a port that nobody has at present."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def is_free(port: int) -> bool:
    """Return whether a port can be listened on."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((LOOPBACK, port))
            probe.listen(1)
        except OSError:
            return False
    return True


def log_in(port: int, secret: Secret, timeout_s: float) -> zenoh.Session:
    """Open a client session through an endpoint.

    Raises:
        Unreachable: Nobody listens there, or not to this secret.
    """
    more = {
        "transport/auth/usrpwd/user": json.dumps(secret.user),
        "transport/auth/usrpwd/password": json.dumps(secret.password),
    }
    return open_client(f"tcp/{LOOPBACK}:{port}", timeout_s, more=more)


def ask_identity(session: zenoh.Session, timeout_s: float) -> Identity:
    """Return the identity of the manager behind an endpoint.

    An endpoint that has just been opened may not know of its manager yet, or lose the question:
    it is asked again, with more patience each time.

    Raises:
        Unreachable: None answers, or only one of another realm.
    """
    began = now = time.monotonic()
    while (left_s := began + timeout_s - now) > 0:
        key, text = _introduction(session, min(left_s, _PATIENCE_S + now - began))
        if key == zenoh_keys.introduction():
            return _identity(text)
        if key:
            break
        time.sleep(_AGAIN_S)
        now = time.monotonic()
    raise Unreachable("no manager of this realm answers there")


def _introduction(session: zenoh.Session, timeout_s: float) -> tuple[str, str]:
    """Return key and text of what the manager behind an endpoint says of itself, "" for none."""
    for reply in ask(session, zenoh_keys.introduction("*"), timeout_s):
        if reply.ok is not None:
            return str(reply.ok.key_expr), reply.ok.payload.to_string()
    return "", ""


def _identity(text: str) -> Identity:
    try:
        host, manager, id = json.loads(text)
    except (ValueError, TypeError) as error:
        raise Malformed(f"not who a manager is: {text[:80]!r}") from error
    return Identity(str(host), str(manager), str(id))
