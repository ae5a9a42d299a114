"""``rtprofile``: check, show, compare and convert profiles, a module for each word."""

from __future__ import annotations

from rtkit.cli._group import Word, group

WORDS = {
    "check": Word(
        "rtkit.cli.profile.check",
        "Check systems against the RTC profiles of their components; nothing is run.",
    ),
    "validate": Word("rtkit.cli.profile.validate", "Check profiles against the schemas."),
}
_HELP = """Check, show, compare and convert profiles of components and systems.

Nothing that runs is asked or changed: rtprofile looks at files.
"""

main = group("rtprofile", WORDS, _HELP)
