"""Publishes values of a service as retained messages, with their meta data as ``$``-attributes.

In the style of Homie: ``$name``, ``$properties`` of the service; ``$datatype``, ``$unit``,
``$format``, ``$settable`` of a property. What is removed is taken off the broker too.
"""

from __future__ import annotations

import threading
from collections.abc import Callable

from rtkit.property.codes import PASSING
from rtkit.property.line import write_named
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.naming import canonical
from rtkit.property.reading import read
from rtkit.property.requests import ListeningRequester, PropertyRequest, Requester
from rtkit.property.values import Element, Value
from rtkit.property.writing import write
from rtkit.serving.event_loop import IOHandler, PropertyEventLoop
from rtkit.serving.provider import PropertyProvider
from rtkit.wires.mqtt.session import Message, topic_of

MOST_PROPERTIES = 20_000
_AGAIN_S = 1.0
"""After which time it is begun anew while the owner is away [s]."""
_OF_ONE = 1000
_TYPES = {"number": "float", "integer": "integer", "boolean": "boolean"}


class Feed:
    """Keeps the retained messages of a broker equal to the values of the service.

    Args:
        root: The topic of the service.
        has_room: Whether another message can be published now.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        service: PropertyProvider,
        root: str,
        publish: Callable[[Message], None],
        has_room: Callable[[], bool],
    ) -> None:
        self._host = host
        self._service = service
        self._root = root
        self._publish = publish
        self._has_room = has_room
        self._listened: set[str] = set()
        self._attributes: dict[str, dict[str, str]] = {}
        self._subscriptions: list[_Subscriber] = []
        self._is_due_for: list[_Subscriber] | None = None
        self._ready: Callable[[], None] = lambda: None
        self._is_listing = False
        self._is_stale = False

    def begin(self, ready: Callable[[], None]) -> None:
        """Publish everything, then say so, then go on."""
        self.end()
        self._attributes = {name: {} for name in self._attributes}
        self._listened.clear()
        self._ready = ready
        names = _Subscriber(self._host, self.emit, lambda _: self._names_changed())
        self._subscriptions.append(names)
        ask = PropertyRequest("properties.listen?mode=diff&queue=100", "self", self._begun, names)
        self._service.handle(ask)

    def end(self) -> None:
        """Publish nothing any more."""
        subscriptions, self._subscriptions = self._subscriptions, []
        for subscription in subscriptions:
            self._service.forget(subscription)

    def resume(self) -> None:
        """Go on publishing."""
        for subscription in self._subscriptions:
            subscription.wake()

    def emit(self, subscription: _Subscriber, now: float) -> float | None:
        """Publish the events of a listener, as far as the session takes them."""
        emit = subscription.on_event or self._emit
        return subscription.send_due(now, self._has_room, lambda _, event: emit(event))

    def _emit(self, event: PropertyEvent) -> None:
        if event.code:
            self._listened.discard(event.name)
            self._put(topic_of(event.name), "")
        else:
            more = (("event", write_named(event)),)
            topic = f"{self._root}/{topic_of(event.name)}"
            self._publish(Message(topic, event.payload, more=more, is_kept=True))

    # Its own

    def _begun(self, answer: Answer) -> None:
        if not answer.error:
            return  # the names that there are come as an event
        if answer.error not in PASSING:
            self._names_changed()  # they cannot be listened to
            return
        self._later(lambda: self.begin(self._ready))

    def _later(self, work: Callable[[], object]) -> None:
        """Do something after a while, if this has not been ended or begun anew by then."""
        if self._is_due_for is self._subscriptions:
            return
        subscriptions = self._is_due_for = self._subscriptions

        def run() -> None:
            if subscriptions is self._subscriptions and subscriptions:
                self._is_due_for = None
                work()

        again = threading.Timer(_AGAIN_S, self._host.post, (run,))
        again.daemon = True
        again.start()

    def _names_changed(self) -> None:
        self._is_stale = True
        if not self._is_listing:
            self._is_listing, self._is_stale = True, False
            ask = PropertyRequest("properties?all&meta", None, self._listed, Requester("mqtt"))
            self._service.handle(ask)

    def _listed(self, answer: Answer) -> None:
        self._is_listing = False
        if self._is_stale:
            self._names_changed()
            return
        if not self._subscriptions:
            return
        if answer.error:
            # The owner is away. Its names are sent when it is back, but it may never have gone.
            self._later(self._names_changed)
            return
        described = _described(str(answer.payload))
        for name in [name for name in self._attributes if name not in described]:
            self._listened.discard(name)
            self._put(topic_of(name), "")
            for key in self._attributes.pop(name):
                self._put(f"{topic_of(name)}/{key}", "")
        for name, meta in described.items():
            self._describe(name, meta)
        self._put("$name", self._service.name)
        self._put("$properties", ",".join(described))
        for name in described:
            if name not in self._listened:
                self._listen(name)
        self._ready()

    def _describe(self, name: str, meta: Element) -> None:
        attributes = attributes_of(name, meta)
        if self._attributes.get(name) != attributes:
            self._attributes[name] = attributes
            for key, text in attributes.items():
                self._put(f"{topic_of(name)}/{key}", text)

    def _put(self, topic: str, text: str) -> None:
        self._publish(Message(f"{self._root}/{topic}", text, is_kept=True))

    def _listen(self, name: str) -> None:
        subscription = self._subscriptions[-1]
        if subscription.on_event is not None or subscription.count >= _OF_ONE:
            subscription = _Subscriber(self._host, self.emit)
            self._subscriptions.append(subscription)
        subscription.count += 1
        self._listened.add(name)

        def begun(answer: Answer) -> None:
            if answer.error in PASSING:
                subscription.count -= 1
                self._listened.discard(name)
                self._later(self._names_changed)

        self._service.handle(PropertyRequest(f"{name}.listen", "self", begun, subscription))


class _Subscriber(IOHandler, ListeningRequester):
    """Listener of properties, or of their names, for the broker.

    Attributes:
        on_event: Called with each event instead of publishing it.
        count: How many it was asked to listen to.
    """

    def __init__(
        self,
        host: PropertyEventLoop,
        emit: Callable[[_Subscriber, float], float | None],
        on_event: Callable[[PropertyEvent], None] | None = None,
    ) -> None:
        super().__init__("mqtt")
        self._host = host
        self._emit = emit
        self.on_event = on_event
        self.count = 0

    def flush(self, now: float) -> float | None:
        """See `IOHandler.flush`."""
        return self._emit(self, now)


def _described(listing: str) -> dict[str, Element]:
    """Return the attributes of properties, by name; inner names have none."""
    listed = read(listing)
    rows = listed if isinstance(listed, tuple) else ()
    found: dict[str, Element] = {}
    for row in rows[:MOST_PROPERTIES]:
        if isinstance(row, tuple) and len(row) > 1 and isinstance(row[1], Element):
            found[canonical(str(row[0]))] = row[1]
    return found


def attributes_of(name: str, meta: Element) -> dict[str, str]:
    """Return the attributes of a property, by name."""
    found = {each.name: each.leaf for each in meta.children}
    kind, choices = str(found.get("type", "any")), found.get("choices")
    attributes = {
        "$name": name,
        "$datatype": "enum" if choices is not None else _TYPES.get(kind, "string"),
        "$settable": str("w" in str(found.get("access", ""))).lower(),
    }
    if found.get("unit") is not None:
        attributes["$unit"] = str(found["unit"])
    if isinstance(choices, tuple):
        attributes["$format"] = ",".join(map(_plain, choices))
    elif found.get("min") is not None and found.get("max") is not None:
        attributes["$format"] = f"{_plain(found['min'])}:{_plain(found['max'])}"
    return attributes


def _plain(value: Value | None) -> str:
    return value if isinstance(value, str) else write(value or 0)
