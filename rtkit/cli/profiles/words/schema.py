"""``rtprofile schema``: where the schemas are, for editors and other checkers."""

from __future__ import annotations

import os

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import json_flag, option


@command(
    "schema",
    is_local=True,
    examples=(
        ("rtprofile schema", "Where are the schemas?"),
        ("rtprofile schema -o .", "Have an editor complete and check profiles in this folder."),
    ),
    json=("schema-file",),
    values={"-o": "folder"},
)
def main(
    app: App,
    output: str | None = option(
        "-o --output FOLDER", "Write catalog.xml there, and .vscode/settings.json that names it."
    ),
    is_json: bool = json_flag(),
) -> None:
    r"""Show where the schemas of profiles are, or tell an editor.

    The catalogue has them by namespace: editors that read XML catalogues complete, explain and
    check profiles without a network. xmllint does, too:

    \b
        export XML_CATALOG_FILES=$PWD/catalog.xml
        xmllint --noout --nonet --schema http://www.openrtp.org/namespaces/rts robot.xml

    Of .vscode/settings.json all else is kept.
    """
    from rtkit.profile_tools import catalogue

    if output is None:
        found = catalogue.schemas()
        if is_json:
            terminal.write(json_records.lines("schema-file", (each._asdict() for each in found)))
        else:
            terminal.write(terminal.table(found))
        return
    from rtkit.link.atomic import write_output

    settings = catalogue.editor_settings(output)
    os.makedirs(os.path.join(output, os.path.dirname(catalogue.SETTINGS)), exist_ok=True)
    for name, data in (
        (catalogue.CATALOGUE, catalogue.catalogue()),
        (catalogue.SETTINGS, settings),
    ):
        write_output(data, os.path.join(output, name))
        app.report(f"written  {os.path.join(output, name)}")
