"""Extensions of a property: requests about it, and its listeners.

Source: `property-service` reference, section 2.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from rtkit.property.bulk import Bulk, Permit, item
from rtkit.property.codes import PropertyError
from rtkit.property.live_values import LiveValues, part
from rtkit.property.messages import Payload
from rtkit.property.meta import meta, meta_field
from rtkit.property.naming import RequestTarget
from rtkit.property.parameters import flag, nothing_else, number
from rtkit.property.property_spec import PropertySpec
from rtkit.property.reading import read
from rtkit.property.registry import NameEntry
from rtkit.property.requests import PropertyRequest, Requester
from rtkit.property.subscription import options_of
from rtkit.property.types import from_payload, parse_type
from rtkit.property.values import Value, Word
from rtkit.property.widgets import gui
from rtkit.property.writing import write

Notifies = Callable[[str, str], Requester]
"""Returns who listens elsewhere, for a reference and a property; raises what it cannot do."""


class Extensions:
    """Requests with an extension to one service; arguments as those of `Bulk`.

    Attributes:
        notifies: Where changes may go to others than who asks; None where they may not.
    """

    def __init__(self, values: LiveValues, permit: Permit, get: Callable[[str], Payload]) -> None:
        self._values = values
        self._permit = permit
        self._bulk = Bulk(values, permit, get)
        self.notifies: Notifies | None = None

    def get(self, place: NameEntry, target: RequestTarget, caller: Requester) -> Payload:
        """Answer a GET of an extension.

        Raises:
            PropertyError: ``bad-parameter``, ``unknown``, ``denied``.
        """
        parameters, node = _read_all(target), place.node
        self._check_part(place)
        if place.extension == "properties":
            self._values.names_now()
            return self._bulk.get(place, parameters, caller)
        if place.extension == "history":
            return _history(place, parameters)
        nothing_else(parameters, place.extension)
        if place.extension == "gui" and not place.field:
            self._values.names_now()
            return write(gui(self._values, place, caller))
        if place.extension == "gui":
            return _component(self._values.spec_of(node, place.name), place)
        if node is None:
            raise PropertyError("unknown", f"no such property: {_below(place, place.extension)}")
        if place.extension == "meta":
            described = meta(self._values, place, caller)
            return meta_field(described, place) if place.field else write(described)
        if place.extension == "parameters":
            declared = node.function or node.spec
            return write(tuple(each.described() for each in declared.parameters))
        self._permit(caller, "SET", place.name)
        return write(tuple(self._values.listeners.of(node)))

    def set(self, place: NameEntry, target: RequestTarget, ask: PropertyRequest) -> None:
        """Carry out a SET of an extension.

        Raises:
            PropertyError: ``read-only``, ``bad-value``, ``denied`` …
        """
        parameters = _read_all(target)
        payload = str(from_payload(parse_type("text"), ask.payload or ""))
        if place.extension == "listen":
            self._listen(place, payload.strip(), parameters, ask.caller)
        elif place.extension == "properties":
            self._check_part(place)
            parameters.pop("id", None)
            nothing_else(parameters, "properties")
            self._bulk.set(place, payload, ask.caller)
        else:
            done = "listened to" if place.field == "listen" else "set"
            what = _below(place, place.extension)
            raise PropertyError("read-only", f"cannot be {done}: {what}")

    def _listen(
        self, place: NameEntry, ref: str, parameters: dict[str, Value], caller: Requester
    ) -> None:
        if ref != "self":
            if self.notifies is None:
                raise PropertyError("denied", f"events go to self only, not to {ref[:80]}")
            self._permit(caller, "SET", place.name)  # for it makes us set something
            caller = self.notifies(ref, place.full_name)
        values = self._values
        if flag(parameters, "remove"):
            values.listeners.remove(place, caller)
            return
        read = partial(values.value_of, is_kept=True)
        values.listeners.register(place, options_of(parameters), caller, read)

    def _check_part(self, place: NameEntry) -> None:
        """Refuse requests about a part that a property does not have.

        Raises:
            PropertyError: ``unknown``.
        """
        node = place.node
        if not place.path or node is None:
            return
        if node.function is None:
            part(place, self._values.value_of(node))
        elif place.path not in (("state",), ("stop",)):
            part(place, node.function.describe())


def _read_all(target: RequestTarget) -> dict[str, Value]:
    """Return the parameters of a request about a property; the time-out was taken before."""
    given = {key: True if text is None else read(text) for key, text in target.parameters.items()}
    given.pop("timeout", None)
    return given


def _below(place: NameEntry, extension: str) -> str:
    """Return the full name of an extension: that of the service itself has nothing before it."""
    return f"{place.name}.{extension}".lstrip(".")


def _component(spec: PropertySpec, place: NameEntry) -> Payload:
    if place.field not in spec.gui:
        raise PropertyError("unknown", f"no such property: {_below(place, 'gui')}.{place.field}")
    return spec.gui[place.field]


def _history(place: NameEntry, parameters: dict[str, Value]) -> Payload:
    node = place.node
    if node is None or node.history is None:
        raise PropertyError("unknown", f"no such property: {_below(place, 'history')}")
    begin = number(parameters, "from", float("-inf"))
    end = number(parameters, "to", float("inf"))
    most = number(parameters, "n", len(node.history))
    nothing_else(parameters, "history")
    rows = [row for row in node.history if begin <= row[0] <= end]
    kept = rows[max(0, len(rows) - int(most)) :]
    return write(tuple((time, Word(quality), item(payload)) for time, quality, payload in kept))
