"""Property service of one owner: answers GET and SET of named properties, and sends changes.

Theory of operation
-------------------
*A core.* Requests come in with what takes their answer; nothing here knows sockets, threads or a
clock, which is handed in. Only one thread at a time may be inside: the lock is that of the loop
that serves the endpoints. It is left only while code of users runs (`user_code`).

*Who owns what.* `registry.Registry` owns the names, and what each stands for: a property, an inner
node, an extension of one of these, or a part of a value. `node.PropertyNode` holds one property:
what is declared, the value, its text, its listeners. `live_values.LiveValues` reads values, puts
them in force and has the change sent. `listeners.Listeners` owns who listens, each with a queue of
its own (`subscription.Listener`); an endpoint empties it as fast as its client takes it.
`functional_requests` starts functional properties, `extensions` answers what is asked about a
property, `bulk` what is asked about several, `polling` looks again at what is computed. `Service`
only decides which of these a request goes to, and whether its caller may.

*A request.* Its target is a name, perhaps with parameters. The caller is looked at first
(`permit`), before anything tells that a name is there. A GET leads to a payload, a SET to nothing
unless it asks for an echo. What fails becomes an answer with a code; nothing is raised at an
endpoint. The answer is given exactly once. A SET that is repeated with its id acts once
(`idempotency`).

*Values are characters end to end.* Only this service, as the owner's, parses a value, checks it
against what is declared, and writes it; endpoints and proxies pass payloads on. A node writes its
text once and keeps it until the value changes.

*Where user code runs.* Readers, writers, getters, actions and what lists names may take any time
(decision 38). A request that calls none is answered at once, on the thread that brought it. Others
go to a lane (`lanes`): those of one property wait for each other, so that it is got and set in the
order of the requests, and nobody else waits. What hangs is refused when its requester has given up.

*Names may change.* An owner that exports an object tells through ``on_names`` which members there
are now. They are looked for before names are listed and when a name is missed, never at a GET of
what is known. A member that turns out to hold an object raises `Unfolded`; the request is then done
once more with the names of that object.

*Fast paths* (decision 34). Nearly all requests are a GET or SET of one kept property, and nothing
else: `fast_path` answers their lines as bytes, `handle` reads a kept value with two look-ups,
`set_plain` skips parameters, parts and writers. Each refuses whatever else there is, and then the
long way is taken, which comes to the same.

*Invariants.* A revision grows with each change of a value and never falls. A value in force fits
what is declared. Of several properties that are set at once all change or none, and each is checked
before the first is set. A listener receives the present value first, then changes in their order; a
full queue drops its oldest and counts it; the last event of a property that is removed says so.

Source: `property-service` reference.
"""

from __future__ import annotations

import time as _time
from collections.abc import Callable
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import partial
from math import inf
from typing import Any

from rtkit.property import block_requests, functional_requests
from rtkit.property.codes import PropertyError
from rtkit.property.extensions import Extensions
from rtkit.property.fast_path import FastPath
from rtkit.property.functional import FunctionalProperty
from rtkit.property.idempotency import IdempotencyCache, identity_of
from rtkit.property.lanes import alone, first_only, lane_of, wait_of
from rtkit.property.live_values import LiveValues
from rtkit.property.messages import DONE, Answer, Payload, failed
from rtkit.property.mounting import MountTable
from rtkit.property.naming import RequestTarget, parse_target
from rtkit.property.node import PropertyNode
from rtkit.property.parameters import COMMON, OF_GET, checked_parameters, flag
from rtkit.property.polling import Poller
from rtkit.property.property_spec import PropertySpec, Reader, Writer, plain
from rtkit.property.registry import NameEntry
from rtkit.property.requests import (
    PASSES_ON,
    PropertyRequest,
    Requester,
    UnderWay,
    is_among_proxies,
    split_via,
)
from rtkit.property.types import Content, check, from_payload
from rtkit.property.user_code import Unfolded
from rtkit.property.values import Value


class Service:
    """Properties of one owner.

    Attributes:
        values: Reads them and puts them in force.
        registry: Their names.
        listeners: Receivers of changes.
        extensions: Answers what is asked about them.
        on_refusal: Hears of each request that was denied: who, method, target.
        quick: Answers a request line of the kind that most are.
        host: The loop that serves it, where it is served.
        mounts: Its mount points, None while it has had none.
        has_groups: Those who listen in the same way may share one listener.
    """

    has_groups = True

    def __init__(
        self,
        name: str = "",
        *,
        clock: Callable[[], float] = _time.monotonic,
        wall: Callable[[], float] = _time.time,
    ) -> None:
        self.name = name
        self.values = LiveValues(clock, wall)
        self.registry = self.values.registry
        self.listeners = self.values.listeners
        self.extensions = Extensions(self.values, self.permit, self.get)
        self.on_refusal: Callable[[str, str, str], object] | None = None
        self.host: object = None
        self.mounts: MountTable | None = None
        self._nodes = self.registry.nodes
        self._set_plain = self.values.set_plain
        self._poller = Poller(self.values)
        self._histories: list[tuple[str, int]] = []
        self._joining = block_requests.Joining()
        self._idempotency = IdempotencyCache()
        self._fast_path = FastPath(self.values)
        self.quick = self._fast_path.reply
        self._started = wall()
        self._has_user_code = False

    # Methods for the owner.

    def add(
        self,
        name: str,
        value: Content | None = None,
        spec: PropertySpec | str = "any",
        *,
        read: Reader | None = None,
        write: Writer | None = None,
        function: FunctionalProperty | None = None,
        history: int = 0,
    ) -> PropertyNode:
        """Register a property.

        Args:
            name: Segments joined by dots.
            value: The first one, where it is kept here.
            spec: Its declaration, or the name of its type.
            read: Computes the value instead.
            write: Puts a value in force.
            function: Makes it a functional property.
            history: How many values are remembered.

        Raises:
            PropertyError: ``conflict``: the name is taken or reserved; ``bad-value``.
        """
        declared = plain(spec) if isinstance(spec, str) else spec
        if read is not None and write is None and declared.access == "rw":
            declared = replace(declared, access="r")
        if value is not None:
            value = declared.admit(value)
        node = PropertyNode(name, declared, value, self._started)
        node.reader, node.writer, node.function = read, write, function
        self.registry.add(node)
        self._has_user_code = self._has_user_code or bool(read or write)
        most = history or self._history_of(node.name)
        if most:
            from collections import deque

            node.history = deque(maxlen=most)
            if node.reader is not None:
                self._poller.remembered[node.name] = node
        if self.listeners.of_names:
            self.listeners.names_changed(added=node.name)
        return node

    def remember(self, pattern: str, most: int) -> None:
        """Keep a history of each property that a pattern matches and that is added from now on.

        Args:
            pattern: Of names; of several that match, the first one counts.
            most: How many values are remembered.
        """
        self._histories.append((pattern, most))

    def _history_of(self, name: str) -> int:
        return next((most for each, most in self._histories if fnmatchcase(name, each)), 0)

    def remove(self, name: str, *, only: bool = False) -> None:
        """Remove a property with all below it; its listeners receive the removal as the last event.

        Args:
            name: Segments joined by dots.
            only: Properties below it stay.

        Raises:
            PropertyError: ``unknown``.
        """
        self._fast_path.forget()
        for node in self.registry.remove(name, only=only):
            self._poller.remembered.pop(node.name, None)
            self.listeners.end_all(node)
            if self.listeners.of_names:
                self.listeners.names_changed(removed=node.name)

    def update(self, name: str, value: Content, quality: str = "good") -> None:
        """Put a value in force, whatever its access: the owner's way to change one.

        Raises:
            PropertyError: ``unknown``; ``bad-value``: it does not fit what is declared.
        """
        node = self._nodes.get(name)
        if node is None:
            raise PropertyError("unknown", f"no such property: {name}")
        self.values.keep(node, check(node.spec.type, value), quality)

    def push(self, name: str, value: Content) -> None:
        """Put a value in force, as `update` does; from now on its owner tells all of its changes.

        A name that is not there, because it is hidden, is passed over.
        """
        if name in self._nodes:
            self.listeners.pushed.add(name)
            self.update(name, value)

    def get(self, target: str) -> Payload:
        """Return what a GET of the owner leads to.

        Raises:
            PropertyError: As answered.
        """
        return self._asked(target, None)

    def set(self, target: str, payload: Payload) -> Payload:
        """Return what a SET of the owner leads to.

        Raises:
            PropertyError: As answered.
        """
        return self._asked(target, payload)

    def _asked(self, target: str, payload: Payload | None) -> Payload:
        answers: list[Answer] = []
        self._answer(PropertyRequest(target, payload, answers.append))
        if not answers:
            raise PropertyError("busy", f"not answered at once: {target}")
        return answers[0].value()

    # Methods for endpoints.

    def revision(self, name: str) -> int | None:
        """Return the revision of a property, None of what is none."""
        node = self._nodes.get(name)
        return None if node is None else node.revision

    def is_text(self, name: str) -> bool:
        """Return whether a property holds text that is no value."""
        node = self._nodes.get(name)
        return node is not None and node.spec.type.base == "text"

    def is_plain(self, name: str) -> bool:
        """Return whether a property is kept here and nothing is called when it is got or set."""
        node = self._nodes.get(name)
        return node is not None and not (node.reader or node.writer or node.function)

    def handle(self, ask: PropertyRequest) -> None:
        """Answer a request, now or later; never raises for what is asked."""
        if is_among_proxies(ask.target):
            if ask.target == PASSES_ON:
                ask.answer(Answer(str(int(self.mounts is not None))))
                return
            ask = split_via(ask)
        if self.mounts is None or not self.mounts.takes(ask):
            self.handle_own(ask)

    def handle_own(self, ask: PropertyRequest) -> None:
        """Answer a request about what is not mounted."""
        if ask.payload is None:
            node = self._nodes.get(ask.target)
            # Decision 34: nearly all requests are of this kind; the rest refuses or widens it.
            is_kept = node is not None and node.reader is None and node.value is not None
            if is_kept and ask.caller.may("GET", ask.target):
                assert node is not None
                ask.answer(_read_kept(node))
                return
        lane = lane_of(self.values, ask) if self._has_user_code else None
        if lane is None:
            self._answer(ask)
            return
        asked, now = ask._replace(answer=first_only(ask.answer)), self.values.clock()
        wait = wait_of(ask, now)
        # A proxy may be passed anew by what user code asks; who asks in turn is not asked again.
        in_turn = tuple(each for each in ask.via if each.startswith("-"))
        if in_turn:  # what went round from elsewhere may be in its lane, and wait for this
            lane = alone()
        under_way = UnderWay(in_turn, now + (wait or inf))
        work = partial(under_way.call, partial(self._answer, asked))
        self.values.user_code.later(lane, work, asked.answer, wait)

    def _answer(self, ask: PropertyRequest) -> None:
        try:
            answer = self._done(self._perform, ask)
        except PropertyError as error:
            if self.mounts is not None and self.mounts.takes(ask, is_again=True):
                return  # a mount that was found only now
            answer = Answer(str(error), error.code)
        except Exception as error:
            answer = failed(error)
        if answer is not None:
            ask.answer(answer)

    def _done(self, work: Callable[..., Answer | None], *asked: Any) -> Answer | None:
        """Do what was asked, once more if a member turned out to hold something else than known."""
        try:
            return work(*asked)
        except Unfolded:
            self.values.names_now()
            return work(*asked)

    def _perform(self, ask: PropertyRequest) -> Answer | None:
        node = self._nodes.get(ask.target)
        # Decision 34: a name and nothing else, which most are, needs no reading.
        is_plain = node is not None and not node.function and not ask.id
        if is_plain and ask.payload is not None and ask.caller.may("SET", ask.target):
            assert node is not None
            self._set_plain(node, ask.payload)
            return DONE
        target = parse_target(ask.target)
        if target.service and target.service != self.name:
            raise PropertyError("no-service", f"no such service: {target.service}")
        method = "GET" if ask.payload is None else "SET"
        last = target.name.rpartition(".")[2]
        if last == "listen":
            method = "GET"  # listening is reading
        if last != "properties" or method == "GET":
            self.permit(ask.caller, method, target.name)
        # Of several that are set at once each is looked at by itself.
        if ask.payload is None:
            return Answer(self._get(target, ask))
        key = identity_of(ask, target.parameters.get("id"))
        if key is None:
            return self._set(target, ask)
        answer = self._idempotency.first(key, ask.answer)
        if answer is None:
            return None
        try:
            # In here, so that a repetition that came meanwhile waits for the answer that counts.
            outcome = self._done(self._set, target, ask._replace(answer=answer))
        except Exception as error:
            outcome = failed(error)
        if outcome is not None:
            answer(outcome)
        return None

    @property
    def is_polled(self) -> bool:
        """Return whether something that is listened to is to be read anew from time to time."""
        return self._poller.is_needed

    def poll(self) -> None:
        """Read anew what is computed and listened to."""
        self._poller.poll()

    def tick(self) -> None:
        """End the leases that are over."""
        self.listeners.tick()
        if self.mounts is not None:
            self.mounts.tick()

    def forget(self, caller: Requester) -> None:
        """Send nothing any more to who is gone."""
        self.listeners.end_caller(caller)
        if self.mounts is not None:
            self.mounts.forget(caller)

    def permit(self, caller: Requester, method: str, name: str) -> None:
        """Refuse a request that the rules of an endpoint deny to a caller.

        Raises:
            PropertyError: ``denied``.
        """
        if caller.may(method, name):
            return
        if self.on_refusal is not None:
            self.on_refusal(caller.identity, method, name)
        raise PropertyError("denied", f"{method} by {caller.identity or 'nobody'}: {name}")

    def _get(self, target: RequestTarget, ask: PropertyRequest) -> Payload:
        place = self.values.find(target.name)
        if place.extension:
            return self.extensions.get(place, target, ask.caller)
        node = place.node
        if node is None:
            if place.path:
                raise PropertyError("write-only", f"cannot be read: {target.name}")
            checked_parameters((), target, OF_GET)
            self.values.names_now()
            return self.registry.listed(place.name)
        if node.function is not None:
            checked_parameters((), target, OF_GET)
            return functional_requests.described(node.function, place)
        is_bytes = node.spec.type.base == "bytes" and target.parameters
        common = {**OF_GET, **block_requests.OF_GET} if is_bytes else OF_GET
        given = checked_parameters(node.spec.parameters, target, common)
        given.pop("timeout", None)
        block = block_requests.taken(node.spec, given) if is_bytes else None
        payload = self.values.payload_of(place, given)
        return block_requests.cut(payload, block) if block else payload

    def _set(self, target: RequestTarget, ask: PropertyRequest) -> Answer | None:
        assert ask.payload is not None
        place = self.values.find_to_set(target.name)
        if place.extension:
            self.extensions.set(place, target, ask)
            return DONE
        node = place.node
        if node is None and place.path:
            may = partial(self.permit, ask.caller, "SET")
            functional_requests.stop_all(self.registry, place.name, may)
            return DONE
        if node is None:
            raise PropertyError("read-only", f"cannot be set: {target.name}")
        if node.function is not None:
            return functional_requests.start(self.values, place, target, ask)
        is_bytes = node.spec.type.base == "bytes" and target.parameters
        common = {**COMMON, **block_requests.OF_SET} if is_bytes else COMMON
        given = checked_parameters(node.spec.parameters, target, common)
        has_echo = flag(given, "echo")
        given.pop("timeout", None)
        given.pop("id", None)
        self.values.check_writable(node, target.name, given.pop("if", None))
        block = block_requests.taken(node.spec, given) if is_bytes else None
        if block:
            self._set_block(node, ask.payload, given, block)
        else:
            self.values.set_at(place, ask.payload, given)
        return Answer(self._get(RequestTarget(target.name, {}), ask)) if has_echo else DONE

    def _set_block(
        self, node: PropertyNode, payload: Payload, given: dict[str, Value], block: dict[str, int]
    ) -> None:
        """Carry out a SET of a block of bytes; the last one puts the whole in force."""
        data = from_payload(node.spec.type, payload)
        assert isinstance(data, bytes)
        old = partial(self.values.payload_of, NameEntry(node.name, node), {})
        whole = self._joining.put(node.name, old, data, block)
        if whole is not None:
            self.values.apply(node, whole, given)


def _read_kept(node: PropertyNode) -> Answer:
    try:
        return Answer(node.payload)
    except PropertyError as error:
        return Answer(str(error), error.code)
