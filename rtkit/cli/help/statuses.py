"""Exit statuses of commands: the table of every manual page and of ``help statuses``."""

from __future__ import annotations

STATUSES: dict[str, str] = {
    "0": "Success.",
    "1": "It could not be done, or something else was found than was to be.",
    "2": "The command line cannot be read.",
    "130": "Interrupted, as a shell shows it: the command ends by the signal.",
    "141": "Who read its output has gone: rtls -R | head -n 1.",
}
DETAILS: dict[str, str] = {
    "1": "refused",
    "2": "malformed",
    "3": "invalid document",
    "4": "not found",
    "5": "no answer",
    "6": "only a part was done",
    "7": "impossible",
    "8": "a search was given up",
    "70": "a bug",
}
"""Exit statuses that tell failures apart with ``--exit-detail``."""
TOLD_APART = "With --exit-detail (or RTKIT_EXIT_DETAIL=1) failures are told apart"
