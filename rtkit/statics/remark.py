"""What a static check remarks on, and where in the system profile."""

from __future__ import annotations

from typing import NamedTuple


class Place(NamedTuple):
    """A part of a profile: by the fields of the model that lead to it, each with a number.

    Attributes:
        steps: From the root on.
        field: Which of its attributes is meant; empty for the whole part.
    """

    steps: tuple[tuple[str, int], ...] = ()
    field: str = ""

    def below(self, field: str, number: int = 0) -> Place:
        """Return a part of this one."""
        return Place((*self.steps, (field, number)))

    def at(self, field: str) -> Place:
        """Return an attribute of this one."""
        return Place(self.steps, field)


TOP = Place()


class Remark(NamedTuple):
    """One thing that a static check found.

    Attributes:
        severity: ``error``, ``warning`` or ``note``.
        rule: Id of the rule that it is about, one of `rtkit.statics.rules.RULES`.
        text: What was found, in one line.
        found: What stands there; None where nothing does.
        allowed: What may stand there, in words.
    """

    severity: str
    rule: str
    text: str
    place: Place = TOP
    found: str | None = None
    allowed: str = ""
