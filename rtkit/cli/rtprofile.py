"""``rtprofile``: check, show, compare and convert profiles, a module for each word."""

from __future__ import annotations

from rtkit.cli._group import Subcommand, group

WORDS = {
    "validate": Subcommand("rtkit.cli.profile.validate", "Check profiles against the schemas."),
    "check": Subcommand(
        "rtkit.cli.profile.check",
        "Check systems against the RTC profiles of their components; nothing is run.",
    ),
    "show": Subcommand("rtkit.cli.profile.show", "Show what a profile says."),
    "diff": Subcommand("rtkit.cli.profile.diff", "Compare two profiles by what they mean."),
    "convert": Subcommand("rtkit.cli.profile.convert", "Write a profile as XML, YAML or JSON."),
    "normalise": Subcommand("rtkit.cli.profile.normalise", "Bring profiles to the strict form."),
    "set": Subcommand("rtkit.cli.profile.set", "Set properties of a system and its components."),
    "new": Subcommand("rtkit.cli.profile.new", "Begin the profile of a component or of a system."),
    "from": Subcommand(
        "rtkit.cli.profile.from_component",
        "Write the RTC profile of a component, from its code.",
    ),
    "doc": Subcommand("rtkit.cli.profile.doc", "Write a page about a component, or a system."),
    "graph": Subcommand("rtkit.cli.profile.graph", "Draw a system without running it."),
}
_HELP = """Check, show, compare and convert profiles of components and systems.

Nothing that runs is asked or changed: rtprofile looks at files. Only `from` runs code.
"""

main = group("rtprofile", WORDS, _HELP)
