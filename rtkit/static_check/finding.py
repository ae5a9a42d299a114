"""Findings of a static check, with their locations in the system profile."""

from __future__ import annotations

from typing import NamedTuple


class ProfileLocation(NamedTuple):
    """A part of a profile: by the fields of the model that lead to it, each with a number.

    Attributes:
        steps: From the root on.
        field: Which of its attributes is meant; empty for the whole part.
    """

    steps: tuple[tuple[str, int], ...] = ()
    field: str = ""

    def below(self, field: str, number: int = 0) -> ProfileLocation:
        """Return a part of this one."""
        return ProfileLocation((*self.steps, (field, number)))

    def at(self, field: str) -> ProfileLocation:
        """Return an attribute of this one."""
        return ProfileLocation(self.steps, field)


TOP = ProfileLocation()


class StaticFinding(NamedTuple):
    """A finding of a static check.

    Attributes:
        severity: ``error``, ``warning`` or ``note``.
        rule: Id of the rule that it is about, one of `rtkit.static_check.rules.RULES`.
        text: What was found, in one line.
        found: What stands there; None where nothing does.
        allowed: What may stand there, in words.
    """

    severity: str
    rule: str
    text: str
    place: ProfileLocation = TOP
    found: str | None = None
    allowed: str = ""
