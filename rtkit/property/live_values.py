"""Live values of a service: read anew or kept, put in force, changes sent to who listens.

Callers have checked access before. Readers, writers and what lists names are code of
users: while one runs, others may be inside (see `rtkit.property.user_code`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.listeners import Listeners
from rtkit.property.messages import Payload
from rtkit.property.names import NameSource
from rtkit.property.node import PropertyNode
from rtkit.property.presenting import EMPTY, Gui
from rtkit.property.property_spec import EMPTY_PLACE, PropertySpec
from rtkit.property.registry import NameEntry, Registry
from rtkit.property.types import Content, from_payload, parse_type, to_payload
from rtkit.property.user_code import AT_ONCE, Unfolded, UserCode, result_of
from rtkit.property.values import Value, is_number
from rtkit.property.writing import write

_NONE: dict[str, Value] = {}


class LiveValues:
    """Values of the properties of one service.

    Attributes:
        registry: Their names.
        standard: Properties that are answered, and not listed, where there are no others so named.
        clock: Returns monotonic time [s].
        wall: Returns the time of day [s since 1970].
        user_code: Calls what is not ours.
        widgets: Returns the widget of a name that tells its own, by name.
        on_names: Called before names are told or missed, to have those that there are now.
        on_new: Returns a property for a name that is set and not there, None if it may not be made.
        may_differ: Returns whether names may be others than those that were told last.
    """

    def __init__(self, clock: Callable[[], float], wall: Callable[[], float]) -> None:
        self.clock = clock
        self.wall = wall
        self.registry = Registry()
        self.standard = Registry()
        self.listeners = Listeners(self.registry, clock, wall, self.standard)
        self.user_code: UserCode = AT_ONCE
        self.widgets: dict[str, Callable[[], Gui]] = {}
        self.on_names: Callable[[], object] | None = None
        self.on_new: Callable[[str], PropertyNode | None] | None = None
        self.may_differ: Callable[[], bool] = lambda: True

    def names_now(self) -> None:
        """Update the names to those that there are now.

        Raises:
            PropertyError: ``internal``: user code that lists them failed.
        """
        if self.on_names is not None:
            self.on_names()

    def find(self, name: str) -> NameEntry:
        """Return what a name stands for, looking once more when there is no such name.

        Raises:
            PropertyError: ``unknown``.
        """
        try:
            place = self.registry.find(name)
            if not place.path or place.node is None or place.node.source is None:
                return place  # else it may be a name of its own that has come below that one
        except PropertyError as error:
            if error.code != "unknown":
                raise
        if self.on_names is not None:
            self.names_now()
        try:
            return self.registry.find(name)
        except PropertyError:
            standard = self.standard.part_of([*name.split("."), ""])
            if standard is None:
                raise
        return self.standard.find(name)

    def find_to_set(self, name: str) -> NameEntry:
        """Return what a name stands for that is to be set: perhaps one that is to be made.

        Raises:
            PropertyError: ``unknown``; ``conflict``: a part of it is reserved.
        """
        unknown: PropertyError | None = None
        place = NameEntry(name, None)
        try:
            place = self.find(name)
        except PropertyError as error:
            if error.code != "unknown":
                raise
            unknown = error
        node = place.node
        has_parts = node is not None and node.source is None and node.spec is not EMPTY_PLACE
        is_known = node is not None and (not place.path or has_parts)
        is_new = not (place.extension or is_known or name.endswith(".listen"))
        made = self.on_new(name) if is_new and self.on_new else None
        if made is None and unknown is not None:
            raise unknown
        return place if made is None else NameEntry(name, made)

    # reading

    def spec_of(self, node: PropertyNode | None, name: str) -> PropertySpec:
        """Return what is declared of a property, or of a place, with what changes at run time.

        Raises:
            PropertyError: ``internal``: code that tells it failed.
        """
        spec = EMPTY if node is None else node.spec
        if node is not None and node.choices is not None:
            spec = replace(spec, choices=result_of(self.user_code.call(node.choices)))
        if name in self.widgets:
            gui = result_of(self.user_code.call(self.widgets[name]))
            spec = replace(spec, **gui.declared())
        return spec

    def value_of(
        self, node: PropertyNode, parameters: dict[str, Value] = _NONE, *, is_kept: bool = False
    ) -> Content:
        """Return the present value of a property, read anew where it is computed.

        Args:
            node: The property.
            parameters: Of the request.
            is_kept: Somebody is to listen to it.

        Raises:
            PropertyError: ``write-only``, ``internal``, ``bad-value``.
        """
        reader = node.reader
        if reader is None:
            if node.value is None:
                raise PropertyError("write-only", f"cannot be read: {node.name}")
            return node.value
        if node.source is not None:
            self.look(node)
        value: Content = result_of(self.user_code.call(lambda: reader(parameters)))
        if not parameters and (node.source is None or is_kept or node.listeners):
            self._seen(node, value)
            if node.source is not None:
                node.source.sent()
        return value

    def look(self, node: PropertyNode) -> bool:
        """Return whether a value may differ from when it was looked at last; calls its owner.

        Raises:
            PropertyError: ``unknown``, ``internal``: as the owner raised.
        """
        source = node.source
        if source is None:
            return True
        stamp = result_of(self.user_code.call(source.stamp))
        growth = source.settle(stamp)
        if growth is not None:
            node.revision += growth
            node.time = self.wall()
        return not source.is_sent

    def payload_of(self, place: NameEntry, parameters: dict[str, Value]) -> Payload:
        """Return the present value of a property, or of a part of it, as replies carry it.

        Raises:
            PropertyError: As `value_of`; ``unknown``: there is no such part.
        """
        node = place.node
        assert node is not None
        if "r" not in node.spec.access:
            raise PropertyError("write-only", f"cannot be read: {place.full_name}")
        if node.reader is None and not place.path:
            return node.payload
        value = self.value_of(node, parameters)
        return to_payload(node.spec.type, value) if not place.path else write(part(place, value))

    def _seen(self, node: PropertyNode, value: Content) -> None:
        """Record a computed value: if it has changed, notify its listeners."""
        if node.value is None:
            revision = node.revision if node.source else 1
            node.put(value, self.wall())
            node.revision = revision
        elif node.put(value, self.wall()) and node.listeners:
            self.listeners.changed(node, True)

    # writing

    def check_writable(self, node: PropertyNode, name: str, revision: Value | None = None) -> None:
        """Refuse to set what cannot be, or is no longer what the caller thinks it is.

        Raises:
            PropertyError: ``read-only``, ``conflict``.
        """
        if "w" not in node.spec.access:
            raise PropertyError("read-only", f"cannot be set: {name}")
        if revision is None:
            return
        if node.source is not None:
            self.look(node)
        elif node.reader is not None:
            self.value_of(node)
        if revision != node.revision:
            raise PropertyError("conflict", f"revision of {name} is {node.revision}")

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
            self.keep(node, value)
        else:
            self.apply(node, value)

    def set_at(self, place: NameEntry, payload: Payload, parameters: dict[str, Value]) -> None:
        """Carry out a SET of a property, or of a part of it, that was found to be writable.

        Raises:
            PropertyError: ``bad-value``, ``unknown``; as `apply`.
        """
        node = place.node
        assert node is not None
        spec = node.spec
        if place.path:
            whole = self.value_of(node)
            kind = "number" if is_number(part(place, whole)) else "any"
            given = from_payload(parse_type(kind), payload)
            assert not isinstance(whole, bytes)
            assert not isinstance(given, bytes)
            value = spec.admit(components.replace(whole, place.path, given, spec.labels))
        else:
            value = spec.within(from_payload(spec.type, payload))
        self.apply(node, value, parameters)

    def apply(
        self, node: PropertyNode, value: Content, parameters: dict[str, Value] = _NONE
    ) -> None:
        """Put a checked value in force, and notify its listeners.

        Raises:
            PropertyError: The writer raised it; the old value is in force.
        """
        writer, returning = node.writer, node.returning
        if returning is not None:
            returning.before_set()
        if writer is not None:
            if type(value) is not float:  # for that there is always a text
                to_payload(node.spec.type, value)
            outcome = self.user_code.call(lambda: writer(value, parameters))
            changed = result_of(outcome, (ValueError, TypeError))
            value = value if changed is None else changed
        if returning is not None:
            returning.was_set()
        if node.source is not None:
            self._apply_names(node.name, node.source)
            return
        if "r" not in node.spec.access:
            return
        if node.reader is not None:
            try:
                value = self.value_of(node)
            except Unfolded:
                return
        self.keep(node, value)

    def _apply_names(self, name: str, source: NameSource) -> None:
        """Tell what came of a value that its owner was given: the name may have come or gone."""
        if result_of(self.user_code.call(source.has_other_names)):
            self.names_now()
        node = self.registry.nodes.get(name)
        if node is None or "r" not in node.spec.access:
            return
        if node.listeners:
            self.keep(node, self.value_of(node))
        else:
            self.look(node)

    def keep(self, node: PropertyNode, value: Content, quality: str = "good") -> None:
        """Keep a value that is in force, and notify its listeners."""
        has_changed = node.put(value, self.wall(), quality)
        if node.listeners:
            self.listeners.changed(node, has_changed)


def part(place: NameEntry, whole: Content | None) -> Value:
    """Return the part of a value that a name stands for.

    Raises:
        PropertyError: ``unknown``: there is no such part.
    """
    assert place.node is not None
    found = None
    if whole is not None and not isinstance(whole, bytes):
        found = components.get(whole, place.path, place.node.spec.labels)
    if found is None:
        raise PropertyError("unknown", f"no such property: {place.full_name}")
    return found
