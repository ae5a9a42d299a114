"""Diagnosis: one check, its outcome, and the fix."""

from __future__ import annotations

from typing import NamedTuple

OK, NOTE, WARNING, ERROR = "ok", "note", "warning", "error"


class Diagnosis(NamedTuple):
    """What was found.

    Attributes:
        check: Which look it was: ``folders``, ``managers`` …
        severity: ``ok``, ``note``, ``warning`` or ``error``.
        text: What was found, on one line.
        cure: A command or a sentence that helps; empty where nothing is to be done.
        subject: What it is about; empty for the set-up as a whole.
    """

    check: str
    severity: str
    text: str
    cure: str = ""
    subject: str = ""
