"""Options that methods of the tree of scripts share; help and completion name each of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from inspect import signature
from typing import TYPE_CHECKING, Any, TypedDict, TypeVar, cast

from rtkit.errors import Malformed
from rtkit.rtc.nearest import did_you_mean

if TYPE_CHECKING:
    from rtkit.api.planning import GoalOptions

Method = TypeVar("Method", bound=Callable[..., Any])
NO_MAP: Mapping[str, Any] = {}


class WayKeywords(TypedDict, total=False):
    """Options of the way to a goal; `rtkit.Tree.plan` tells what they mean."""

    replace: bool
    costs: Mapping[str, float]
    stand_in: bool
    transmit: bool
    hosts: Mapping[str, str]
    strict: bool


class PlanKeywords(WayKeywords, total=False):
    """Options of a plan: those of the way, and where it is to lead."""

    state: str
    prune: bool


Request = tuple["GoalOptions", Mapping[str, str], bool]
"""The goal and the way to it, hosts for others, and whether to take warnings for errors."""


def request(
    *,
    state: str = "Active",
    prune: bool = False,
    replace: bool = False,
    costs: Mapping[str, float] = NO_MAP,
    stand_in: bool = False,
    transmit: bool = False,
    hosts: Mapping[str, str] = NO_MAP,
    strict: bool = False,
) -> Request:
    """Return options as operations take them.

    Raises:
        Malformed: There is no such state.
    """
    from rtkit.api import planning

    texts = tuple(f"{name}={cost!r}" for name, cost in costs.items())
    way = planning.WayOptions(texts, planning.MEASURED, stand_in, transmit, replace)
    aim = planning.GoalOptions(known(state, planning.STATES), way, prune)
    return aim, hosts, strict


def known(state: str, words: Sequence[str]) -> str:
    """Return a state as it is written; it may be given in any case.

    Raises:
        Malformed: There is no such state.
    """
    for word in words:
        if word.casefold() == state.casefold():
            return word
    raise Malformed(f"state is one of {', '.join(words)}, not {state!r}")


def takes(options: type) -> Callable[[Method], Method]:
    """Have a method's ``**options`` be these: shown one by one, and others refused."""
    shared = [
        each
        for name, each in signature(request).parameters.items()
        if name in options.__annotations__
    ]

    def spelled_out(method: Method) -> Method:
        plain = signature(method)
        whole = plain.replace(parameters=[*list(plain.parameters.values())[:-1], *shared])

        @wraps(method)
        def checked(*given: Any, **named: Any) -> Any:
            for name in named.keys() - whole.parameters.keys():
                hint = did_you_mean(name, whole.parameters)
                raise TypeError(f"{method.__name__}() has no option {name}{hint}")
            return method(*given, **named)

        checked.__signature__ = whole  # type: ignore[attr-defined]
        return cast("Method", checked)

    return spelled_out
