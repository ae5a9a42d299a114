"""What a reader finds on its way: repairs, remarks and errors, each with its line."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rtkit.errors import InvalidDocument
from rtkit.profile.common import Note

_SHOWN = 50
_TOO_MANY = 1000


class InvalidProfile(InvalidDocument):
    """A profile that cannot be accepted.

    Attributes:
        problems: All that was found wrong, by line.
    """

    def __init__(self, source: str, problems: Iterable[Note]) -> None:
        self.problems = tuple(dict.fromkeys(sorted(problems)))
        shown = [f"{source}:{note.line}: {note.text}" for note in self.problems[:_SHOWN]]
        if len(self.problems) > _SHOWN:
            shown.append(f"{source}: … and {len(self.problems) - _SHOWN} more problems")
        super().__init__("\n".join(shown))


class Findings:
    """Collector of what was found; lines are those of the document as it was read.

    Attributes:
        scope: The prefixes, where the whole document has the same ones.
        good_types: Values of ``xsi:type`` seen to be right in this scope, with their tables.
    """

    def __init__(self, source: str, scope: dict[str | None, str] | None = None) -> None:
        self.source = source
        self.scope = scope
        self.good_types: set[tuple[str, Any]] = set()
        self.repairs: list[Note] = []
        self.remarks: list[Note] = []
        self.errors: list[Note] = []
        self._said: set[str] = set()

    def repaired(self, element: Any, text: str) -> None:
        """Record a deviation that was put right."""
        self.repairs.append(Note(element.sourceline or 0, text))

    def remark(self, element: Any, text: str) -> None:
        """Record, once, something that is allowed but worth knowing."""
        if text not in self._said:
            self._said.add(text)
            self.remarks.append(Note(element.sourceline or 0, text))

    def wrong(self, element: Any, text: str) -> None:
        """Record an error that no mode forgives.

        Raises:
            InvalidProfile: There are so many that looking further is of no use.
        """
        self.errors.append(Note(element.sourceline or 0, text))
        if len(self.errors) > _TOO_MANY:
            raise InvalidProfile(self.source, self.errors)

    def namespaces(self, element: Any) -> dict[str | None, str]:
        """Return the prefixes in force at `element`."""
        return self.scope if self.scope is not None else dict(element.nsmap)
