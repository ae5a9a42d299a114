"""Requests about functional properties: read the state of an action, start it, stop it."""

from __future__ import annotations

from collections.abc import Callable

from rtkit.property.codes import PropertyError
from rtkit.property.functional import FunctionalProperty
from rtkit.property.lanes import first_only
from rtkit.property.live_values import LiveValues, part
from rtkit.property.messages import DONE, Answer, Payload
from rtkit.property.naming import RequestTarget
from rtkit.property.parameters import COMMON, checked_parameters
from rtkit.property.registry import NameEntry, Registry
from rtkit.property.requests import PropertyRequest
from rtkit.property.types import from_payload, parse_type
from rtkit.property.values import Element, Value
from rtkit.property.writing import write


def described(function: FunctionalProperty, place: NameEntry) -> Payload:
    """Return how an action stands, or the part of that which a name means.

    Raises:
        PropertyError: ``unknown``: there is no such part.
    """
    element = function.describe()
    if not place.path:
        return write(element)
    state = element.attributes.get("state") if place.path == ("state",) else None
    return state if state is not None else write(part(place, element))


def start(
    values: LiveValues, place: NameEntry, target: RequestTarget, ask: PropertyRequest
) -> Answer | None:
    """Start an action, or stop it; None if it is answered when it has ended.

    Raises:
        PropertyError: ``busy``, ``bad-value``, ``conflict`` …
    """
    node = place.node
    assert node is not None
    assert ask.payload is not None
    function = node.function
    assert function is not None
    if place.path == ("stop",):
        function.stop()
        return DONE
    if place.path:
        raise PropertyError("read-only", f"cannot be set: {target.name}")
    given = checked_parameters(function.parameters, target, COMMON)
    own = {each.key for each in function.parameters}
    common = {key: given.pop(key, None) for key in COMMON if key not in own}
    if common.get("if") is not None and common["if"] != node.revision:
        raise PropertyError("conflict", f"revision of {target.name} is {node.revision}")
    arguments = function.bind(_arguments(function, ask.payload), given)
    waits = common.get("echo") not in (None, False, 0)
    answer_once = first_only(ask.answer)
    longest = common.get("timeout")
    bounds: list[Callable[[], object]] = []

    def changed() -> None:
        values.keep(node, function.describe())
        if waits and function.state != "running":
            answer_once(Answer(node.payload))
            for end in bounds:
                end()

    function.start(arguments, changed, values.user_code)
    if waits and isinstance(longest, int | float) and function.state == "running":
        bounds.append(values.user_code.refuse_after(max(longest, 1e-3), answer_once))
    return None if waits else DONE


def stop_all(registry: Registry, name: str, permit: Callable[[str], object]) -> None:
    """Stop the actions that run below a place.

    Raises:
        PropertyError: ``conflict``: one cannot be stopped, the others are; ``denied``.
    """
    nodes = [registry.nodes[each] for each in registry.below(name) if each in registry.nodes]
    running = [each for each in nodes if each.function and each.function.state == "running"]
    for node in running:
        permit(node.name)
    refusal: PropertyError | None = None
    for node in running:
        assert node.function is not None
        try:
            node.function.stop()
        except PropertyError as error:
            refusal = PropertyError(error.code, f"{node.name}: {error}")
    if refusal is not None:
        raise refusal


def _arguments(function: FunctionalProperty, payload: Payload) -> Value:
    value = from_payload(parse_type("any"), payload)
    if len(function.parameters) == 1 and not isinstance(value, str | tuple | Element):
        kind = function.parameters[0].type
        value = from_payload(kind if kind.base == "string" else parse_type("any"), payload)
    assert not isinstance(value, bytes)
    return value
