"""Checks of ``rtdoctor``: this installation, this user's folders, limits, managers."""

from __future__ import annotations

from typing import NamedTuple

OK, NOTE, WARNING, ERROR = "ok", "note", "warning", "error"


class Diagnosis(NamedTuple):
    """The outcome of one check.

    Attributes:
        check: Name of the check: ``folders``, ``managers`` …
        severity: ``ok``, ``note``, ``warning`` or ``error``.
        text: The outcome on one line.
        cure: The fix, a command or a sentence; empty where nothing is to be done.
        subject: The thing checked; empty for the set-up as a whole.
    """

    check: str
    severity: str
    text: str
    cure: str = ""
    subject: str = ""
