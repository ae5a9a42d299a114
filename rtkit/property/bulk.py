"""Several properties at once: names below a place, their values and meta, and SET of all or none.

Source: `property-service` reference, section 2, ``.properties``.
"""

from __future__ import annotations

from collections.abc import Callable
from fnmatch import fnmatchcase

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.live_values import LiveValues, part
from rtkit.property.messages import Payload
from rtkit.property.meta import meta
from rtkit.property.naming import canonical
from rtkit.property.node import PropertyNode
from rtkit.property.parameters import flag, nothing_else, number
from rtkit.property.reading import read
from rtkit.property.registry import NameEntry, as_value
from rtkit.property.requests import Requester
from rtkit.property.types import Content, check
from rtkit.property.values import Element, Value
from rtkit.property.writing import as_item, write

Permit = Callable[[Requester, str, str], None]
"""Refuses a request of a caller, by method and name, that the rules of an endpoint deny."""

_Change = tuple[PropertyNode, Content, Content | None]
"""Property, the value that is wanted, and the one before, None of what cannot be read."""


class Bulk:
    """Requests about several properties of one service.

    Args:
        values: Of its properties.
        permit: Each property is looked at by itself.
        get: Answers a GET of the owner, whatever the name stands for.
    """

    def __init__(self, values: LiveValues, permit: Permit, get: Callable[[str], Payload]) -> None:
        self._values = values
        self._registry = values.registry
        self._permit = permit
        self._get = get

    def get(self, place: NameEntry, parameters: dict[str, Value], caller: Requester) -> Payload:
        """Return the names below a place, with values or meta if these are asked for.

        Raises:
            PropertyError: ``bad-parameter``, ``bad-value``, ``unknown``, ``denied``.
        """
        if not parameters:
            if place.path or place.node is not None:
                below = [] if place.path else self._registry.children(place.name)
                has_both = not below or (place.node is not None and place.node.returning)
                parts = self._parts(place) if has_both else []
                return write(tuple(map(as_value, [*parts, *below])))
            return self._registry.listed(place.name)
        given = dict(parameters)
        depth: int | None = int(number(given, "depth", 1))
        if flag(given, "all"):
            depth = None
        selected = given.pop("names", None)
        pattern = given.pop("match", None)
        has_values, has_meta = flag(given, "values"), flag(given, "meta")
        nothing_else(given, "properties")
        prefix = f"{place.name}." if place.name else ""
        if selected is not None:
            known = self._registry.nodes
            asked = [str(each) for each in _group(selected)]
            names = [each if prefix + each in known else canonical(each) for each in asked]
        else:
            names = [each[len(prefix) :] for each in self._registry.below(place.name, depth)]
        if pattern is not None:
            names = [each for each in names if fnmatchcase(each, str(pattern))]
        if has_meta:
            return write(tuple(self._described(prefix, each, caller) for each in names))
        if has_values:
            return self._pairs(prefix, names, caller, is_strict=selected is not None)
        for each in names if selected is not None else ():
            self._values.find(prefix + each)
        return write(tuple(map(as_value, names)))

    def _described(self, prefix: str, name: str, caller: Requester) -> Value:
        """Return ``(name meta value)`` of a property, only the name of what is none."""
        node = self._registry.nodes.get(prefix + name)
        if node is None or not caller.may("GET", prefix + name):
            return (as_value(name),)
        described = meta(
            self._values, NameEntry(prefix + name, node), caller, calls_user_code=False
        )
        if node.calls_user_code and node.value is None:
            return (as_value(name), described)  # a list of names calls nothing, a GET of one does
        try:
            is_known = node.reader is not None and node.calls_user_code
            value = item(node.payload if is_known else self._get(prefix + name))
        except PropertyError as error:
            value = _error(error)
        return (as_value(name), described, value)

    def _parts(self, place: NameEntry) -> list[str]:
        node = place.node
        assert node is not None
        if node.function is not None:
            names = [each.name for each in node.function.describe().children]
            return ["state", "stop", *names] if not place.path else []
        value = self._values.value_of(node)
        if isinstance(value, bytes):
            return []
        if place.path:
            return components.names(part(place, value))
        return components.names(value, node.spec.labels)

    def _pairs(self, prefix: str, names: list[str], caller: Requester, *, is_strict: bool) -> str:
        """Return ``(name value)`` of each; names that were asked for must all have one."""
        texts: list[str] = []
        nodes = self._registry.nodes
        is_open = caller.access.lets_all_get and not prefix
        for name in names:
            # Decision 34: most are kept here, and have their text ready.
            if is_open and (known := nodes.get(name)) is not None and known.reader is None:
                pair = known.pair
                if pair:
                    texts.append(pair)
                    continue
            if is_strict:
                self._permit(caller, "GET", prefix + name)
            elif not caller.may("GET", prefix + name):
                continue
            text = self._text(prefix + name, is_strict=is_strict)
            if text is not None:
                texts.append(f"({as_item(name)} {text})")
        return f"({' '.join(texts)})"

    def _text(self, name: str, *, is_strict: bool) -> str | None:
        """Return the value of a property as an item of a list, None of what has none."""
        node = self._registry.nodes.get(name)
        if node is not None and node.reader is None and node.value is not None:
            payload = node.payload
            if node.spec.type.base != "text" and isinstance(payload, str):
                return payload
            return write(item(payload) if isinstance(payload, bytes) else payload)
        if node is None and not is_strict:
            return None
        try:
            payload = self._get(name)
        except PropertyError as error:
            if is_strict:
                raise
            return None if error.code == "write-only" else write(_error(error))
        if isinstance(payload, bytes):
            return write(item(payload))
        is_value = node is None or node.spec.type.base != "text"
        return payload if is_value else write(payload)

    def set(self, place: NameEntry, payload: str, caller: Requester) -> None:
        """Set several properties, all or none: each is checked before any is set.

        Raises:
            PropertyError: ``unknown``, ``bad-value``, ``denied``, ``read-only``; as a writer does.
        """
        prefix = f"{place.name}." if place.name else ""
        wanted: dict[str, _Change] = {}
        for pair in _group(read(payload)):
            name, value = _pair(pair)
            node = self._registry.find(prefix + name).node
            if node is None or node.name != prefix + name:
                raise PropertyError("unknown", f"no such property: {prefix + name}")
            if node.name in wanted:
                raise PropertyError("bad-value", f"given twice: {node.name}")
            if node.function is not None:
                raise PropertyError("bad-value", f"an action cannot be taken back: {node.name}")
            self._permit(caller, "SET", node.name)
            self._values.check_writable(node, node.name)
            # Read before it is checked: a first value may tell of which type all others are.
            old = self._values.value_of(node) if "r" in node.spec.access else None
            try:
                wanted[node.name] = (node, node.spec.admit(check(node.spec.type, value)), old)
            except PropertyError as error:
                raise PropertyError(error.code, f"{node.name}: {error}") from None
        self._apply_all(wanted)

    def _apply_all(self, wanted: dict[str, _Change]) -> None:
        before: list[tuple[PropertyNode, Content]] = []
        for node, value, old in wanted.values():
            try:
                self._values.apply(node, value)
            except PropertyError as error:
                for earlier, known in reversed(before):
                    self._values.apply(earlier, known)
                raise PropertyError(error.code, f"{node.name}: {error}") from error
            if old is not None:
                before.append((node, old))


def item(payload: Payload) -> Value:
    """Return a payload as an item of a list; of bytes only their number."""
    if isinstance(payload, bytes):
        return Element("bytes", {"length": str(len(payload))})
    try:
        return read(payload)
    except PropertyError:
        return payload


def _error(error: PropertyError) -> Element:
    return Element("error", {"code": error.code}, (), str(error))


def _pair(pair: Value) -> tuple[str, Value]:
    if isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], str):
        return canonical(str(pair[0])), pair[1]
    raise PropertyError("bad-value", "expected a list of (name value)")


def _group(value: Value) -> tuple[Value, ...]:
    if not isinstance(value, tuple):
        raise PropertyError("bad-value", "expected a list")
    return value
