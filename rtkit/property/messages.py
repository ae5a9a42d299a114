"""Messages from a service to an endpoint: answers and events."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.guard import kind_and_text, text_of
from rtkit.property.codes import PropertyError, code_of, rebuilt

Payload = str | bytes


def text_or_bytes(data: bytes) -> Payload:
    """Return what arrived as a text if it is UTF-8: lines do not tell text from bytes otherwise."""
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data


"""Characters end to end; bytes only of properties that are declared so."""

Mark = tuple[int, float, str, str, Payload]


class Answer(NamedTuple):
    """Outcome of one request: the value, or the code and text of an error."""

    payload: Payload
    error: str = ""

    def value(self) -> Payload:
        """Return the value.

        Raises:
            RtkitError: The service answered with an error.
        """
        if self.error:
            raise rebuilt(self.error, str(self.payload))
        return self.payload


DONE = Answer("")


def failed(error: BaseException) -> Answer:
    """Return the answer that stands for an error; no trace, no class of ours in it."""
    code = code_of(error)
    is_ours = code != "internal" or isinstance(error, PropertyError)
    return Answer(text_of(error) if is_ours else kind_and_text(error), code)


class PropertyEvent(NamedTuple):
    """Change of a property as a listener receives it.

    Attributes:
        time: When the value came into force [s since 1970].
        quality: ``good``, ``uncertain``, ``bad`` or ``stale``.
        dropped: How many events before this one were not sent.
        code: Why no further one will come; empty while it lives.
    """

    name: str
    payload: Payload
    time: float
    revision: int
    quality: str = "good"
    dropped: int = 0
    code: str = ""

    @property
    def mark(self) -> Mark:
        """Return the mark that an event shares with a repetition of it."""
        return self.revision, self.time, self.quality, self.code, self.payload
