"""Rules of this package, beside those of `rtkit.profile.rules`."""

from __future__ import annotations

RULES: dict[str, str] = {
    "comment-dropped": "A comment or processing instruction is no part of a profile",
    "not-carried": "A form cannot hold what the document says",
    "unreadable": "A file or folder cannot be read",
}
"""Description of each rule, by its id."""
