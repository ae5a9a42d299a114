"""``rtopenrtm``: components written for OpenRTM-aist-Python, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Work with components written for OpenRTM-aist-Python.

Sources that mix tabs and spaces are mended when they are loaded, and nothing is written. Those
that are Python 2 are made Python 3 once, by migrate. Then they run as they are, loaded by
`rtmgr -l` or as scripts by run; convert writes a native component that does the same.
"""

main = group(
    "rtopenrtm",
    _HELP,
    ["run", "path", "migrate", "convert"],
    examples=(
        ("rtopenrtm run ConsoleIn.py", "Run a component as its author does."),
        ("rtopenrtm migrate --dry-run ConsoleIn.py", "What would change from Python 2 to 3?"),
        ("rtopenrtm migrate ConsoleIn.py", "Convert it, with the files that it imports."),
        ("rtopenrtm convert ConsoleIn.py -o In.py", "Write a native component that does the same."),
    ),
)
