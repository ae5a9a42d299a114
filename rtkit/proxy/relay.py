"""Relay service without properties of its own: asks another one, and forwards answers and events.

Nothing here understands a value; but names pass through `PrefixedNames`, and what may be set is
decided here. What begins with ``~proxy`` it answers itself: whom it stands for, and whether that is
there.

See decision 27.
"""

from __future__ import annotations

import itertools
import math
import uuid
from collections.abc import Callable, Hashable, Sequence
from time import monotonic

from rtkit.property.codes import PropertyError
from rtkit.property.idempotency import IdempotencyCache, is_shared, marked, shared
from rtkit.property.lanes import wait_of
from rtkit.property.messages import Answer
from rtkit.property.naming import RequestTarget, parse_target, write_parameters
from rtkit.property.reading import read
from rtkit.property.requests import (
    PASSES_ON,
    VIA,
    PropertyRequest,
    Requester,
    is_among_proxies,
    split_via,
)
from rtkit.property.values import Value
from rtkit.proxy.narrowing import describes_access, narrowed
from rtkit.proxy.prefix import Allowed, PrefixedNames
from rtkit.proxy.subscriptions import RelayedSubscriptions
from rtkit.proxy.uplink import Uplink
from rtkit.serving.event_loop import PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.provider_connection import STATUS, ConnectionMaker, ProviderConnection

MOST_HOPS = 8
ROUTE = "~proxy.route"
_SEEN = "seen"
_LISTEN = "listen"
ITSELF = "that would be a proxy of itself"
_TOO_MANY = f"more than {MOST_HOPS} proxies, one after the other"


class Relay(PropertyProvider):
    """Stands for the owner of properties.

    Args:
        on_status: Called with why whenever the owner is gone, and with nothing when it is back.
        id: Of the service that it is a part of, if that has one: they may stand for each other.

    Attributes:
        name: Under which it is found.
        has_groups: Each who listens does so by itself.
        on_refusal: Hears of each request that was denied: who, method, target.
    """

    has_groups = False

    def __init__(
        self,
        host: PropertyEventLoop,
        connect: ConnectionMaker,
        *,
        names: PrefixedNames,
        allowed: Allowed,
        on_status: Callable[[str], None],
        id: str = "",
    ) -> None:
        self.name = ""
        self.on_refusal: Callable[[str, str, str], object] | None = None
        self._names = names
        self._is_allowed = allowed
        self._on_status = on_status
        self._id = id or f"p{uuid.uuid4().hex[:12]}"
        self._is_part = bool(id)
        self._owner_passes_on: bool | None = None if id else False  # None: it knows no `via`
        self._judged: ProviderConnection | None = None
        self._count = itertools.count(1)
        self._numbers: dict[Hashable, int] = {}
        self._once = IdempotencyCache()
        self.uplink = Uplink(host, connect, self._judge, self._came, self._went)
        self._listenings = RelayedSubscriptions(self.uplink, names.outward, monotonic)

    # Methods for the loop

    def tick(self) -> None:
        """See `PropertyProvider.tick`."""
        self._listenings.tick()
        self.uplink.check(monotonic())

    def forget(self, caller: Requester) -> None:
        """See `PropertyProvider.forget`."""
        if caller.origin is caller:
            self._numbers.pop(caller, None)
        self._listenings.forget(caller)

    def end(self) -> None:
        """Stand for nobody any more, and tell the listeners so."""
        self.uplink.close()
        self._listenings.end("unknown")

    # Requests

    def handle(self, ask: PropertyRequest) -> None:
        """See `PropertyProvider.handle`."""
        try:
            if is_among_proxies(ask.target):
                ask = split_via(ask)
            check_way(self._id, ask.via)
            target = parse_target(ask.target)
            if target.service and target.service != self.name:
                raise PropertyError("no-service", f"no such service: {target.service}")
            self._take(target, ask)
        except PropertyError as error:
            ask.answer(Answer(str(error), error.code))

    def _take(self, target: RequestTarget, ask: PropertyRequest) -> None:
        name = target.name
        if name in (STATUS, ROUTE):
            self._answer_own(target, ask)
            return
        if name == PASSES_ON:
            self._forward(name, {}, ask)
            return
        above = self._names.above(name)
        if above is not None:
            self._answer_above(above, target, ask)
            return
        name = self._names.inward(name)
        listened = _listened(name)
        if listened is not None:
            # Who listens reads; who else does is for those to know who may set.
            method = "SET" if ask.payload is None else "GET"
            self._check_caller(method, target.name, ask.caller)
        if listened is not None and ask.payload is not None:
            self._listen(listened, target, ask)
            return
        self._check_caller("GET" if ask.payload is None else "SET", target.name, ask.caller)
        if ask.payload is not None and not self._is_allowed(target.name):
            self._refuse("SET", target.name, ask.caller, "the proxy lets nobody set it")
        if ask.payload is None and describes_access(target.name, target.parameters):
            ask = ask._replace(answer=self._narrowing(target.name, ask))
        self._forward(name, target.parameters, ask)

    def _narrowing(self, name: str, ask: PropertyRequest) -> Callable[[Answer], object]:
        """Return what answers with the access that whoever asks has through this proxy."""

        def may_set(property_name: str) -> bool:
            return self._is_allowed(property_name) and ask.caller.may("SET", property_name)

        def answer(reply: Answer) -> None:
            if isinstance(reply.payload, str) and not reply.error:
                reply = Answer(narrowed(name, reply.payload, may_set, self._names.outward))
            ask.answer(reply)

        return answer

    def _forward(self, name: str, parameters: dict[str, str | None], ask: PropertyRequest) -> None:
        given = dict(parameters)
        id, answer = "", ask.answer
        if ask.payload is not None:
            # The one that another proxy gave it goes on as what it is, not as a parameter.
            own = given.pop("id") if is_shared(given.get("id")) else ask.id
            id = "" if "id" in given else self._shared(own or "", ask.caller.origin)
        given |= self._way(ask)
        text = f"{name}?{write_parameters(given)}" if given else name
        if id:
            # Not every owner knows of ids; and what it has answered need not travel again.
            first = self._once.first((id, text, marked(ask.payload)), answer)
            if first is None:
                return
            answer = first
        now = monotonic()
        wait = wait_of(ask, now)
        self.uplink.ask(text, ask.payload, id, answer, now + wait if wait else math.inf)

    def _way(self, ask: PropertyRequest) -> dict[str, str | None]:
        """Return who has passed a request on, for an owner that might do so, too, and knows it."""
        if self._owner_passes_on is None or not (ask.via or self._owner_passes_on):
            return {}
        return {VIA: ".".join((*ask.via, self._id))}

    def _shared(self, id: str, origin: Hashable) -> str:
        """Return by what the owner knows a repetition, empty for nothing."""
        if not id or is_shared(id):
            return id
        number = self._numbers.get(origin) or next(self._count)
        self._numbers[origin] = number
        return shared(self._id, str(number), id)

    def _check_caller(self, method: str, name: str, caller: Requester) -> None:
        if not caller.may(method, name):
            self._refuse(method, name, caller, f"by {caller.identity or 'who is not known'}")

    def _refuse(self, method: str, name: str, caller: Requester, why: str) -> None:
        if self.on_refusal is not None:
            self.on_refusal(caller.identity, method, name)
        raise PropertyError("denied", f"{method} of {name}: {why}")

    def _listen(self, name: str, target: RequestTarget, ask: PropertyRequest) -> None:
        payload = ask.payload
        ref = payload if isinstance(payload, str) else (payload or b"").decode("utf-8", "replace")
        if ref.strip() != "self":
            # The owner has an allow-list of who may be notified; asking for it is a SET.
            whose = _listened(target.name) or target.name
            self._check_caller("SET", whose, ask.caller)
            if not self._is_allowed(whose):
                self._refuse("SET", whose, ask.caller, "the proxy lets nobody set it")
            self._forward(f"{name}.{_LISTEN}", target.parameters, ask)
            return
        given = dict(target.parameters)
        removed = given.pop("remove", "false")
        if removed is None or _is_true(removed):
            self._listenings.remove(name, ask.caller, ask.answer)
        else:
            self._listenings.begin(name, given | self._way(ask), ask.caller, ask.answer)

    # Requests that it answers itself

    def _answer_own(self, target: RequestTarget, ask: PropertyRequest) -> None:
        if ask.payload is not None:
            raise PropertyError("read-only", f"cannot be set: {target.name}")
        if target.name == STATUS:
            ask.answer(Answer("up" if self.uplink.is_up else "down"))
            return
        hops, seen = route_target(target)
        if self._id in seen:
            ask.answer(Answer(f"({self._id})"))
            return
        self.ask_route(hops, seen, lambda reply: ask.answer(route_answer(self._id, [reply])))

    def ask_route(self, hops: int, seen: list[str], answer: Callable[[Answer], object]) -> None:
        """Ask what the owner stands for: over a connection that is being judged, too.

        So two that connect to each other at the same moment learn of it.
        """
        text = f"{ROUTE}?hops={hops + 1}&{_SEEN}={','.join([*seen, self._id])}"
        if self.uplink.is_up or self._judged is None:
            self.uplink.ask(text, None, "", answer)
        else:
            self._judged.ask(text, None, "", answer)

    def _judge(self, connection: ProviderConnection, judged: Callable[[str], None]) -> None:
        """Find out whether a connection leads back to here; of a part, what is to be told there."""
        self._judged = connection

        def noted(reply: Answer) -> None:
            self._judged = None
            self._owner_passes_on = None if reply.error else str(reply.payload) == "1"
            judged(str(reply.payload) if reply.error in ("no-service", "timeout") else "")

        def answered(reply: Answer) -> None:
            self._judged = None
            if reply.error == "conflict":
                judged(str(reply.payload))
            elif not reply.error and self._id in str(reply.payload).strip("()").split():
                judged(ITSELF)
            elif reply.error in ("no-service", "timeout"):
                judged(str(reply.payload))
            else:
                judged("")

        if self._is_part:
            connection.ask(PASSES_ON, None, "", noted)
            return
        connection.ask(f"{ROUTE}?hops=1&{_SEEN}={self._id}", None, "", answered)

    def _answer_above(self, place: str, target: RequestTarget, ask: PropertyRequest) -> None:
        """Answer for the inner names that only the prefix makes."""
        self._check_caller("GET" if ask.payload is None else "SET", target.name, ask.caller)
        if ask.payload is not None:
            raise PropertyError("read-only", f"cannot be set: {target.name}")
        options = {
            key: True if text is None else read(text) for key, text in target.parameters.items()
        }
        timeout = options.pop("timeout", None)
        if not options:
            ask.answer(Answer(self._names.listed(place)))
            return
        unknown = options.keys() - {"all", "depth", "match", "names", "values", "meta"}
        if unknown:
            raise PropertyError("bad-parameter", f"properties has no parameter {min(unknown)}")

        def answered(reply: Answer) -> None:
            if not reply.error:
                try:
                    listing = self._names.widened(place, str(reply.payload), options)
                    reply = Answer(listing)
                except PropertyError as error:
                    reply = Answer(str(error), error.code)
            answer(reply)

        answer = self._narrowing(target.name, ask) if _is(options.get("meta")) else ask.answer
        shown = self._names.shown_of_owner(place, options)
        if not shown:
            answered(Answer("()"))
            return
        more = "".join(f"&{key}" for key in ("values", "meta") if _is(options.get(key)))
        if way := self._way(ask):
            more += f"&{VIA}={way[VIA]}" + (f"&timeout={timeout}" if timeout else "")
        listing = self._names.inward(self._names.prefix)
        self.uplink.ask(f"{listing}?{shown}{more}", None, "", answered)

    # The connection

    def _came(self) -> None:
        self._on_status("")
        self._listenings.came()

    def _went(self, why: str) -> None:
        self._listenings.went()
        self._on_status(why)


def check_way(id: str, via: Sequence[str]) -> None:
    """Refuse a request that comes back to a service which has passed it on.

    Raises:
        PropertyError: ``no-service``; ``conflict``: too many have passed it on.
    """
    if id in via:
        raise PropertyError("no-service", ITSELF)
    if len(via) > MOST_HOPS:
        raise PropertyError("conflict", _TOO_MANY)


def route_target(target: RequestTarget) -> tuple[int, list[str]]:
    """Read a request for a route: how many proxies it has passed, and which.

    Raises:
        PropertyError: ``conflict``: too many.
    """
    text = target.parameters.get("hops") or "0"
    hops = int(text) if text.isdecimal() else MOST_HOPS
    if hops >= MOST_HOPS:
        raise PropertyError("conflict", _TOO_MANY)
    return hops, (target.parameters.get(_SEEN) or "").split(",")


def route_answer(id: str, behind: Sequence[Answer]) -> Answer:
    """Return the route of a service: its id, then those behind it, as far as they answered."""
    if (conflict := next((each for each in behind if each.error == "conflict"), None)) is not None:
        return conflict
    routes = [str(each.payload).strip("()") for each in behind if not each.error]
    return Answer(f"({' '.join([id, *filter(None, routes)])})")


def _listened(name: str) -> str | None:
    """Return the property of which the listeners are meant, None if it is something else."""
    if name == _LISTEN:
        return ""
    return name.removesuffix(f".{_LISTEN}") if name.endswith(f".{_LISTEN}") else None


def _is(value: Value | None) -> bool:
    return value not in (None, False, 0)


def _is_true(text: str) -> bool:
    return _is(read(text))
