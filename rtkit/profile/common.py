"""Shared parts of both profile models: properties, foreign content, the result of reading."""

from __future__ import annotations

from typing import Generic, TypeVar

from rtkit.fast_dataclass import dataclass, field

P = TypeVar("P")
_LONGEST = 1000
"""Longer texts of notes are clipped: a document must not flood its reader."""


@dataclass(frozen=True, slots=True)
class ForeignElement:
    """An element that no profile schema knows, kept for the round trip.

    Attributes:
        name: ``{namespace}local``.
        attributes: Sorted pairs of ``{namespace}local`` and value.
        text: Text before the first child; None where there is nothing but layout.
        tail: Text after the element, inside its foreign parent.
    """

    name: str
    attributes: tuple[tuple[str, str], ...] = ()
    text: str | None = None
    children: tuple[ForeignElement, ...] = ()
    tail: str | None = None


@dataclass(frozen=True, slots=True)
class Foreign:
    """Attributes and elements of other namespaces found on one element of a profile."""

    attributes: tuple[tuple[str, str], ...] = ()
    elements: tuple[ForeignElement, ...] = ()


NO_FOREIGN = Foreign()


@dataclass(frozen=True, slots=True)
class ExtensionProperty:
    """An extension property (``rtsExt:Properties``, ``rtcExt:Properties``)."""

    name: str
    value: str | None = None
    foreign: Foreign = NO_FOREIGN


@dataclass(frozen=True, slots=True, order=True)
class Note:
    """One thing that was repaired, is wrong or is worth knowing, with the line it was found at.

    Attributes:
        path: XPath of the element or attribute in the document as it was read, with the usual
            prefixes; empty where there is none.
        rule: Which rule of `rtkit.profile.rules` it is about.
        found: Text that stands there; None where nothing does.
        allowed: Allowed values, in words.
    """

    line: int
    text: str
    path: str = ""
    rule: str = field(default="", compare=False)
    found: str | None = field(default=None, compare=False)
    allowed: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        for name in ("text", "path", "found", "allowed"):
            value = getattr(self, name)
            if value is not None and len(value) > _LONGEST:
                object.__setattr__(self, name, clipped(value))


def clipped(text: str) -> str:
    """Return the beginning and the end of a text that is too long to be told."""
    half = _LONGEST // 2
    return f"{text[:half]} … {text[-half:]}"


@dataclass(frozen=True, slots=True)
class Reading(Generic[P]):
    """A profile as read, with what had to be repaired on the way."""

    profile: P
    notes: tuple[Note, ...] = ()
