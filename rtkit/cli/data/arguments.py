"""Shared parts of the data tools: common options, and the streams of the ports typed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.options import several

if TYPE_CHECKING:
    from rtkit.probe.port_spec import PortSpec, Stream
    from rtkit.rtc.enums import PortType
    from rtkit.rtc.profiles import PortRef

MODULES = several(
    "-m --mod MODULE",
    "Import a module whose data types take precedence over what ports and files tell.",
)
FOLDERS = several("-p --path DIR", "Look for modules here too.")


def specified(app: App, typed: Sequence[str]) -> list[PortSpec]:
    """Return the port specifications that the user gave.

    Raises:
        RtkitError: There are none, or one of them is none.
    """
    from rtkit.probe.port_spec import parse_spec

    if not typed:
        raise WrongArguments("No ports specified.")
    specs = [parse_spec(each, working_directory()) for each in typed]
    for spec in specs:
        app.note_place(spec.path)
    return specs


def named_streams(
    app: App,
    specs: Sequence[PortSpec],
    wanted: PortType,
    unnamed: Callable[[int, PortRef], str] | None = None,
    *,
    is_patient: bool = False,
) -> tuple[Stream, ...]:
    """Return the streams of the ports specified; see `find_streams` for `unnamed`.

    Args:
        app: The run of the command.
        specs: Specifications and patterns.
        wanted: The kind of the ports.
        unnamed: Names streams.
        is_patient: Whether a pattern may match nothing as yet.

    Raises:
        RtkitError: One of them is not there or not of that kind.
    """
    from rtkit.component.typenames import type_by_name
    from rtkit.probe.port_spec import find_streams
    from rtkit.rtc.data_types import scoped_name

    if any(spec.is_pattern for spec in specs):
        from rtkit.probe.port_pattern import expanded

        found = expanded(app.tree.snapshot(), specs, wanted, is_patient=is_patient)
        specs = [spec for spec, _ in found]
    streams = find_streams(app.tree, specs, wanted, unnamed)
    names = [scoped_name(each.data_type) for each in streams if not each.definition]
    if all(type_by_name(name) for name in names if name):
        return streams
    from rtkit.probe.known_types import definitions

    known = definitions(app.tree.snapshot())
    return tuple(s._replace(elsewhere=known.get(scoped_name(s.data_type), "")) for s in streams)


def not_recorded(app: App) -> Callable[[str], object]:
    """Return what warns of a port that matches a pattern and cannot be connected."""
    return lambda why: app.fail(f"warning: {why}; it is not recorded")
