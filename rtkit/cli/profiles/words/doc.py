"""``rtprofile doc``: a page about a component or a system, from its profile."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.cli.shared.system_values import PARAMETERS

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile_tools.page import Page

HTML, MARKDOWN = "html", "markdown"
_ENDINGS = {".html": HTML, ".htm": HTML, ".xhtml": HTML, ".md": MARKDOWN, ".markdown": MARKDOWN}


@command(
    "doc",
    is_local=True,
    examples=(
        ("rtprofile doc Motor.xml -o Motor.html", "A page about a component, in one file."),
        ("rtprofile doc -f markdown Motor.xml", "As Markdown, on stdout."),
    ),
)
def main(
    app: App,
    form: str | None = option(
        "-f --format",
        "What to write; else as the name of the output ends, else HTML.",
        click.Choice((HTML, MARKDOWN)),
    ),
    output: str = option("-o --output FILE", "Where to write it.", default="-"),
    no_picture: bool = flag("--no-picture", "Without the picture."),
    parameters: None = PARAMETERS,
    files: tuple[str, ...] = arguments("[FILE]"),
) -> None:
    """Write a page about a component, or a system, from what its profile documents.

    An HTML page is one file, with the picture in it, without scripts, and loads nothing. Markdown
    that is written to a file has its picture in an SVG file beside it.
    """
    from rtkit.cli.profiles.document import read_resolved_document, write_page

    check_at_most_one(files, "file")
    form = form or _ENDINGS.get(os.path.splitext(output)[1].lower(), HTML)
    page = _page(read_resolved_document(app, *files).profile)
    write_page(page._replace(picture="") if no_picture else page, form, output)


def _page(profile: RtcProfile | RtsProfile) -> Page:
    from rtkit.profile.rts_model import RtsProfile

    if isinstance(profile, RtsProfile):
        from rtkit.profile_tools.system_page import system_page

        return system_page(profile)
    from rtkit.profile_tools.component_page import component_page

    return component_page(profile)
