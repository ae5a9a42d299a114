"""Shared parts of the data tools: common options, and the streams of the ports typed."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.options import several

if TYPE_CHECKING:
    from rtkit.probe.port_spec import Stream
    from rtkit.rtc.enums import PortType
    from rtkit.rtc.profiles import PortRef

MODULES = several(
    "-m --mod MODULE",
    "Import a module whose data types take precedence over what ports and files tell.",
)
FOLDERS = several("-p --path DIR", "Look for modules here too.")


def types_of(streams: Iterable[Stream]) -> dict[str, type]:
    """Return the data type of each stream, by its name.

    Raises:
        RtkitError: One is not known here.
    """
    from rtkit.probe.known_types import data_type

    return {s.name: data_type(s.data_type, s.ends[0].path.typed, s.definition) for s in streams}


def named_streams(
    app: App,
    typed: Sequence[str],
    wanted: PortType,
    unnamed: Callable[[int, PortRef], str] | None = None,
) -> tuple[Stream, ...]:
    """Return the streams of the ports that the user named; see `find_streams` for `unnamed`.

    Raises:
        RtkitError: There are none, or one of them is not there or not of that kind.
    """
    from rtkit.probe.port_spec import find_streams, parse_spec

    if not typed:
        raise WrongArguments("No ports specified.")
    specs = [parse_spec(each, working_directory()) for each in typed]
    for spec in specs:
        app.note_place(spec.path)
    return find_streams(app.tree, specs, wanted, unnamed)
