"""Interface of the container for its operations, which import nothing else of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from time import monotonic
from typing import Any, Protocol

from rtkit.component.base import Component
from rtkit.component.contexts.participant import DrivenComponent
from rtkit.deployment.message import Message
from rtkit.errors import Refused, RtkitError
from rtkit.rtc.enums import ReturnCode

LATER = object()
"""Result of an operation that answers later."""

Operations = Mapping[str, Callable[[Message], Any]]


class ContainerServices(Protocol):
    """Container as its operations see it; all on the container's thread but `post`.

    Attributes:
        announce: Names the component whose code runs on this thread, and what runs, for the
            heartbeat of this thread; with two empty texts, nothing.
    """

    announce: Callable[[str, str], object]

    def post(self, work: Callable[[], object]) -> None:
        """Have something done on the container's thread, from any thread."""

    def component(self, instance: str) -> Component:
        """Return a component of this process.

        Raises:
            NotFound: There is none of that name.
        """

    def report(self, component: DrivenComponent) -> None:
        """Report the facts of a component."""

    def answer(self, message: Message, value: Any) -> None:
        """Answer a message."""

    def refuse(self, message: Message, error: RtkitError, code: ReturnCode | None = None) -> None:
        """Answer a message with an error."""


def in_time(message: Message) -> bool:
    """Return whether the sender of a message still waits for its answer.

    Asked before work is begun that had to wait: processes of a host share the monotonic clock.
    """
    until: float = message.get("until", math.inf)
    return monotonic() <= until


def answer_code(host: ContainerServices, message: Message, code: ReturnCode, why: str) -> None:
    """Answer a message with a return code; any but OK is a refusal.

    Of what was done, `why` describes what failed on the way.
    """
    if code is ReturnCode.OK:
        host.answer(message, why)
    else:
        host.refuse(message, Refused(why), code)
