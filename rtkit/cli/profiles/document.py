"""Reads the one profile that a word of ``rtprofile`` works on: its text, kind and notes."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.profile_files import read_input
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.profile.common import Note
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile_tools.page import Page
    from rtkit.report.finding import Finding


class ReadDocument(NamedTuple):
    """A profile that was read.

    Attributes:
        name: As the user typed it.
        data: As it stands.
        notes: Repairs and remarks.
    """

    name: str
    data: bytes
    profile: RtcProfile | RtsProfile
    notes: tuple[Note, ...]


def read_resolved_document(app: App, file: str | None = None) -> ReadDocument:
    """Read a profile as `read_document` does, a system with the values that are given.

    Raises:
        NotFound: The file cannot be read.
        InvalidDocument: It is no profile, or its parameters make no sense.
        UsageProblem: Values are given, and it is no system or has no such parameter.
        WrongArguments: No file is named, and stdin is a terminal.
    """
    from rtkit.api.system_profiles import read_parametrised
    from rtkit.cli.shared.system_values import parameters
    from rtkit.profile.forms import has_parameters, may_be_component

    name, data = read_bytes_of(file)
    given = parameters(app)
    if given is None and not has_parameters(data):
        return _document(app, name, data, None)
    if may_be_component(data[:8192]):
        if given is not None:
            raise UsageProblem(f"{name} is a component profile: values are for systems")
        return _document(app, name, data, None)
    found = read_parametrised(app, name, data, None, given)
    return ReadDocument(name, found.data, found.profile, tuple(note for _, note in found.notes))


def read_document(app: App, file: str | None = None, *, kind: str | None = None) -> ReadDocument:
    """Read the profile in a file, or on stdin for ``-`` and for no file; notes are for -v.

    Raises:
        NotFound: The file cannot be read.
        InvalidDocument: It is no profile of this kind, or of any.
        WrongArguments: No file is named, and stdin is a terminal.
    """
    return _document(app, *read_bytes_of(file), kind)


def _document(app: App, name: str, data: bytes, kind: str | None) -> ReadDocument:
    from rtkit.profile.read import read_profile

    reading = read_profile(data, name, kind=kind)
    for note in reading.notes:
        app.verbose(f"{name}:{note.line}: {note.text}")
    return ReadDocument(name, data, reading.profile, reading.notes)


def read_bytes_of(file: str | None) -> tuple[str, bytes]:
    """Return name and content of a file, or of stdin for ``-`` and for no file.

    Raises:
        NotFound: The file cannot be read.
        WrongArguments: No file is named, and stdin is a terminal.
    """
    if file is None and (sys.stdin is None or sys.stdin.isatty()):
        raise WrongArguments("No file specified.")
    return read_input(file)


def report_findings(app: App, findings: Iterable[Finding]) -> None:
    """Print findings on stderr, one a line."""
    from rtkit.report.lines import plain_line

    for finding in findings:
        app.report(plain_line(finding))


def write_page(page: Page, form: str, output: str, dot: str = "") -> None:
    """Write a page in a form of `rtkit.profile_tools.rendering`, `dot` as a diagram in one of them.

    The picture of a page in Markdown is an SVG file beside it; on stdout there is none.

    Raises:
        UsageProblem: The picture would replace the page.
    """
    from rtkit.cli.shared.terminal import display_width
    from rtkit.link.atomic import STDOUT, write_output
    from rtkit.profile_tools.rendering import rendered

    has_file = form == "markdown" and page.picture and output != STDOUT
    picture = f"{os.path.splitext(output)[0]}.svg" if has_file else ""
    if picture and picture == output:
        raise UsageProblem(f"the picture would replace the page: {output}")
    if picture:
        write_output(page.picture.encode(), picture)
    name = os.path.basename(picture)
    text = rendered(page, form, width=display_width, picture_file=name, dot=dot)
    write_output(text.encode(), output)
