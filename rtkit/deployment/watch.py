"""Watched states: the states of components as start conditions and waiting commands see them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rtkit.deployment.facts import ComponentFacts
from rtkit.fast_dataclass import dataclass

MISSING = "missing"
"""What is seen of a component that is not there."""


@dataclass(frozen=True, slots=True)
class WatchedComponent:
    """A component in one of its execution contexts, as its manager knows them."""

    instance: str
    context: str


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
    targets: Sequence[WatchedComponent], component: Callable[[str], ComponentFacts | None]
) -> tuple[str, ...]:
    """Return what is to be seen of each target; `component` finds facts by instance name."""
    return tuple(seen(component(each.instance), each.context) for each in targets)
