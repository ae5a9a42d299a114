"""The verbs of ``rtkit``, each with a summary of one line."""

from __future__ import annotations

from rtkit.cli.shared.commands import COMMANDS
from rtkit.cli.table import TABLE

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
