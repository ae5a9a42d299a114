"""Keeps the callers that wait for answers over a connection, by the number of the request."""

from __future__ import annotations

import itertools

from rtkit.property.messages import Answer
from rtkit.proxy.provider_connection import Answering


class Waiting:
    """Requests that are not answered yet; used by the loop only."""

    def __init__(self) -> None:
        self._count = itertools.count(1)
        self._by_number: dict[int, Answering] = {}

    def __len__(self) -> int:
        return len(self._by_number)

    def expect(self, answer: Answering) -> int:
        """Add a waiting caller; return the number of its request."""
        number = next(self._count)
        self._by_number[number] = answer
        return number

    def answer(self, number: int, reply: Answer) -> None:
        """Answer the caller of a request; none waits once the connection has ended."""
        answer = self._by_number.pop(number, None)
        if answer is not None:
            answer(reply)

    def end(self, reply: Answer) -> None:
        """Answer all callers with an error: no answers come any more."""
        waiting, self._by_number = self._by_number, {}
        for answer in waiting.values():
            answer(reply)
