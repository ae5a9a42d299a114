"""``rtopenrtm``: components written for OpenRTM-aist-Python, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Work with components written for OpenRTM-aist-Python.

Sources that mix tabs and spaces are mended when they are loaded, and nothing is written. Those
that are Python 2 are converted once, by migrate.
"""

main = group(
    "rtopenrtm",
    _HELP,
    ["migrate"],
    examples=(
        ("rtopenrtm migrate --dry-run ConsoleIn.py", "What would change from Python 2 to 3?"),
        ("rtopenrtm migrate ConsoleIn.py", "Convert it, with the files that it imports."),
    ),
)
