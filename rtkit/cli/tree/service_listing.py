"""Lists a property service for ``rtls``: names, or with them type, access, unit, value."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from time import monotonic
from typing import TYPE_CHECKING, cast

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, working_directory
from rtkit.errors import RtkitError, Unreachable
from rtkit.link.places import host_name
from rtkit.rtc.names import is_local_host

if TYPE_CHECKING:
    from rtkit.property.codes import PropertyError
    from rtkit.property.values import Element, Value
    from rtkit.tree.property_targets import PropertyTarget
    from rtkit.wires.property_client import PropertyClient

_HEAD = ("type", "access", "unit", "quality")
_CALL_S = 0.1
_CALLS_S = 1.0
"""Time-out of one value, and of all, that user code computes [s]."""


def service_at(typed: str) -> PropertyTarget | None:
    """Return the place in a service that a path names, None if it names something else."""
    from rtkit.link.places import services

    known = services()
    if not known:
        return _far_service_at(typed)
    from rtkit.tree.property_targets import parse

    place = parse(typed, working_directory(), known, host_name())
    return place if place.service else _far_service_at(typed)


def _far_service_at(typed: str) -> PropertyTarget | None:
    """Return the place in a service of a linked host that a path names, None if none does."""
    from rtkit.link.host_links import is_linked

    host, *rest = typed.strip("/").split("/")
    if not (typed.startswith("/") and host and rest and is_linked(host)):
        return None
    from rtkit.tree.far_places import far_place
    from rtkit.tree.property_targets import PropertyTarget

    try:
        place, kind = far_place(PropertyTarget.of_path(typed, typed), [host, *rest], (), _CALLS_S)
    except RtkitError:
        return None  # the tree says what there is, and what is not
    return place if kind == "far" else None


def no_service_at(typed: str) -> PropertyError | None:
    """Return the error that no service is at a path, None if something else may be missed there.

    That is so if services run and the manager does not, which nobody needs for services.
    """
    from rtkit.link.running import services
    from rtkit.property.codes import PropertyError
    from rtkit.tree.place import is_missed
    from rtkit.tree.property_connections import place_here, printed_error

    if is_missed() or not (known := services()):
        return None
    host, *_ = typed.strip("/").split("/")
    if typed.startswith("/") and not is_local_host(host, host_name()):
        return None
    try:
        place_here(typed, working_directory(), known)
    except (PropertyError, Unreachable) as error:
        is_none = isinstance(error, PropertyError) and error.code == "no-service"
        return printed_error(typed, error) if is_none else None
    return None


def above_services(typed: str) -> str:
    """Return a path as it is in the tree if services are below it (``robots``), empty if none."""
    from rtkit.link.places import services

    if not (known := services()):
        return ""
    from rtkit.tree.property_targets import parse

    steps = [name.split("/") for name in known]
    above = {"/".join(each[:end]) for each in steps for end in range(1, len(each))}
    place = parse(typed, working_directory(), above, host_name())
    return f"/localhost/{place.service}" if place.service and not place.name else ""


class ServiceListing:
    """Listing of a place in a service.

    Attributes:
        app: The run of the command.
        place: The place.
        is_deep: Names further below are shown, too.
        has_values: Values are shown.
        names: Of the properties whose values were shown last.
    """

    def __init__(
        self,
        app: App,
        place: PropertyTarget,
        is_long: bool,
        recurse: bool,
        is_json: bool,
        is_single: bool,
    ) -> None:
        self.app = app
        self.place = place
        self.is_deep = recurse
        self.has_values = is_long or is_json
        self.names: list[str] = []
        self._is_json = is_json
        self._is_single = is_single

    def look(self) -> list[str]:
        """Ask the service, and return the lines to show.

        Raises:
            PropertyError: As the service answers.
        """
        from rtkit.cli.properties.asking import connected, shown
        from rtkit.tree.property_connections import asked

        typed = self.place.typed
        base = f"{self.place.name}.properties" if self.place.name else "properties"
        options = ["meta"] * self.has_values + ["all"] * self.is_deep
        target = f"{base}?{'&'.join(options)}" if options else base
        with connected(self.app, None) as places:
            place, end = places.find(typed)
            rows = _group(asked(lambda: end.ask(target), place, end))
            if self.has_values:
                rows = tuple(_completed(end, self.place.name, rows))
        if not self.has_values:
            names = [shown(str(name)) for name in rows]
            is_plain = self._is_single or not terminal.is_terminal()
            return names if is_plain else terminal.columns([(name, name) for name in names])
        self.names = [name for name, _, *value in map(_row, rows) if value]
        if self._is_json:
            return [_record(typed, row) for row in rows]
        return terminal.table([_cells(row) for row in rows])


def _completed(end: PropertyClient, above: str, rows: Sequence[Value]) -> Iterator[Value]:
    """Yield rows with the values that user code computes, where that is quick.

    The service itself calls no such code to list what there is.
    """
    from rtkit.property.limits import ValueLimits
    from rtkit.property.reading import read

    until = monotonic() + _CALLS_S
    for row in rows:
        name, meta, *value = _row(row)
        is_readable = not isinstance(meta, tuple) and "r" in _field(cast("Element", meta), "access")
        if value or not is_readable or monotonic() >= until:
            yield row
            continue
        path = f"{above}.{name}" if above else name
        try:
            answer, error = end.ask(f"{path}?timeout={_CALL_S}")
        except Unreachable:  # a service that passes the request on may give up a little later
            answer, error = "", "timeout"
        if error or not isinstance(answer, str):
            yield row
        elif _field(cast("Element", meta), "type") in ("text", "bytes"):
            yield (name, meta, answer)
        else:
            yield (name, meta, read(answer, ValueLimits(text=1 << 26)))


def _row(row: Value) -> tuple[str, Value, *tuple[Value, ...]]:
    """Return name, description and, unless it is hidden or only has others below it, the value."""
    assert isinstance(row, tuple)
    name, meta, *value = (*row, ()) if len(row) == 1 else row
    return (str(name), meta, *value)


def _group(text: str | bytes) -> tuple[Value, ...]:
    from rtkit.property.limits import ValueLimits
    from rtkit.property.reading import read

    value = read(str(text), ValueLimits(text=1 << 26, items=1 << 24))
    return value if isinstance(value, tuple) else (value,)


def _cells(row: Value) -> tuple[str, ...]:
    from rtkit.property.values import Element
    from rtkit.property.writing import write

    name, meta, *value = _row(row)
    head = [_field(meta, key) for key in _HEAD] if isinstance(meta, Element) else ["-"] * 4
    if isinstance(meta, Element) and meta.find("functional"):
        head[0] = f"action({' '.join(_arguments(meta))})"
    text = write(value[0]) if value else ""
    return (*head, name, text if len(text) <= 200 else f"{text[:200]}…")


def _arguments(meta: Element) -> Iterator[str]:
    """Yield what an action takes: name, choices or what it is when it is not given."""
    from rtkit.property.writing import write

    found = meta.find("arguments")
    for each in found.leaf if found is not None and isinstance(found.leaf, tuple) else ():
        assert isinstance(each, tuple)
        name, _, default, choices, *_ = each
        assert isinstance(choices, tuple)
        chosen = ":" + "|".join(map(str, choices)) if choices else ""
        yield f"{name}{chosen}" + ("" if default == () else f"={write(default)}")


def _field(meta: Element, key: str) -> str:
    found = meta.find(key)
    return str(found.leaf) if found is not None and found.leaf is not None else "-"


def _record(typed: str, row: Value) -> str:
    from rtkit.cli.properties.asking import record
    from rtkit.property.writing import write

    name, _, *value = _row(row)
    return record("property", f"{typed.rstrip('/')}.{name}", write(value[0]) if value else "()")
