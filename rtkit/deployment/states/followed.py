"""Status of a followed system: its state and events, as its manager reports them."""

from __future__ import annotations

from rtkit.fast_dataclass import dataclass

AT_FIRST, IS_SO, BY_OTHERS = "at first", "is so", "by others"
"""What is told of how a system came to a state without an event."""


@dataclass(frozen=True, slots=True)
class Followed:
    """Status of a system whose events its manager follows.

    Attributes:
        system: Identity of its profile.
        state: The last one that it was seen in, or the one that it is led to.
        before: The state before that; empty for the first one.
        event: What led from there.
        count: How many transitions there were.
        time: When the last one was, or began [s since 1970].
        is_led: It is being led to `state` just now.
        waits: For whom it waits before it is led on; mostly empty.
        why: Why the last transition that failed did; empty where the last one did not.
        kind: Of that error.
        is_over: It is followed no more, for that reason.
    """

    system: str
    state: str = ""
    before: str = ""
    event: str = ""
    count: int = 0
    time: float = 0.0
    is_led: bool = False
    waits: str = ""
    why: str = ""
    kind: str = ""
    is_over: bool = False

    def __str__(self) -> str:
        if not self.state:
            return "not looked at yet"
        way = f"{self.before} -{self.event}-> {self.state}"
        return way if self.before else f"{self.state} ({self.event})"
