"""``rtprofile``: check, show, compare and convert profiles, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Check, show, compare and convert profiles.

They are documents of components and systems. Nothing that runs is asked or changed: rtprofile
looks at files. Only `from` runs code.
"""

_WORDS = [
    "validate", "check", "show", "resolve", "diff", "convert", "normalise", "set", "order", "new",
    "from", "doc", "graph", "schema",
]  # fmt: skip

main = group(
    "rtprofile",
    _HELP,
    _WORDS,
    examples=(
        ("rtprofile validate robot.xml", "Is it valid, and what had to be put right?"),
        ("rtprofile show -h", "Tell about one of them."),
    ),
)
