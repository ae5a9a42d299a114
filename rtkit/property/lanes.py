"""Assigns requests that call user code to lanes; those of one lane wait for each other.

A request that calls none is answered at once. The others run beside the loop, each in the lane of
its property, so that one property is got and set in the order of the requests.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.property.codes import PropertyError
from rtkit.property.messages import Answer
from rtkit.property.naming import canonical
from rtkit.property.reading import lone_number

if TYPE_CHECKING:  # clients look here for a time-out, and need nothing of the owner's side
    from rtkit.property.live_values import LiveValues
    from rtkit.property.node import PropertyNode
    from rtkit.property.requests import PropertyRequest

NAMES = "?"
"""The lane of all that looks which names there are."""
ALONE = "*"
"""Begins the name of a lane of one request: it waits for none of its property, nor they for it."""
_count = itertools.count()


def alone() -> str:
    """Return a lane of one request."""
    return f"{ALONE}{next(_count)}"


def lane_of(values: LiveValues, ask: PropertyRequest) -> str | None:
    """Return the lane of a request, None of one that calls no user code."""
    nodes, is_set = values.registry.nodes, ask.payload is not None
    node = nodes.get(ask.target)
    path, _, tail = ask.target.partition("?")
    if node is None:  # most requests are a name, and nothing else
        try:
            name = canonical(path.rpartition("/")[2])
        except PropertyError:
            return None
        node = nodes.get(name)
    if node is not None:
        if not (_is_called(node, is_set=is_set) and node.calls_user_code):
            return None
        return alone() if node.is_concurrent and not is_set else node.name
    segments = name.split(".")
    if segments[-1] == "listen":
        return _lane_of_listening(values, segments[:-1], tail)
    part = values.registry.part_of(segments)
    if part is not None and part.node is not None:
        is_called = _is_called(part.node, is_set=is_set) or values.on_names is not None
        return part.name if is_called else None
    if segments[-1] == "properties" and ("values" in tail or "names" in tail):
        return f"{NAMES}{ask.target}"  # it reads values, and may take longer than names do
    is_bulk = segments[-1] == "properties" and (tail or ask.payload is not None)
    return NAMES if is_bulk or values.on_names is not None else None


def _is_called(node: PropertyNode, *, is_set: bool) -> bool:
    return node.reader is not None or (is_set and node.writer is not None)


def _lane_of_listening(values: LiveValues, whose: list[str], tail: str) -> str | None:
    """Return the lane of a request to listen: it has to read a value that is not known."""
    node = values.registry.nodes.get(".".join(whose))
    if node is None:
        is_names = whose[-1:] == ["properties"]
        if is_names and values.registry.is_inner(".".join(whose[:-1])):
            return None
        if values.on_names is not None:
            return NAMES
        part = values.registry.part_of(whose)
        return None if part is None or part.node is None or not part.node.reader else part.name
    has_value = node.value is not None and ("initial=0" in tail or "remove" in tail)
    if node.reader is None or has_value or not node.calls_user_code:
        return None
    return node.name


def wait_of(ask: PropertyRequest, now: float) -> float:
    """Return the time-out of the requester of a request [s], 0 if that is not known."""
    wait = min(timeout_in(ask.target), ask.until - now)
    return 0.0 if wait == math.inf else max(wait, 1e-3)


def timeout_in(target: str) -> float:
    """Return the time-out that is stated in a target [s], infinity if there is none."""
    _, is_stated, tail = target.partition("timeout=")
    number = lone_number(tail.partition("&")[0]) if is_stated else None
    return math.inf if number is None or number != number else float(number)


def first_only(answer: Callable[[Answer], object]) -> Callable[[Answer], None]:
    """Return what passes on the first answer: one that comes too late has been given up."""
    waiting = [answer]

    def first(reply: Answer) -> None:
        if waiting:
            waiting.pop()(reply)

    return first
