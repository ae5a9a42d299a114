"""Numbers the requests that wait for an answer: events and instructions carry only the numbers."""

from __future__ import annotations

import itertools
from collections.abc import Callable

from rtkit.property.exchange import Reply

Answer = Callable[[Reply], object]
NOBODY = 0
"""Number of a request whose answer nobody waits for."""


class PendingRequests:
    """Receivers of answers, by the number of their request; safe to use from any thread."""

    def __init__(self) -> None:
        self._answers: dict[int, Answer] = {}
        self._numbers = itertools.count(NOBODY + 1)

    def add(self, answer: Answer) -> int:
        """Have the answer to a request passed to `answer`; return the number of the request."""
        number = next(self._numbers)
        self._answers[number] = answer
        return number

    def answer(self, number: int, reply: Reply) -> None:
        """Answer a request, unless it is answered already."""
        answer = self._answers.pop(number, None)
        if answer is not None:
            answer(reply)
