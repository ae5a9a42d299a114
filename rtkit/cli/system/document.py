"""Reads the system profile that the command line names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.api.system_profiles import (
    BUNDLE,
    SystemProfile,
    pairs_of,
    parse_document,
    selected,
    with_hosts,
)
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.profile_files import read_input
from rtkit.cli.shared.system_values import parameters
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.cli.system.shared import DocumentOptions


def read_document(app: App, asked: DocumentOptions, *, prunes: bool = False) -> SystemProfile:
    """Read the system profile that was named, or stdin, as the options want it.

    Repairs are told when verbose.

    Raises:
        NotFound: The file cannot be read, or there is no such part.
        InvalidDocument: It is no system profile.
        UsageProblem: A pair of hosts, or a place, is none.
    """
    return as_asked(app, read_as_is(app, asked.files), asked, prunes=prunes)


def read_as_is(app: App, files: tuple[str, ...]) -> SystemProfile:
    """Read the system profile that was named, or stdin, with its hosts and all of its parts.

    Raises:
        NotFound: The file cannot be read.
        InvalidDocument: It is no system profile.
    """
    return parse_document(app, *read_data(files), app.form, parameters(app))


def as_asked(
    app: App, document: SystemProfile, asked: DocumentOptions, *, prunes: bool = False
) -> SystemProfile:
    """Return a system profile with other hosts and places, and without what is left out.

    Raises:
        NotFound: There is no such part.
        UsageProblem: A pair of hosts, or a place, is none; or the plan `prunes` what is left out.
    """
    if prunes and asked.left_out:
        raise UsageProblem("--prune would end what --without leaves out: give one of them")
    document = with_hosts(document, asked.mapped)
    places = pairs_of("--place", "COMPONENT=PLACE", asked.placed)
    return selected(document, places, asked.left_out, app.usual_manager)


def read_data(files: tuple[str, ...]) -> tuple[str, bytes]:
    """Return the name and the content of the file that was named, or of stdin.

    Raises:
        NotFound: The file cannot be read.
    """
    check_at_most_one(files, "file")
    if files and files[0].endswith(BUNDLE):
        from rtkit.packages.bundle import read_system

        return files[0], read_system(files[0])
    return read_input(files[0] if files else None)
