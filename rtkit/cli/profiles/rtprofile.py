"""``rtprofile``: check, show, compare and convert profiles, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import Subcommand, group

_WORDS = "rtkit.cli.profiles.words."
WORDS = {
    "validate": Subcommand(_WORDS + "validate", "Check profiles against the schemas."),
    "check": Subcommand(
        _WORDS + "check",
        "Check systems against the RTC profiles of their components; nothing is run.",
    ),
    "show": Subcommand(_WORDS + "show", "Show what a profile says."),
    "diff": Subcommand(_WORDS + "diff", "Compare two profiles by what they mean."),
    "convert": Subcommand(_WORDS + "convert", "Write a profile as XML, YAML or JSON."),
    "normalise": Subcommand(_WORDS + "normalise", "Bring profiles to the strict form."),
    "set": Subcommand(_WORDS + "set", "Set properties of a system and its components."),
    "new": Subcommand(_WORDS + "new", "Begin the profile of a component or of a system."),
    "from": Subcommand(
        _WORDS + "from_component",
        "Write the RTC profile of a component, from its code.",
    ),
    "doc": Subcommand(_WORDS + "doc", "Write a page about a component, or a system."),
    "graph": Subcommand(_WORDS + "graph", "Draw a system without running it."),
}
_HELP = """Check, show, compare and convert profiles of components and systems.

Nothing that runs is asked or changed: rtprofile looks at files. Only `from` runs code.
"""

main = group("rtprofile", WORDS, _HELP)
