"""Requests that are made at once, the answers to them, and rounds of them that callers share."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from math import inf
from time import monotonic
from types import MappingProxyType
from typing import Any, NamedTuple

from rtkit.property.messages import Answer

UNSET: Any = object()
"""Stands for no value: the request is a GET."""
_MOMENT_S = 0.05
"""How long a round of shared requests may hold up the next one."""


class Ask(NamedTuple):
    """One of several requests that are made at once.

    Attributes:
        target: The property, as `Client.get` takes it.
        value: To set it to; a GET without.
        parameters: Of the request.
        in_turn: Id of who asks, in letters and digits, where the owner may ask back, as a group
            does that is in a group: see `Client.ask_all`. An owner of another make may take it for
            a parameter that it does not know.
    """

    target: str
    value: Any = UNSET
    parameters: Mapping[str, Any] = MappingProxyType({})
    in_turn: str = ""


class RequestsAtOnce:
    """Requests that are made at once; those who ask wait for the answers."""

    def __init__(self, asks: Sequence[Ask] = ()) -> None:
        self.asks = dict(enumerate(asks))
        self.answers: dict[int, Answer] = {}
        self.is_complete = threading.Event()

    def take(self, place: int, answer: Answer) -> None:
        """Take the answer to a request; under the lock of the host."""
        self.answers[place] = answer
        if len(self.answers) == len(self.asks):
            self.is_complete.set()


class SharedRequests(RequestsAtOnce):
    """Requests that several callers share.

    Attributes:
        sent_at: When all had been sent [s, monotonic].
    """

    def __init__(self) -> None:
        super().__init__()
        self.sent_at = inf
        self.is_sent = threading.Event()
        self._places: dict[str, int] = {}

    def add(self, ask: Ask) -> int:
        """Add a GET, unless it is among them; return its place."""
        place = self._places.setdefault(ask.target, len(self.asks))
        self.asks[place] = ask
        return place

    def sent(self) -> None:
        """Note that all have been sent, and let those know who wait for that."""
        self.sent_at = monotonic()
        self.is_sent.set()


class Rounds:
    """Makes requests once for all who need them; each is sent after all of them have come.

    One round follows another; what is slow holds up the next for a moment only.

    Args:
        make: Sends the requests of a round; waits for no answer.
    """

    def __init__(self, make: Callable[[SharedRequests], object]) -> None:
        self._make = make
        self._lock, self._making = threading.Lock(), threading.Lock()
        self._next: SharedRequests | None = None

    def join(self, asks: Sequence[Ask]) -> tuple[SharedRequests, list[int]]:
        """Have requests made; return the round in which they were sent, and their places in it."""
        with self._lock:
            is_first = self._next is None
            asked = self._next = self._next or SharedRequests()
            places = [asked.add(each) for each in asks]
        if not is_first:
            asked.is_sent.wait()
            return asked, places
        with self._making:
            with self._lock:
                self._next = None  # who comes from now on is in the next one
            try:
                self._make(asked)
            finally:
                asked.sent()
            asked.is_complete.wait(_MOMENT_S)
        return asked, places
