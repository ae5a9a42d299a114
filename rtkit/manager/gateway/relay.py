"""Relay of a manager: passes on what clients with certificates ask, if their role goes that far.

Clients speak the line protocol; a target is a key below that of the manager, quoted as in URLs.
Requests that take more than looking, and denied ones, are on record in the audit file.
"""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from math import inf
from time import monotonic, time
from typing import cast
from urllib.parse import unquote

from rtkit import fault
from rtkit.errors import RtkitError, Unreachable
from rtkit.keys.roles import includes
from rtkit.keys.tls import Trust
from rtkit.link import places, zenoh_keys
from rtkit.link.host_links import SETTLE_S
from rtkit.link.tcp_endpoint import Identity
from rtkit.link.zenoh import ZenohLink
from rtkit.manager.core.secrets import HIDDEN, hidden_in_json, is_secret
from rtkit.manager.gateway.connection import GatewayConnection
from rtkit.manager.gateway.permissions import (
    ADMINISTRATOR,
    LOCK,
    ROUTER,
    VIEWER,
    Permission,
    permission,
)
from rtkit.manager.gateway.plan_locks import PlanLocksOfClients
from rtkit.manager.gateway.router_links import RouterLinks
from rtkit.manager.gateway.taps import PREFIX, Taps
from rtkit.property.access import EndpointLimits
from rtkit.property.codes import PropertyError
from rtkit.property.exchange import Reply
from rtkit.property.messages import DONE, Answer, PropertyEvent, failed
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.subscription import Listener, SubscriptionOptions
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.serving.quota import EndpointQuota
from rtkit.wires.line.secure import Entered
from rtkit.wires.secure import SecureAcceptor, SecureStream

NAME = "manager"
IDENTITY = "~identity"
"""Target of the first request of a client: which manager of which realm it is."""
LIMITS = EndpointLimits(connections=128, listeners=8, door_listeners=1024, rate=500, size=1 << 22)
"""Limits of all clients; a batch of 10,000 creations has 2 MB."""
_LISTEN = ".listen"
_TIMEOUT_S = 10.0
_LONGEST_S = 7 * 86_400.0
_QUEUE = SubscriptionOptions(queue=256, is_all=True)
"""Texts that wait for one listener; a listener that misses one takes a new snapshot."""


class _Topic:
    """Topic of the manager, with those who listen to it."""

    def __init__(self) -> None:
        self.listeners: list[Listener] = []
        self.count = 0
        self.end: Callable[[], object] = lambda: None


class ManagerRelay(PropertyProvider):
    """Stands for a manager where other hosts ask it.

    Args:
        host: Owner of the loop that calls it.
        link: Leads to the manager.
        identity: Of the manager.
    """

    name = NAME
    has_groups = False

    def __init__(self, host: PropertyEventLoop, link: ZenohLink, identity: Identity) -> None:
        self._host = host
        self._link = link
        self._identity = identity
        self._service = zenoh_keys.service(identity.host, identity.manager)
        self._topics: dict[str, _Topic] = {}
        self._locks = PlanLocksOfClients(identity.host)
        self._taps = Taps(host, identity.manager)
        self._links = RouterLinks()
        self._under_way = 0
        self._is_answered = threading.Event()
        self._is_answered.set()

    def await_answers(self, timeout_s: float) -> None:
        """Wait until the manager has answered all that it was asked; not on the loop.

        The answer to the request to end is one of them: it must not be lost because it comes with
        the end. The loop sends what it has passed on before it ends.
        """
        self._is_answered.wait(timeout_s)

    def handle(self, ask: PropertyRequest) -> None:
        """See `PropertyProvider.handle`."""
        try:
            self._take(ask, cast(GatewayConnection, ask.caller))
        except PropertyError as error:
            ask.answer(Answer(str(error), error.code))
        except RtkitError as error:
            ask.answer(Answer(" ".join(str(error).split()), error.kind))
        except UnicodeDecodeError:
            ask.answer(Answer("not UTF-8", "malformed"))
        except Exception as error:
            # Whatever a client sends, the loop goes on.
            ask.answer(failed(error))

    def _take(self, ask: PropertyRequest, caller: GatewayConnection) -> None:
        target, _, parameters = ask.target.partition("?")
        if target == IDENTITY:
            ask.answer(Answer(json.dumps([zenoh_keys.realm(), *self._identity])))
            return
        topic = target.removesuffix(_LISTEN)
        name = unquote(topic, errors="strict")
        if topic != target:
            self._check(permission(name, None), caller)
            self._listen(topic, name, parameters, caller)
            ask.answer(DONE)
            return
        if name.startswith(PREFIX) and ask.payload is not None:
            self._tap(ask, name.removeprefix(PREFIX), caller)
            return
        payload = ask.payload.decode() if isinstance(ask.payload, bytes) else ask.payload
        wanted = permission(name, payload)
        self._check(wanted, caller)
        if name == ROUTER and payload is not None:
            self._link_up(ask, payload, caller, wanted)
            return
        if name == LOCK and payload is not None:
            payload = self._locks.stated(payload, caller, f"{caller.identity} at {caller.address}")
        self._pass_on(ask, name, payload, wanted)

    def _link_up(
        self, ask: PropertyRequest, payload: str, caller: GatewayConnection, wanted: Permission
    ) -> None:
        """Have a client be a link; the answer is the id that it tells when it is made again."""

        def join() -> None:
            try:
                caller.join(places.manager_socket(self._identity.manager))
            except Unreachable as error:
                ask.answer(Answer(str(error), error.kind))
                return
            caller.record(f"{wanted.what} at {self._identity.manager}", "done")
            ask.answer(Answer(self._links.add(caller)))

        if self._links.end(payload.partition(" ")[2], caller):
            caller.do_at(monotonic() + SETTLE_S, join)
        else:
            join()

    def _tap(self, ask: PropertyRequest, word: str, caller: GatewayConnection) -> None:
        def record(what: str, result: str) -> None:
            caller.record(f"{what} at {self._identity.manager}", result)

        self._taps.take(ask, word, caller, lambda wanted: self._check(wanted, caller), record)

    @staticmethod
    def _may(caller: GatewayConnection, role: str) -> bool:
        return caller.peer is not None and includes(caller.peer.role, role)

    def _check(self, wanted: Permission, caller: GatewayConnection) -> None:
        """Refuse what is too much for the role of a caller.

        Raises:
            PropertyError: ``denied``.
        """
        if self._may(caller, wanted.role):
            return
        peer = caller.peer
        who = f"{peer.name} ({peer.role})" if peer is not None else "nobody"
        caller.record(f"{wanted.what} at {self._identity.manager}", "denied")
        raise PropertyError("denied", f"{who} may not {wanted.what}: it takes {wanted.role}")

    def _pass_on(
        self, ask: PropertyRequest, name: str, payload: str | None, wanted: Permission
    ) -> None:
        caller = cast(GatewayConnection, ask.caller)
        left_s = _TIMEOUT_S if ask.until == inf else min(ask.until - monotonic(), _LONGEST_S)

        def give(reply: Reply) -> None:
            self._count(-1)
            if name == LOCK and reply.error and payload is not None:
                self._locks.refused(caller, payload)
            if wanted.role != VIEWER:
                result = f"{reply.error}: {reply.text}" if reply.error else "done"
                caller.record(f"{wanted.what} at {self._identity.manager}", result)
            text = " ".join(reply.text.split()) if reply.error else reply.text
            if not self._may(caller, ADMINISTRATOR):
                text = HIDDEN if is_secret(name, text) else hidden_in_json(text)
            ask.answer(Answer(text, reply.error))

        def answered(reply: Reply) -> None:
            fault.point("gateway.answered")
            self._host.post(partial(give, reply))

        self._count(1)
        try:
            self._link.ask_later(f"{self._service}/{name}", payload, max(left_s, 0.001), answered)
        except Unreachable as error:
            give(Reply(str(error), error.kind))

    def _count(self, more: int) -> None:
        """Count the requests that wait for an answer of the manager."""
        self._under_way += more
        if self._under_way:
            self._is_answered.clear()
        else:
            self._is_answered.set()

    def _listen(self, target: str, name: str, options: str, caller: GatewayConnection) -> None:
        """Have a caller listen to a topic, or no longer.

        Raises:
            PropertyError: It is none; or the caller, or all together, listen to enough.
        """
        if not name.startswith("@x/line/"):
            raise PropertyError("denied", f"nobody listens to {name}")
        if "remove" in options.split("&"):
            self._leave(name, caller)
            return
        topic = self._topics.get(name)
        if topic is not None and any(each.caller is caller for each in topic.listeners):
            return
        listener = Listener(target, (), _QUEUE, caller)
        caller.listen(listener)
        if topic is None:
            topic = self._topics[name] = _Topic()

            def take(text: str) -> None:
                self._host.post(partial(self._send_text, name, text))

            topic.end = self._link.listen(f"{self._service}/{name}", take)
        topic.listeners.append(listener)

    def _send_text(self, name: str, text: str) -> None:
        topic = self._topics.get(name)
        if topic is None:
            return
        topic.count += 1
        shown = hidden_in_json(text)
        for listener in topic.listeners:
            caller = cast(GatewayConnection, listener.caller)
            sent = text if self._may(caller, ADMINISTRATOR) else shown
            listener.push(PropertyEvent(listener.name, sent, time(), topic.count))
            caller.wake()

    def _leave(self, name: str, caller: Requester) -> None:
        topic = self._topics[name] if name in self._topics else _Topic()
        for listener in [each for each in topic.listeners if each.caller is caller]:
            topic.listeners.remove(listener)
            caller.unlisten(listener)
        if not topic.listeners:
            topic.end()
            self._topics.pop(name, None)

    def tick(self) -> None:
        """See `PropertyProvider.tick`: nothing has a lease."""
        return

    def forget(self, caller: Requester) -> None:
        """See `PropertyProvider.forget`: what it listens to ends, and the locks that it has."""
        self._taps.forget(caller)
        self._links.forget(caller)
        for given in self._locks.left_by(caller):
            with suppress(Unreachable):
                key = f"{self._service}/{LOCK}"
                self._link.ask_later(key, given, _TIMEOUT_S, lambda _reply: None)
        for name in list(self._topics):
            self._leave(name, caller)


def open_gateway(host: PropertyEventLoop, end: socket.socket) -> None:
    """Let clients with certificates in, at a bound socket.

    Raises:
        NotFound: There are no keys.
        Refused: The keys cannot be used.
    """
    trust = Trust(is_server=True)

    def client(stream: SecureStream, quota: EndpointQuota) -> GatewayConnection:
        return GatewayConnection(host, stream, NAME, "", Entered(host.services), quota)

    SecureAcceptor(host, end, trust, "tls", client, LIMITS)
