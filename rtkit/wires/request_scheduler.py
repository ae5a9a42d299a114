"""Schedules requests that may be under way at once, each on a connection of its own.

A request that has no effect on another overtakes it; one that has waits until the other is
answered, so that the outcome is that of requests one after the other.
"""

from __future__ import annotations

from collections.abc import Callable

_LOOKED_AT = 256
"""How many waiting requests are searched for one that may overtake the others."""
_ALL = "properties"


class ScheduledRequest:
    """Request in the schedule.

    Args:
        target: What is asked for.
        is_set: It is a SET.
        work: Makes it.
    """

    __slots__ = ("is_set", "is_under_way", "may_wait", "place", "work")

    def __init__(self, target: str, is_set: bool, work: Callable[[], object]) -> None:
        name, mark, _ = target.partition("?")
        self.place = name.partition(".")[0]
        self.is_set = is_set
        self.may_wait = bool(mark)
        self.work = work
        self.is_under_way = False


class RequestScheduler:
    """Keeps requests in the order in which they came.

    Args:
        most: How many may be under way at once.
    """

    def __init__(self, most: int) -> None:
        self._most = most
        self._turns: dict[ScheduledRequest, None] = {}
        self._under_way = 0

    def add(self, turn: ScheduledRequest) -> None:
        """Take a request on."""
        self._turns[turn] = None

    def begin(self) -> list[ScheduledRequest]:
        """Return those whose turn it is; from now on they are under way."""
        begun: list[ScheduledRequest] = []
        got: set[str] = set()
        changed: set[str] = set()
        has_set = False
        looked_at = 0
        for turn in self._turns:
            if self._under_way == self._most or looked_at == _LOOKED_AT:
                break
            is_free = not (
                (turn.place == _ALL and (has_set or (turn.is_set and got)))
                or turn.place in changed
                or _ALL in changed
                or (turn.is_set and (has_set or turn.place in got))
            )
            if is_free and not turn.is_under_way:
                turn.is_under_way = True
                self._under_way += 1
                begun.append(turn)
            looked_at += not turn.is_under_way
            # What may wait at the owner, as an action does, is no reason for others to wait.
            if turn.is_set and not (turn.may_wait and turn.is_under_way):
                changed.add(turn.place)
                has_set = True
            elif not turn.is_set:
                got.add(turn.place)
        return begun

    def end(self, turn: ScheduledRequest) -> None:
        """Remove a request that has been answered."""
        if self._turns.pop(turn, turn) is None:
            self._under_way -= turn.is_under_way
