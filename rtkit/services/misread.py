"""Texts of errors in what a user typed: the column, what is wrong there, and the text itself."""

from __future__ import annotations

_AROUND = 60


def misread(text: str, offset: int, why: str) -> str:
    """Return ``column 12: WHY: TEXT``, of a long text the part around the column (from 1)."""
    start, end = max(0, offset - _AROUND), offset + _AROUND
    shown = "…" * (start > 0) + text[start:end] + "…" * (end < len(text))
    return f"column {offset + 1}: {why}: {shown or 'nothing is there'}"
