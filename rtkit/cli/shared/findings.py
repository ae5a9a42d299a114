"""Prints findings on a terminal, and on stderr for commands whose output is something else."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rtkit.cli.shared import terminal

if TYPE_CHECKING:
    from rtkit.cli.shared.app import App
    from rtkit.report.finding import Finding

_STYLES = {
    "error": "bold red",
    "warning": "bold yellow",
    "note": "cyan",
    "valid": "bold green",
    "name": "bold",
    "path": "dim",
}


def finding_style(text: str, role: str) -> str:
    """Return a part of a finding as a terminal shows it, if stdout is one."""
    return terminal.styled(text, _STYLES.get(role))


def say_findings(app: App, findings: Iterable[Finding]) -> None:
    """Print findings on stderr, one a line."""
    from rtkit.report.lines import plain_line

    for finding in findings:
        app.say(plain_line(finding))
