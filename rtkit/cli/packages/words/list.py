"""``rtpkg list``: which packages are installed?"""

from __future__ import annotations

from rtkit.cli.packages.records import installed_record, show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag


@command(
    "list",
    is_local=True,
    examples=(
        ("rtpkg list", "Name, version, types, folder."),
        ("rtpkg list --json", "Also wheels with their SHA-256, and what they need."),
    ),
    json=("package",),
    arguments=(),
)
def main(app: App, is_json: bool = json_flag(), words: tuple[str, ...] = arguments("")) -> None:
    """List the installed packages, the newest version of each first."""
    from rtkit.packages.installed import installed

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    found = [installed_record(each) for each in installed()]
    show(found, is_json)
