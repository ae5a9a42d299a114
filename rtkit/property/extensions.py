"""Extensions of a property: names below it, parameters, GUI, listeners, meta, history.

Source: `property-service` reference, section 2.
"""

from __future__ import annotations

from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from rtkit.property import components
from rtkit.property.codes import PropertyError
from rtkit.property.messages import Payload
from rtkit.property.meta import meta, meta_field
from rtkit.property.naming import canonical
from rtkit.property.reading import read
from rtkit.property.registry import NameEntry, as_value
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.spec import gui
from rtkit.property.subscription import options_of
from rtkit.property.types import Content, check, from_payload, parse_type
from rtkit.property.values import Element, Value, Word, is_number
from rtkit.property.writing import as_item, write

if TYPE_CHECKING:
    from rtkit.property.node import PropertyNode
    from rtkit.property.service import Service


def get_extension(
    service: Service, place: NameEntry, parameters: dict[str, Value], caller: Requester
) -> Payload:
    """Answer a GET of an extension.

    Raises:
        PropertyError: ``bad-parameter``, ``unknown``, ``denied``.
    """
    parameters.pop("timeout", None)
    _check_part(service, place)
    if place.extension == "properties":
        service.names_now()
        return _names(service, place, parameters, caller)
    if place.extension == "history":
        return _history(place, parameters)
    _nothing_else(parameters, place.extension)
    if place.node is None:
        raise PropertyError("unknown", f"no such property: {place.name}.{place.extension}")
    if place.extension == "meta":
        described = meta(service, place.node, caller, place.path)
        return meta_field(described, place) if place.field else write(described)
    if place.extension == "parameters":
        declared = place.node.function or place.node.spec
        return write(tuple(each.described() for each in declared.parameters))
    if place.extension == "gui":
        return _gui(place.node, place.field)
    service.permit(caller, "SET", place.name)
    return write(tuple(service.listeners.of(place.node)))


def _check_part(service: Service, place: NameEntry) -> None:
    """Refuse requests about a part that a property does not have.

    Raises:
        PropertyError: ``unknown``.
    """
    if not place.path or place.node is None:
        return
    function = place.node.function
    if function is not None:
        if place.path in (("state",), ("stop",)):
            return
        value: Content = function.describe()
    else:
        value = service.value_of(place.node)
    labels = place.node.spec.labels
    if isinstance(value, bytes) or components.get(value, place.path, labels) is None:
        name = ".".join((place.name, *place.path))
        raise PropertyError("unknown", f"no such property: {name}")


def _gui(node: PropertyNode, kind: str) -> Payload:
    if not kind:
        return write(gui(node.spec))
    if kind not in node.spec.gui:
        raise PropertyError("unknown", f"no such property: {node.name}.gui.{kind}")
    return node.spec.gui[kind]


def _history(place: NameEntry, parameters: dict[str, Value]) -> Payload:
    node = place.node
    if node is None or node.history is None:
        raise PropertyError("unknown", f"no such property: {place.name}.history")
    begin = _number(parameters, "from", float("-inf"))
    end = _number(parameters, "to", float("inf"))
    most = _number(parameters, "n", len(node.history))
    _nothing_else(parameters, "history")
    rows = [row for row in node.history if begin <= row[0] <= end]
    kept = rows[max(0, len(rows) - int(most)) :]
    return write(tuple((time, Word(quality), _item(payload)) for time, quality, payload in kept))


def _item(payload: Payload) -> Value:
    if isinstance(payload, bytes):
        return Element("bytes", {"length": str(len(payload))})
    try:
        return read(payload)
    except PropertyError:
        return payload


def _names(
    service: Service, place: NameEntry, parameters: dict[str, Value], caller: Requester
) -> Payload:
    if not parameters:
        if place.path or (place.node is not None and not service.registry.is_inner(place.name)):
            return write(tuple(map(as_value, _parts(service, place))))
        return service.registry.listed(place.name)
    given = dict(parameters)
    depth: int | None = int(_number(given, "depth", 1))
    if given.pop("all", False) not in (False, 0):
        depth = None
    selected = given.pop("names", None)
    pattern = given.pop("match", None)
    has_values = given.pop("values", False) not in (False, 0)
    has_meta = given.pop("meta", False) not in (False, 0)
    _nothing_else(given, "properties")
    prefix = f"{place.name}." if place.name else ""
    if selected is not None:
        known = service.registry.nodes
        asked = [str(each) for each in _group(selected)]
        names = [each if prefix + each in known else canonical(each) for each in asked]
    else:
        names = [each[len(prefix) :] for each in service.registry.below(place.name, depth)]
    if pattern is not None:
        names = [each for each in names if fnmatchcase(each, str(pattern))]
    if has_meta:
        return write(tuple(_told(service, prefix, each, caller) for each in names))
    if not has_values:
        for each in names if selected is not None else ():
            service.registry.find(prefix + each)
        return write(tuple(map(as_value, names)))
    return _pairs(service, prefix, names, caller, is_strict=selected is not None)


def _told(service: Service, prefix: str, name: str, caller: Requester) -> Value:
    """Return ``(name meta value)`` of a property, only the name of what is none."""
    node = service.registry.nodes.get(prefix + name)
    if node is None or not caller.may("GET", prefix + name):
        return (as_value(name),)
    described = meta(service, node, caller, calls_user_code=False)
    if node.calls_user_code and node.value is None:
        return (as_value(name), described)  # a list of names calls nothing, a GET of one does
    try:
        known = node.reader is not None and node.calls_user_code
        value = _item(node.payload if known else service.get(prefix + name))
    except PropertyError as error:
        return (as_value(name), described, Element("error", {"code": error.code}, (), str(error)))
    return (as_value(name), described, value)


def _parts(service: Service, place: NameEntry) -> list[str]:
    assert place.node is not None
    if place.node.function is not None:
        told = [each.name for each in place.node.function.describe().children]
        return ["state", "stop", *told] if not place.path else []
    value = service.value_of(place.node)
    if isinstance(value, bytes):
        return []
    part = components.get(value, place.path, place.node.spec.labels) if place.path else value
    return components.names(part, () if place.path else place.node.spec.labels)


def _pairs(
    service: Service, prefix: str, names: list[str], caller: Requester, *, is_strict: bool
) -> str:
    """Return ``(name value)`` of each; names that were asked for must all have one."""
    texts: list[str] = []
    nodes = service.registry.nodes
    is_open = caller.access.lets_all_get and not prefix
    for name in names:
        if is_open and (known := nodes.get(name)) is not None and known.reader is None:
            pair = known.pair
            if pair:
                texts.append(pair)
                continue
        if is_strict:
            service.permit(caller, "GET", prefix + name)
        elif not caller.may("GET", prefix + name):
            continue
        node = nodes.get(prefix + name if prefix else name)
        if node is not None and node.reader is None and node.value is not None:
            payload: Payload = node.payload
            base = node.spec.type.base
            text = (
                payload if base != "text" and isinstance(payload, str) else write(_opaque(payload))
            )
        elif node is None and not is_strict:
            continue
        else:
            try:
                payload = service.get(prefix + name)
                text = write(_item(payload)) if isinstance(payload, bytes) else payload
            except PropertyError as error:
                if is_strict:
                    raise
                if error.code == "write-only":
                    continue
                text = write(Element("error", {"code": error.code}, (), str(error)))
        texts.append(f"({as_item(name)} {text})")
    return f"({' '.join(texts)})"


def _opaque(payload: Payload) -> Value:
    return _item(payload) if isinstance(payload, bytes) else str(payload)


def set_extension(
    service: Service, place: NameEntry, parameters: dict[str, Value], ask: PropertyRequest
) -> None:
    """Carry out a SET of an extension.

    Raises:
        PropertyError: ``read-only``, ``bad-value``, ``denied`` …
    """
    payload = str(from_payload(parse_type("text"), ask.payload or ""))
    parameters.pop("timeout", None)
    if place.extension == "listen":
        _listen(service, place, payload, parameters, ask.caller)
    elif place.extension == "properties":
        _check_part(service, place)
        parameters.pop("id", None)
        _nothing_else(parameters, "properties")
        _set_all(service, place, payload, ask.caller)
    else:
        raise PropertyError("read-only", f"cannot be set: {place.name}.{place.extension}")


def _listen(
    service: Service, place: NameEntry, ref: str, parameters: dict[str, Value], caller: Requester
) -> None:
    if ref.strip() != "self":
        if service.notifies is None:
            raise PropertyError("denied", f"events go to self only, not to {ref[:80]}")
        service.permit(caller, "SET", place.name)  # for it makes us set something
        caller = service.notifies(ref.strip(), ".".join((place.name, *place.path)))
    if parameters.pop("remove", False) not in (False, 0):
        service.listeners.remove(place, caller)
        return
    service.listeners.register(place, options_of(parameters), caller)


def _set_all(service: Service, place: NameEntry, payload: str, caller: Requester) -> None:
    """Set several properties, all or none: each is checked before any is set."""
    pairs = read(payload)
    prefix = f"{place.name}." if place.name else ""
    wanted: dict[str, tuple[PropertyNode, Content]] = {}
    for pair in _group(pairs):
        name, value = _pair(pair)
        node = service.registry.find(prefix + name).node
        if node is None or node.name != prefix + name:
            raise PropertyError("unknown", f"no such property: {prefix + name}")
        if node.name in wanted:
            raise PropertyError("bad-value", f"given twice: {node.name}")
        if node.function is not None:
            raise PropertyError("bad-value", f"an action cannot be taken back: {node.name}")
        service.permit(caller, "SET", node.name)
        service.check_writable(node, node.name)
        try:
            wanted[node.name] = (node, node.spec.admit(check(node.spec.type, value)))
        except PropertyError as error:
            raise PropertyError(error.code, f"{node.name}: {error}") from None
    _apply_all(service, wanted)


def _apply_all(service: Service, wanted: dict[str, tuple[PropertyNode, Content]]) -> None:
    before: list[tuple[PropertyNode, Content]] = []
    for node, value in wanted.values():
        old = service.value_of(node) if "r" in node.spec.access else None
        try:
            service.apply(node, value)
        except PropertyError as error:
            for earlier, known in reversed(before):
                service.apply(earlier, known)
            raise PropertyError(error.code, f"{node.name}: {error}") from error
        if old is not None:
            before.append((node, old))


def _pair(pair: Value) -> tuple[str, Value]:
    if isinstance(pair, tuple) and len(pair) == 2 and isinstance(pair[0], str):
        return canonical(str(pair[0])), pair[1]
    raise PropertyError("bad-value", "expected a list of (name value)")


def _group(value: Value) -> tuple[Value, ...]:
    if not isinstance(value, tuple):
        raise PropertyError("bad-value", "expected a list")
    return value


def _number(given: dict[str, Value], key: str, default: float) -> float:
    value = given.pop(key, default)
    if not is_number(value) or value != value:
        raise PropertyError("bad-parameter", f"{key} is a number")
    return value  # type: ignore[return-value]


def _nothing_else(parameters: dict[str, Value], what: str) -> None:
    if parameters:
        raise PropertyError("bad-parameter", f"{what} has no parameter {min(parameters)}")
