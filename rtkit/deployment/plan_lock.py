"""The lock of a manager: one command at a time carries a plan out, while its process lives.

See decision 40.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import Any, Protocol

from rtkit.errors import Malformed, Refused
from rtkit.fast_dataclass import dataclass
from rtkit.rtc.serde import decode, decode_text, encode_text


class HolderLife(Protocol):
    """The watched process of a lock holder."""

    @property
    def is_over(self) -> bool:
        """Return whether it has ended."""
        ...

    def close(self) -> None:
        """Watch it no more."""
        ...


@dataclass(frozen=True, slots=True)
class LockHolder:
    """A command that carries a plan out.

    Attributes:
        id: Names the lock, so that nobody else gives it back.
        since: When it was taken [s since 1970].
    """

    id: str
    command: str
    user: str
    host: str
    pid: int
    since: float = 0.0

    def __str__(self) -> str:
        began = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(self.since))
        return f"{self.command} ({self.user}, pid {self.pid} on {self.host}, since {began})"


class PlanLock:
    """The lock of one manager: it names its holder, and ends with the holder's process."""

    def __init__(self, watch: Callable[[int], HolderLife]) -> None:
        """Begin without holder; `watch` begins to watch a process by its id, or raises OSError."""
        self._watch = watch
        self._holder: LockHolder | None = None
        self._life: HolderLife | None = None

    @property
    def holder(self) -> LockHolder | None:
        """The present holder, if its process lives."""
        if self._life is not None and self._life.is_over:
            self._end()
        return self._holder

    def asked(self, text: str | None) -> str:
        """Answer a request: who has it, ``{"take": HOLDER}``, or ``{"give": ID}``.

        Raises:
            Malformed: It is none of these.
            Refused: Somebody else has it; names the holder.
        """
        if text is None:
            return encode_text(self.holder) if self.holder is not None else ""
        try:
            asked: dict[str, Any] = json.loads(text)
            wanted = decode(LockHolder, asked["take"]) if "take" in asked else None
            given = str(asked["give"]) if wanted is None else ""
        except (KeyError, TypeError, ValueError) as error:
            raise Malformed(f"neither the wish for a lock nor its end: {error}") from error
        if wanted is not None:
            self._take(wanted)
        elif self._holder is not None and self._holder.id == given:
            self._end()
        return ""

    def _take(self, wanted: LockHolder) -> None:
        holder = self.holder
        if holder is not None:
            raise Refused(str(holder))
        try:
            self._life = self._watch(wanted.pid)
        except (OSError, OverflowError) as error:
            raise Malformed(f"process {wanted.pid} cannot be watched: {error}") from error
        self._holder = wanted

    def _end(self) -> None:
        if self._life is not None:
            self._life.close()
        self._holder = self._life = None


def holder_from_text(text: str) -> LockHolder | None:
    """Return who has a lock, from what its manager answers; None for nobody.

    Raises:
        Malformed: It cannot be read.
    """
    return decode_text(LockHolder, text) if text else None
