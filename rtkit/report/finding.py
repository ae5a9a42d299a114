"""A finding of a check, and all findings of one thing that was checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

ERROR, WARNING, NOTE = "error", "warning", "note"
SEVERITIES = (ERROR, WARNING, NOTE)
ANYTHING = "any text"
"""The `allowed` of a missing text, which messages leave out."""

Rules = Mapping[str, str]
"""Subject of each rule in one line, by its id."""


class Finding(NamedTuple):
    """One thing that was found.

    Attributes:
        severity: One of `SEVERITIES`; only errors decide the verdict.
        rule: Id of the rule that it is about.
        text: The finding in one line, as a person reads it.
        file: Where, as the user typed it.
        line: From 1; 0 where there is none.
        path: XPath of the element or attribute; empty where there is none.
        found: Text that stands there; None where nothing does.
        allowed: Allowed values, in words.
    """

    severity: str
    rule: str
    text: str
    file: str
    line: int = 0
    path: str = ""
    found: str | None = None
    allowed: str = ""

    @property
    def full_text(self) -> str:
        """The text, with what is allowed where it does not tell that itself."""
        if self.allowed in ("", ANYTHING) or self.allowed in self.text:
            return self.text
        return f"{self.text}; allowed: {self.allowed}"


class Checked(NamedTuple):
    """One thing that was checked, a file mostly.

    Attributes:
        name: The thing as the user typed it.
        what: Its kind, ``RTS profile``; empty where that is not known.
        findings: In the order to be shown.
        is_read: Whether it could be read.
    """

    name: str
    what: str
    findings: tuple[Finding, ...]
    is_read: bool = True

    @property
    def is_valid(self) -> bool:
        """Return whether there is no error."""
        return self.count(ERROR) == 0

    def only_errors(self) -> Checked:
        """Return the same without warnings and notes."""
        return self._replace(findings=tuple(f for f in self.findings if f.severity == ERROR))

    def count(self, severity: str) -> int:
        """Return how many findings are of this severity."""
        return sum(finding.severity == severity for finding in self.findings)


def counted(number: int, word: str) -> str:
    """Return a number with its noun.

    >>> counted(1, "note"), counted(2, "note"), counted(2, "process")
    ('1 note', '2 notes', '2 processes')
    """
    return f"{number} {word}{'' if number == 1 else 'es' if word.endswith('s') else 's'}"
