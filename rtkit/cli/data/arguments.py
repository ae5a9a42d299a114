"""Shared parts of the data tools: common options, and the ports typed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.options import several

if TYPE_CHECKING:
    from rtkit.probe.port_spec import PortSpec

MODULES = several(
    "-m --mod MODULE",
    "Import a module whose data types take precedence over what ports and files tell.",
)
FOLDERS = several("-p --path DIR", "Look for modules here too.")


def specified(app: App, typed: Sequence[str], *, may_part: bool = False) -> list[PortSpec]:
    """Return the port specifications that the user gave, which perhaps `may_part` among managers.

    Raises:
        RtkitError: There are none, or one of them is none.
    """
    from rtkit.probe.port_spec import parse_spec

    if not typed:
        raise WrongArguments("No ports specified.")
    specs = [parse_spec(each, working_directory()) for each in typed]
    for spec in specs[:1] if may_part else specs:
        app.note_place(spec.path)
    return specs
