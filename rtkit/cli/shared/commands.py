"""Finds commands by their names and verbs, and imports only the one that is asked for."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rtkit.cli.table import TOPICS

if TYPE_CHECKING:
    from rtkit.cli.shared.command import Main


GROUPS = {
    "profiles.words": "rtprofile",
    "hosts.words": "rthost",
    "keys.words": "rtkeys",
    "packages.words": "rtpkg",
    "openrtm.words": "rtopenrtm",
}
"""Folders of words, and whose words they are."""

TABLE: dict[str, tuple[str, str]] = {
    # A file of a word has an underscore behind what Python keeps for itself.
    f"{GROUPS[topic]} {stem.rstrip('_')}" if topic in GROUPS else stem: (
        f"rtkit.cli.{topic}.{stem}",
        summary,
    )
    for topic, summaries in TOPICS.items()
    for stem, summary in summaries.items()
}
"""Module and summary of each command by its name, ``rtprofile show`` too."""

COMMANDS: dict[str, str] = {name[2:]: name for name in sorted(TABLE) if " " not in name}
"""Verb of the unified tool to the name of the command, of its console script and man page."""


def load(name: str) -> Main:
    """Import a command, by its name or its verb, ``rtprofile show`` too, and return it."""
    made: Main = import_module(TABLE[COMMANDS.get(name, name)][0]).main
    return made


SUMMARIES: dict[str, str] = {verb: TABLE[name][1] for verb, name in COMMANDS.items()}
SHELL_INIT = "shell-init"
COMPLETE = "complete"
HELP = "help"
WORDS: dict[str, str] = {
    COMPLETE: "Tell a shell how a line may go on.",
    HELP: "Tell about a topic, or a verb.",
    SHELL_INIT: "Print the functions that a shell needs.",
}
"""Verbs that are no commands of their own."""
