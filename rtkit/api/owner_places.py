"""Other places of components whose hosts are lost; the same are asked for again after a pause.

What hosts have free changes all the time, and so does the reason why there is no place.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from time import monotonic
from typing import NamedTuple

AGAIN_S = 2.0
"""Pause before what failed is tried again [s]."""

Named = Mapping[str, Sequence[str]]


class Found(NamedTuple):
    """Places by component, why there is none for others, and when to ask for those again."""

    places: Mapping[str, str] = {}
    whys: Mapping[str, str] = {}
    again_at: float = 0.0


class OtherPlaces:
    """Asks for the places of the components of each system."""

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock = clock
        self._last: dict[str, tuple[object, Found]] = {}

    def find(
        self,
        system: str,
        named: Named,
        lost: Collection[str],
        ask: Callable[[], tuple[Mapping[str, str], Mapping[str, str]]],
    ) -> Found:
        """Return what there is for components, with the hosts named for each, while some are lost.

        What is known is told again until the pause is over, or others are asked for.
        """
        if not named:
            return Found()
        asked = (dict(named), frozenset(lost))
        last, found = self._last.get(system, (None, Found()))
        if last == asked and not found.places and self._clock() < found.again_at:
            return found
        found = Found(*ask(), self._clock() + AGAIN_S)
        self._last[system] = (asked, found)
        return found
