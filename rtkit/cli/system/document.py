"""Reads the system profile that the command line names."""

from __future__ import annotations

from rtkit.api.system_profiles import BUNDLE, SystemProfile, parse_document, with_hosts
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.profile_files import read_input
from rtkit.cli.shared.system_values import parameters


def read_document(app: App, files: tuple[str, ...], mapped: tuple[str, ...] = ()) -> SystemProfile:
    """Read the system profile that was named, or stdin, with hosts for others (``HOST=HOST``).

    Repairs are told when verbose.

    Raises:
        NotFound: The file cannot be read.
        InvalidDocument: It is no system profile.
        UsageProblem: A pair of hosts is none.
    """
    document = parse_document(app, *read_data(files), app.form, parameters(app))
    return with_hosts(document, mapped)


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
