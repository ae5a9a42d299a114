"""Property service of one owner: answers GET and SET of named properties, and sends changes.

Pure: asks come in, answers and events go out through what they were given; clocks are given too.
Only one thread at a time may be inside; what calls user code lets others in meanwhile.
Source: `property-service` reference.
"""

from __future__ import annotations

import time as _time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import partial

from rtkit.property import components
from rtkit.property.actions import described, start
from rtkit.property.codes import PropertyError
from rtkit.property.extensions import get_extension, set_extension
from rtkit.property.fast_path import FastPath
from rtkit.property.functional import FunctionalProperty
from rtkit.property.idempotency import IdempotencyCache, identity_of
from rtkit.property.lanes import NAMES, first_only, lane_of, wait_of
from rtkit.property.listeners import Listeners
from rtkit.property.messages import DONE, Answer, Payload, failed
from rtkit.property.naming import RequestTarget, parse_target
from rtkit.property.node import PropertyNode
from rtkit.property.parameters import COMMON, OF_GET, checked_parameters
from rtkit.property.reading import read
from rtkit.property.registry import NameEntry, Registry
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.spec import PropertySpec, Reader, Writer, plain
from rtkit.property.types import Content, check, from_payload, parse_type, to_payload
from rtkit.property.user_code import AT_ONCE, Unfolded, UserCode, result_of
from rtkit.property.values import Value, is_number
from rtkit.property.writing import write

_NONE: dict[str, Value] = {}


class Service:
    """Properties of one owner.

    Attributes:
        on_refusal: Hears of each request that was denied: who, method, target.
        quick: Answers a request line of the kind that most are.
        on_names: Called before names are told or missed, to have those that there are now.
        remembered: What is computed and has a history, by name.
        user_code: Calls what is not ours.
        notifies: Returns who listens for a property elsewhere; None where none can.
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
        self.clock = clock
        self.wall = wall
        self.registry = Registry()
        self.listeners = Listeners(self)
        self.on_refusal: Callable[[str, str, str], object] | None = None
        self.on_names: Callable[[], object] | None = None
        self.notifies: Callable[[str, str], Requester] | None = None
        self._nodes = self.registry.nodes
        self.remembered: dict[str, PropertyNode] = {}
        self._histories: list[tuple[str, int]] = []
        self._once = IdempotencyCache()
        self._quick = FastPath(self)
        self.quick = self._quick.reply
        self._started = wall()
        self.user_code: UserCode = AT_ONCE
        self._has_user_code = False
        self._is_looking = False

    # What the owner does.

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
            spec: What is declared, or the name of its type.
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
                self.remembered[node.name] = node
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

    def remove(self, name: str) -> None:
        """Remove a property with all below it; its listeners receive the removal as the last event.

        Raises:
            PropertyError: ``unknown``.
        """
        self._quick.forget()
        for node in self.registry.remove(name):
            self.remembered.pop(node.name, None)
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
        has_changed = node.put(check(node.spec.type, value), self.wall(), quality)
        if node.listeners:
            self.listeners.changed(node, has_changed)

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

    # What endpoints do.

    def set_plain(self, node: PropertyNode, payload: Payload) -> None:
        """Carry out a SET of a property with nothing else to it, for who may.

        Raises:
            PropertyError: As answered.
        """
        spec = node.spec
        if "w" not in spec.access:
            self.check_writable(node, node.name)
        value = spec.within(from_payload(spec.type, payload))
        if node.writer is None and node.reader is None and "r" in spec.access:
            self._keep(node, value)
        else:
            self.apply(node, value)

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
        if ask.payload is None:
            node = self._nodes.get(ask.target)
            # Nearly all requests are of this kind; the rest only refuses or widens it.
            is_kept = node is not None and node.reader is None and node.value is not None
            if is_kept and ask.caller.may("GET", ask.target):
                assert node is not None
                ask.answer(_read_kept(node))
                return
        lane = lane_of(self, ask) if self._has_user_code else None
        if lane is None:
            self._answer(ask)
        else:
            asked = ask._replace(answer=first_only(ask.answer))
            work = partial(self._answer, asked)
            self.user_code.later(lane, work, asked.answer, wait_of(ask, self.clock()))

    def _answer(self, ask: PropertyRequest) -> None:
        try:
            try:
                answer = self._perform(ask)
            except Unfolded:
                self.names_now()
                answer = self._perform(ask)
        except PropertyError as error:
            answer = Answer(str(error), error.code)
        except Exception as error:
            answer = failed(error)
        if answer is not None:
            ask.answer(answer)

    def _perform(self, ask: PropertyRequest) -> Answer | None:
        node = self._nodes.get(ask.target)
        # A name and nothing else, which most are, needs no reading.
        is_plain = node is not None and not node.function and not ask.id
        if is_plain and ask.payload is not None and ask.caller.may("SET", ask.target):
            assert node is not None
            self.set_plain(node, ask.payload)
            return DONE
        target = parse_target(ask.target)
        if target.service and target.service != self.name:
            raise PropertyError("no-service", f"no such service: {target.service}")
        method = "GET" if ask.payload is None else "SET"
        last = target.name.rpartition(".")[2]
        if last == "listen":
            method = "GET"  # who listens reads
        if last != "properties" or method == "GET":
            self.permit(ask.caller, method, target.name)
        # Of several that are set at once each is looked at by itself.
        if ask.payload is None:
            return Answer(self._get(target, ask))
        key = identity_of(ask, target.parameters.get("id"))
        if key is None:
            return self._set(target, ask)
        answer = self._once.first(key, ask.answer)
        if answer is None:
            return None
        try:
            outcome = self._set(target, ask._replace(answer=answer))
        except Exception as error:
            outcome = failed(error)
        if outcome is not None:
            answer(outcome)
        return None

    @property
    def is_polled(self) -> bool:
        """Return whether something that is listened to is to be read anew from time to time."""
        listeners = self.listeners
        is_heard = listeners.is_any and bool(listeners.of_names or listeners.computed())
        return is_heard or bool(self.remembered)

    def poll(self) -> None:
        """Read anew what is computed and listened to."""
        self.listeners.poll()
        if self.on_names is not None and self.listeners.of_names and not self._is_looking:
            self._is_looking = True
            self.user_code.later(NAMES, self._look, lambda answer: None, 0.0)

    def _look(self) -> None:
        with suppress(PropertyError):  # who asks for the names is told
            self.names_now()
        self._is_looking = False

    def names_now(self) -> None:
        """Update the names to those that there are now.

        Raises:
            PropertyError: ``internal``: user code that lists them failed.
        """
        if self.on_names is not None:
            self.on_names()

    def tick(self) -> None:
        """End the leases that are over."""
        self.listeners.tick()

    def forget(self, caller: Requester) -> None:
        """Send nothing any more to who is gone."""
        self.listeners.end_caller(caller)

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

    def find(self, name: str) -> NameEntry:
        """Return what a name stands for, looking once more when there is no such name.

        Raises:
            PropertyError: ``unknown``.
        """
        try:
            return self.registry.find(name)
        except PropertyError as error:
            if self.on_names is None or error.code != "unknown":
                raise
        self.names_now()
        return self.registry.find(name)

    # GET

    def _get(self, target: RequestTarget, ask: PropertyRequest) -> Payload:
        place = self.find(target.name)
        if place.extension:
            return get_extension(self, place, _read_all(target.parameters), ask.caller)
        node = place.node
        if node is None:
            checked_parameters((), target, OF_GET)
            self.names_now()
            return self.registry.listed(place.name)
        if node.function is not None:
            checked_parameters((), target, OF_GET)
            return described(node.function, place)
        given = checked_parameters(node.spec.parameters, target, OF_GET)
        given.pop("timeout", None)
        if "r" not in node.spec.access:
            raise PropertyError("write-only", f"cannot be read: {target.name}")
        if node.reader is None and not place.path:
            return node.payload
        value = self.value_of(node, given)
        if not place.path:
            return to_payload(node.spec.type, value)
        part = components.get(_divisible(value, place), place.path, node.spec.labels)
        if part is None:
            raise PropertyError("unknown", f"no such property: {target.name}")
        return write(part)

    def value_of(self, node: PropertyNode, parameters: dict[str, Value] = _NONE) -> Content:
        """Return the present value of a property, read anew where it is computed.

        Raises:
            PropertyError: ``write-only``, ``internal``, ``bad-value``.
        """
        if node.reader is None:
            if node.value is None:
                raise PropertyError("write-only", f"cannot be read: {node.name}")
            return node.value
        reader = node.reader
        value: Content = result_of(self.user_code.call(lambda: reader(parameters)))
        if not parameters:
            self.seen(node, value)
        return value

    def seen(self, node: PropertyNode, value: Content) -> None:
        """Record a computed value: if it has changed, notify its listeners."""
        if node.value is None:
            node.put(value, self.wall())
            node.revision = 1
        elif node.put(value, self.wall()) and node.listeners:
            self.listeners.changed(node, True)

    # SET

    def _set(self, target: RequestTarget, ask: PropertyRequest) -> Answer | None:
        assert ask.payload is not None
        place = self.find(target.name)
        if place.extension:
            set_extension(self, place, _read_all(target.parameters), ask)
            return DONE
        node = place.node
        if node is None:
            raise PropertyError("read-only", f"cannot be set: {target.name}")
        if node.function is not None:
            return start(self, node, place, target, ask)
        given = checked_parameters(node.spec.parameters, target, COMMON)
        has_echo = given.pop("echo", False) not in (False, 0)
        given.pop("timeout", None)
        given.pop("id", None)
        self.check_writable(node, target.name, given.pop("if", None))
        if place.path:
            value = self._with_part(node, place, ask.payload)
        else:
            value = node.spec.within(from_payload(node.spec.type, ask.payload))
        self.apply(node, value, given)
        return Answer(self._get(RequestTarget(target.name, {}), ask)) if has_echo else DONE

    def check_writable(self, node: PropertyNode, name: str, revision: Value | None = None) -> None:
        """Refuse to set what cannot be, or is no longer what the caller thinks it is.

        Raises:
            PropertyError: ``read-only``, ``conflict``.
        """
        if "w" not in node.spec.access:
            raise PropertyError("read-only", f"cannot be set: {name}")
        if revision is None:
            return
        if node.reader is not None:
            self.value_of(node)
        if revision != node.revision:
            raise PropertyError("conflict", f"revision of {name} is {node.revision}")

    def apply(
        self, node: PropertyNode, value: Content, parameters: dict[str, Value] = _NONE
    ) -> None:
        """Put a checked value in force, and notify its listeners.

        Raises:
            PropertyError: What the writer raised; the old value is in force.
        """
        if node.writer is not None:
            to_payload(node.spec.type, value)
            writer = node.writer
            outcome = self.user_code.call(lambda: writer(value, parameters))
            changed = result_of(outcome, (ValueError, TypeError))
            value = value if changed is None else changed
        if "r" not in node.spec.access:
            return
        if node.reader is not None:
            try:
                value = self.value_of(node)
            except Unfolded:
                return
        self._keep(node, value)

    def _keep(self, node: PropertyNode, value: Content) -> None:
        has_changed = node.put(value, self.wall())
        if node.listeners:
            self.listeners.changed(node, has_changed)

    def _with_part(self, node: PropertyNode, place: NameEntry, payload: Payload) -> Content:
        whole = _divisible(self.value_of(node), place)
        before = components.get(whole, place.path, node.spec.labels)
        if before is None:
            raise PropertyError("unknown", f"no such property: {place.name}.{'.'.join(place.path)}")
        kind = parse_type("number" if is_number(before) else "any")
        part = from_payload(kind, payload)
        assert not isinstance(part, bytes)
        return node.spec.admit(components.replace(whole, place.path, part, node.spec.labels))


def _read_kept(node: PropertyNode) -> Answer:
    try:
        return Answer(node.payload)
    except PropertyError as error:
        return Answer(str(error), error.code)


def _divisible(value: Content, place: NameEntry) -> Value:
    if isinstance(value, bytes):
        raise PropertyError("unknown", f"no such property: {place.name}.{place.path[0]}")
    return value


def _read_all(parameters: dict[str, str | None]) -> dict[str, Value]:
    return {key: True if text is None else read(text) for key, text in parameters.items()}
