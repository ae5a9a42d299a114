"""A look at states of components that is answered when they are no longer what one knows.

A client passes what it saw last. The manager answers as soon as something else is to be seen, at
once if it is so already, and at the latest when the time is up. So nobody needs to ask over and
over, and no change is missed between two questions.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rtkit.deployment.batch import MAX_TIMEOUT_S
from rtkit.deployment.facts import ComponentFacts
from rtkit.errors import Malformed
from rtkit.rtc.plain import decode, encode

MISSING = "missing"
"""What is seen of a component that is not there."""


@dataclass(frozen=True, slots=True)
class Watched:
    """A component in one of its execution contexts, as its manager knows them."""

    instance: str
    context: str


@dataclass(frozen=True, slots=True)
class Watch:
    """What is to be looked at.

    Attributes:
        known: What was seen last, in the same order; empty to be answered at once.
        timeout_s: When to answer though nothing changed [s].
    """

    targets: tuple[Watched, ...]
    known: tuple[str, ...] = ()
    timeout_s: float = 0.0


def seen(facts: ComponentFacts | None, context: str) -> str:
    """Return the state of a component in one context; more words when it is not just that."""
    if facts is None:
        return MISSING
    if facts.zombie:
        return f"zombie ({facts.zombie})"
    state = next((each.state.value for each in facts.contexts if each.id == context), "")
    if not state:
        return f"without execution context {context}"
    return f"{state} ({facts.trouble})" if facts.trouble else state


def look(
    targets: Sequence[Watched], component: Callable[[str], ComponentFacts | None]
) -> tuple[str, ...]:
    """Return what is to be seen of each target; `component` finds facts by instance name."""
    return tuple(seen(component(each.instance), each.context) for each in targets)


def watch_to_text(watch: Watch) -> str:
    """Return a watch as the text that travels."""
    return json.dumps(encode(watch), separators=(",", ":"))


def watch_from_text(text: str) -> Watch:
    """Rebuild a watch.

    Raises:
        Malformed: The text is none, or its time-out no time.
    """
    watch: Watch = decode(Watch, _load(text))
    if not 0 <= watch.timeout_s <= MAX_TIMEOUT_S:
        raise Malformed(f"time-out is not between 0 and {MAX_TIMEOUT_S:g} s: {watch.timeout_s:g}")
    return watch


def states_to_text(states: Sequence[str]) -> str:
    """Return what was seen as the text that travels."""
    return json.dumps(states, separators=(",", ":"))


def states_from_text(text: str) -> tuple[str, ...]:
    """Rebuild what was seen.

    Raises:
        Malformed: The text is no list of states.
    """
    data = _load(text)
    if not isinstance(data, list):
        raise Malformed("not a list of states")
    return tuple(map(str, data))


def _load(text: str) -> object:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"not JSON: {error}") from error
