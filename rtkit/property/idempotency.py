"""Idempotency cache: a request that is repeated with its id acts once; answers are kept a while.

See decision 19.
"""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Callable, Hashable

from rtkit.property.codes import PASSING
from rtkit.property.messages import Answer, Payload
from rtkit.property.requests import PropertyRequest

_REMEMBERED = 1024
_MOST_BYTES = 1 << 22
"""Of the answers that are remembered, all together."""
_SHORT = 64
_SHARED = re.compile(r"~[0-9a-f]{32}")

Answering = Callable[[Answer], object]


class IdempotencyCache:
    """Keeps answers by id, and the callers that wait for answers under way."""

    def __init__(self) -> None:
        self._answers: OrderedDict[Hashable, Answer | list[Answering]] = OrderedDict()
        self._bytes = 0

    def first(self, key: Hashable, answer: Answering) -> Answering | None:
        """Return how to answer a request that is new; None if it was made before.

        A repetition is answered when the first is. A request that failed in passing was not made.
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
            if self._answers.get(key) is waiting:
                self._settle(key, reply)
            for each in waiting:
                each(reply)

        return settle

    def _settle(self, key: Hashable, reply: Answer) -> None:
        if reply.error in PASSING:
            del self._answers[key]
            return
        self._answers[key] = reply
        self._bytes += len(reply.payload)
        self._forget_oldest()

    def _forget_oldest(self) -> None:
        while len(self._answers) > _REMEMBERED or self._bytes > _MOST_BYTES:
            _, oldest = self._answers.popitem(last=False)
            if isinstance(oldest, Answer):
                self._bytes -= len(oldest.payload)


def identity_of(ask: PropertyRequest, id: str | None) -> Hashable:
    """Return what makes a SET the same as one before, None if nothing does.

    Args:
        ask: The SET.
        id: Of its parameters, which are asked for before its own.
    """
    payload = marked(ask.payload)
    if id is not None:
        return (ask.target, payload, id)
    if not ask.id:
        return None
    origin = None if is_shared(ask.id) else ask.caller.origin
    return (origin, ask.id, ask.target, payload)


def shared(*parts: str) -> str:
    """Return an id that is the same one whoever asks with it, over whatever connection."""
    joined = "\0".join(parts)
    return f"~{_digest(joined).hex()}"


def is_shared(id: str | None) -> bool:
    """Return whether an id was made by `shared`."""
    return id is not None and _SHARED.fullmatch(id) is not None


def marked(payload: Payload | None) -> Hashable:
    """Return a digest that identifies a payload and takes little memory."""
    if payload is None or len(payload) <= _SHORT:
        return payload
    return isinstance(payload, str), _digest(payload)


def _digest(payload: Payload) -> bytes:
    from hashlib import blake2b  # it brings OpenSSL along, which commands that ask seldom need

    raw = payload.encode("utf-8", "surrogatepass") if isinstance(payload, str) else payload
    return blake2b(raw, digest_size=16).digest()
