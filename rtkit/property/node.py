"""Property node: the declaration of a property, its value, its accessors and its listeners."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from rtkit.property.codes import PropertyError
from rtkit.property.messages import Payload
from rtkit.property.property_spec import PropertySpec, Reader, Writer
from rtkit.property.types import Content, to_payload
from rtkit.property.values import Value
from rtkit.property.writing import as_item

if TYPE_CHECKING:
    from rtkit.property.functional import FunctionalProperty
    from rtkit.property.names import NameSource
    from rtkit.property.returning import Returning
    from rtkit.property.subscription import Listener


_ENDS = re.compile(r"[\r\n]")


class PropertyNode:
    """One property; it is kept small because there may be very many.

    Attributes:
        revision: Grows with each change of the value.
        time: When the value came into force [s since 1970].
        reader: Computes the value; None where it is kept here.
        history: The last values as (time, quality, payload), where that is switched on.
        source: The owner of the value, which is not kept here, of a name that came; else None.
        choices: Returns the only values allowed just now; None where they do not change.
        returning: Puts it back when nobody sets it any more; None where it stays as it was set.
        is_concurrent: Its reader may be called by several requests at once.
        is_quick: Whether reading and writing call no user code just now; None for never.
    """

    __slots__ = (
        "_line", "_pair", "_payload", "choices", "function", "history", "is_concurrent", "is_quick",
        "listeners", "name", "quality", "reader", "returning", "revision", "source", "spec", "time",
        "value", "writer",
    )  # fmt: skip

    def __init__(self, name: str, spec: PropertySpec, value: Content | None, time: float) -> None:
        self.name = name
        self.spec = spec
        self.value = value
        self.time = time
        self.quality = "good"
        self.revision = 1
        self.reader: Reader | None = None
        self.writer: Writer | None = None
        self.is_concurrent = False
        self.is_quick: Callable[[], bool] | None = None
        self.function: FunctionalProperty | None = None
        self.source: NameSource | None = None
        self.returning: Returning | None = None
        self.choices: Callable[[], tuple[Value, ...]] | None = None
        self.listeners: list[Listener] | None = None
        self.history: deque[tuple[float, str, Payload]] | None = None
        self._payload: Payload | None = None
        self._line: bytes | None = None
        self._pair: str | None = None

    @property
    def payload(self) -> Payload:
        """The value as replies carry it, written once."""
        payload = self._payload
        if payload is None:
            if self.value is None:
                raise PropertyError("write-only", f"cannot be read: {self.name}")
            payload = self._payload = to_payload(self.spec.type, self.value)
        return payload

    @property
    def line(self) -> bytes:
        """The value as the reply of one line, written once; empty if it takes more than that."""
        line = self._line
        if line is None:
            text = self.payload
            line = b""
            if isinstance(text, str) and text and text[0] != "{" and not _ENDS.search(text):
                line = b"= %b\n" % text.encode("utf-8", "surrogateescape")
            self._line = line
        return line

    @property
    def pair(self) -> str:
        """Name and value as listings of values carry them, written once; empty if that is more."""
        pair = self._pair
        if pair is None:
            is_value = self.value is not None and self.spec.type.base != "text"
            text = self.payload if is_value else None
            pair = f"({as_item(self.name)} {text})" if isinstance(text, str) else ""
            self._pair = pair
        return pair

    def put(self, value: Content, time: float, quality: str = "good") -> bool:
        """Put a value in force; return whether it differs from the one before.

        Raises:
            PropertyError: ``bad-value``, ``too-large``: no text stands for it; nothing changed.
        """
        payload: Payload | None
        old = self.value
        if type(value) is float and type(old) is float and self.history is None:
            # Zeros have a sign, and what is no number is not equal to itself.
            differs = value != old if value and value == value else repr(value) != repr(old)
            # Decision 34: a loop sets it more often than somebody reads it.
            payload = None if differs else self._payload
        else:
            payload = to_payload(self.spec.type, value)
            differs = old is None or payload != self.payload
        has_changed = differs or quality != self.quality
        self.value, self._payload, self.time, self.quality = value, payload, time, quality
        if differs:
            self._line = self._pair = None
        if has_changed:
            self.revision += 1
        # Computed values are read again and again; a kept value was set once more.
        if self.history is not None and (has_changed or self.reader is None):
            self.history.append((time, quality, self.payload))
        return has_changed

    @property
    def calls_user_code(self) -> bool:
        """Return whether getting or setting it calls user code, which may take any time."""
        if self.reader is None and self.writer is None:
            return False
        return self.is_quick is None or not self.is_quick()
