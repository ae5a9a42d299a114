"""``rtpkg build``: make a package of a component's folder."""

from __future__ import annotations

from rtkit.cli.packages.records import record
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, option


@command(
    "build",
    is_local=True,
    examples=(
        ("rtpkg build Scale", "The wheel lies in this folder then."),
        ("rtpkg build Scale -o wheels", "In another one, which is made if need be."),
    ),
    json=("package",),
    arguments=("file",),
)
def main(
    app: App,
    output: str = option("-o --output DIR", "Where the wheel goes (default .).", default="."),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments("FOLDER"),
) -> None:
    """Build a package of a folder with pyproject.toml, as rtnew and rtbuild make one.

    It must have entry points of the group rtkit.components, each with a type that its source
    describes; each type needs a valid RTC profile in the package. Otherwise nothing is made.
    """
    import os

    from rtkit.packages.building import build

    if len(words) != 1:
        raise WrongArguments("takes a folder")
    wheel = build(words[0], output)
    path = os.path.join(output, wheel.file)
    if is_json:
        found = record(
            wheel.name,
            wheel.version,
            path,
            types=[each.id for each in wheel.types],
            requires=wheel.requires,
            wheels={wheel.file: wheel.sha256},
        )
        terminal.write([json_records.line("package", found)])
    else:
        terminal.write([terminal.printable(path)])
