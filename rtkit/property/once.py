"""A request that is repeated with its id acts once: the answer is remembered, for a while."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable

from rtkit.property.messages import Answer

_REMEMBERED = 1024

Answering = Callable[[Answer], object]


class Once:
    """Answers by id, and who waits for those that are not there yet."""

    def __init__(self) -> None:
        self._answers: OrderedDict[Hashable, Answer | list[Answering]] = OrderedDict()

    def first(self, key: Hashable, answer: Answering) -> Answering | None:
        """Return how to answer a request that is new; None if it was made before.

        A repetition is answered when the first is.
        """
        known = self._answers.get(key)
        if isinstance(known, Answer):
            answer(known)
            return None
        if known is not None:
            known.append(answer)
            return None
        waiting = [answer]
        self._answers[key] = waiting
        self._forget_oldest()

        def settle(reply: Answer) -> None:
            self._answers[key] = reply
            for each in waiting:
                each(reply)

        return settle

    def _forget_oldest(self) -> None:
        if len(self._answers) > _REMEMBERED:
            self._answers.popitem(last=False)
