"""Listeners of a service: registers them, sends them changes, ends their leases."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.messages import PropertyEvent
from rtkit.property.node import PropertyNode
from rtkit.property.registry import NameEntry, Registry, as_value
from rtkit.property.requests import Requester
from rtkit.property.subscription import Listener, SubscriptionOptions
from rtkit.property.types import Content
from rtkit.property.values import Value, Word
from rtkit.property.writing import write

MOST_OF_CALLER = 1024


class Listeners:
    """All listeners of one service.

    Attributes:
        of_names: Those who listen to which names there are, by place.
        pushed: Names of properties whose owner tells each change: they are not polled.
    """

    def __init__(
        self,
        registry: Registry,
        clock: Callable[[], float],
        wall: Callable[[], float],
        standard: Registry,
    ) -> None:
        self._registry = registry
        self._standard = standard
        self._clock = clock
        self._wall = wall
        self._all: dict[tuple[Requester, str, tuple[str, ...]], Listener] = {}
        self.of_names: dict[str, list[Listener]] = {}
        self.pushed: set[str] = set()
        self._revision_of_names = 1
        self._together: tuple[list[str], list[str]] | None = None

    @property
    def is_any(self) -> bool:
        """Return whether anybody listens to anything."""
        return bool(self._all)

    def register(
        self,
        place: NameEntry,
        options: SubscriptionOptions,
        caller: Requester,
        read: Callable[[PropertyNode], object],
    ) -> Listener:
        """Register a caller as listener; one that listens already gets the new options and lease.

        Args:
            place: Place that is listened to.
            options: How.
            caller: Whoever listens.
            read: Has a property hold its present value, where the first event is to carry it.

        Raises:
            PropertyError: ``denied``: it listens to too much, or cannot; as GET of the value.
        """
        key = _key(place, caller)
        known = self._all.get(key)
        if known is not None and known.options == options:
            known.renew(self._clock())
            return known
        if sum(1 for each in self._all if each[0] is caller) >= MOST_OF_CALLER:
            raise PropertyError("denied", f"more than {MOST_OF_CALLER} listeners")
        listener = Listener(place.full_name, place.path, options, caller)
        listener.renew(self._clock())
        first, value = self._first(place, listener, read)
        if known is not None:
            self.end(known)
        caller.listen(listener)
        self._all[key] = listener
        if _is_of_names(place):
            listener.name = f"{place.name}.properties".lstrip(".")
            self.of_names.setdefault(place.name, []).append(listener)
        else:
            assert place.node is not None
            place.node.listeners = [*(place.node.listeners or ()), listener]
        if listener.offer(first._replace(name=listener.name), value, is_first=True):
            caller.wake()
        return listener

    def _first(
        self, place: NameEntry, listener: Listener, read: Callable[[PropertyNode], object]
    ) -> tuple[PropertyEvent, object]:
        if _is_of_names(place):
            return self._names_event(place.name), None
        node = place.node
        assert node is not None
        if "r" not in node.spec.access:
            raise PropertyError("write-only", f"cannot be read: {listener.name}")
        if node.function is None:
            if listener.options.has_initial or node.value is None:
                read(node)
        elif node.value is None:
            node.put(node.function.describe(), self._wall())
        made = _event(node, listener)
        if made is None:
            raise PropertyError("unknown", f"no such property: {listener.name}")
        return made

    def _names_event(self, name: str) -> PropertyEvent:
        text = self._registry.listed(name)
        return PropertyEvent("", text, self._wall(), self._revision_of_names)

    def changed(self, node: PropertyNode, has_changed: bool) -> None:
        """Notify the listeners of a property that it was set."""
        whole = None
        for listener in node.listeners or ():
            if not has_changed and not listener.options.is_all:
                continue
            if whole is None or whole[0].name != listener.name or listener.path:
                made = _event(node, listener)
                whole = whole if listener.path else made
            else:
                made = whole  # the same object, which a wire need write only once
            if made is not None and listener.offer(*made):
                listener.caller.wake()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Have all names that change meanwhile be one event."""
        changes = self._together = ([], [])
        try:
            yield
        finally:
            self._together = None
            if any(changes):
                self._names_differ(*changes)

    def names_changed(self, added: str = "", removed: str = "") -> None:
        """Notify the listeners of listings that a name has come or gone."""
        changes = self._together or ([], [])
        changes[0].extend([added] * bool(added))
        changes[1].extend([removed] * bool(removed))
        if self._together is None:
            self._names_differ(*changes)

    def _names_differ(self, *changes: list[str]) -> None:
        self._revision_of_names += 1
        for place, listeners in self.of_names.items():
            prefix = f"{place}." if place else ""
            added, removed = ([n for n in names if n.startswith(prefix)] for names in changes)
            if not added and not removed:
                continue
            event = self._names_event(place)
            difference = (
                (Word("added"), *map(as_value, added)),
                (Word("removed"), *map(as_value, removed)),
            )
            for listener in listeners:
                payload = write(difference) if listener.options.is_difference else event.payload
                made = event._replace(name=listener.name, payload=payload)
                if listener.offer(made, None):
                    listener.caller.wake()

    def end_all(self, node: PropertyNode) -> None:
        """Send the listeners of a property the last event: it is gone."""
        for listener in node.listeners or ():
            last = PropertyEvent(
                listener.name, "", self._wall(), node.revision, "bad", 0, "unknown"
            )
            listener.offer(last, None)
            listener.has_ended = True
            self._forget(listener)
            listener.caller.wake()
        node.listeners = None

    def end(self, listener: Listener) -> None:
        """End a listener: it receives nothing more."""
        self._forget(listener)
        listener.has_ended = True
        name = _property_of(listener)
        node = self._registry.nodes.get(name) or self._standard.nodes.get(name)
        if node is not None and node.listeners:
            node.listeners = [each for each in node.listeners if each is not listener] or None
        for place, listeners in list(self.of_names.items()):
            listeners[:] = [each for each in listeners if each is not listener]
            if not listeners:
                del self.of_names[place]
        listener.caller.unlisten(listener)

    def _forget(self, listener: Listener) -> None:
        for key in [key for key, each in self._all.items() if each is listener]:
            del self._all[key]

    def end_caller(self, caller: Requester) -> None:
        """Forget whoever is gone."""
        for listener in [each for key, each in self._all.items() if key[0] is caller]:
            self.end(listener)

    def remove(self, place: NameEntry, caller: Requester) -> None:
        """Take off a listener of a caller.

        Raises:
            PropertyError: ``unknown``: it does not listen to that.
        """
        key = _key(place, caller)
        if key not in self._all:
            raise PropertyError("unknown", f"not listened to: {place.name}")
        self.end(self._all[key])

    def of(self, node: PropertyNode | None) -> list[Value]:
        """Return who listens to a property."""
        found = node.listeners if node is not None and node.listeners else ()
        return [each.caller.identity or "nobody" for each in found]

    def tick(self) -> float | None:
        """End the leases that are over; return when the next one is, None if none will be."""
        now = self._clock()
        for listener in [each for each in self._all.values() if each.ends_at is not None]:
            if listener.ends_at is not None and listener.ends_at <= now:
                self.end(listener)
        ends = [each.ends_at for each in self._all.values() if each.ends_at is not None]
        return min(ends, default=None)

    def computed(self) -> list[PropertyNode]:
        """Return the properties that are listened to and change without our doing."""
        nodes = self._registry.nodes
        found = {_property_of(each): each for each in self._all.values()}
        names = [name for name in found if name in nodes and name not in self.pushed]
        return [nodes[name] for name in names if nodes[name].reader is not None]


def _is_of_names(place: NameEntry) -> bool:
    return place.field == "properties" or place.node is None


def _key(place: NameEntry, caller: Requester) -> tuple[Requester, str, tuple[str, ...]]:
    return (caller, f"{place.name}?" if _is_of_names(place) else place.name, place.path)


def _property_of(listener: Listener) -> str:
    if not listener.path:
        return listener.name
    return listener.name[: -len(".".join(listener.path)) - 1]


def _event(node: PropertyNode, listener: Listener) -> tuple[PropertyEvent, Content | None] | None:
    """Return the event for a listener of a property, or of a part of it."""
    value, payload = node.value, node.payload
    if listener.path:
        whole = value if value is not None and not isinstance(value, bytes) else ""
        part = components.get(whole, listener.path, node.spec.labels)
        if part is None:
            return None
        value, payload = part, write(part)
    return PropertyEvent(listener.name, payload, node.time, node.revision, node.quality), value
