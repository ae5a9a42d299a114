"""Requests and replies of the Property Service: GET and SET of text, answered once.

Source: Tikanmäki and Röning, "Property Service Architecture for Distributed Robotic and Sensor
Systems". How they travel is the business of `rtkit.link`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from rtkit import errors

NOT_BEGUN = "the time-out of the request was over before it was begun: nothing was done"
"""The answer to a request that is begun by nobody: its client has given it up."""


class Reply(NamedTuple):
    """Answer to one request: the value in force, or the kind and text of an error."""

    text: str
    error: str = ""

    def value(self) -> str:
        """Return the value.

        Raises:
            RtkitError: The owner answered with an error.
        """
        if self.error:
            raise errors.from_kind(self.error, self.text)
        return self.text


class Request(NamedTuple):
    """One GET (no payload) or SET (with payload) as its owner receives it.

    Attributes:
        name: The property below the service, chunks joined with ``/``.
        is_extension: The name lies in the reserved space (snapshots, meta data).
        until: When the client gives the request up, by the monotonic clock of this host [s].
        id: By which the same request is known when it comes again; empty for nothing.
        answer: To be called exactly once, from any thread.
    """

    name: str
    payload: str | None
    answer: Callable[[Reply], None]
    is_extension: bool = False
    until: float = math.inf
    id: str = ""


def failure(error: BaseException) -> Reply:
    """Return the reply that stands for an error."""
    if isinstance(error, errors.RtkitError):
        return Reply(str(error), error.kind)
    return Reply(f"{type(error).__name__}: {error}", "error")
