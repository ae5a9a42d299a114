"""``rtprint``: print the values that come out of ports."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING

from rtkit.api.ports import reading, streams_at, types_of
from rtkit.cli.data.arguments import FOLDERS, MODULES, specified
from rtkit.cli.shared import stdout_reader
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    COUNT,
    NumberChoice,
    arguments,
    either,
    flag,
    json_flag,
    lasting,
    option,
    several,
)
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from rtkit.cli.data.printing import PrintOptions, Sink
    from rtkit.probe.port_spec import Stream
    from rtkit.probe.tap import Arrival

LINES, STATS, PLOT = "lines", "stats", "plot"


@command(
    "rtprint",
    examples=(
        ("rtprint Robot0.rtc:pose", "Every value, until Ctrl-C."),
        ("rtprint -n 1 -f data.position.x Robot0.rtc:pose", "One field of the next value."),
        ("rtprint --plot Robot0.rtc:pose", "The numbers of its pose as curves."),
        ("rtprint -t 2 --json A0.rtc:out B0.rtc:out", "All values of 2 s as JSON lines."),
    ),
    json=("value", "stream-stats"),
    arguments=("out-port",),
    statuses={"1": "Nothing came at all, or it could not be done."},
)
def main(
    app: App,
    number: int | None = option("-n --number N", "Stop after N values.", COUNT),
    rate: float | None = option(
        "-r --rate HZ",
        "Look this often and take the newest value of each port; -n then counts looks.",
        NumberChoice(min=0.0, min_open=True, max=100_000),
    ),
    duration_s: float | None = lasting("Stop after this time; -n then has no effect."),
    modules: tuple[str, ...] = MODULES,
    folders: tuple[str, ...] = FOLDERS,
    fields: tuple[str, ...] = several(
        "-f --field FIELD", "Only data.x, or ranges[0] (repeatable)."
    ),
    is_full: bool = flag("--full", "Do not shorten long contents."),
    form: str | None = either(
        option("--stats", "Print no values but how they came, at the end.", flag_value=STATS),
        option("--plot", "Draw the numbers in them over time.", flag_value=PLOT),
    ),
    is_json: bool = json_flag(),
    lossless: bool = flag("--lossless", "Lose no value; the component that writes waits instead."),
    ports: tuple[str, ...] = arguments("PORT[.STREAM][#FORMATTER]..."),
) -> int:
    """Print the values that come out of ports, as they come.

    It ends after N values, after some time, or when its connections are gone. The status is 1
    when nothing came at all. While it runs a component of its own, rtprint_reader0, is connected
    to the ports.

    A value of nothing but a time stamp and data is printed as [seconds] data; of an image only
    what it is like; of several ports each line begins with the port. FORMATTER is a function of
    one argument, MODULE.NAME, or rawpy for the full text of every value. Time stamps are by the
    clock of their own host: how far that differs is told on stderr, by --json with each value.

    With --stats: how many values came, their rate, the intervals between them with the standard
    deviation as jitter, their size in CDR, their age on arrival by their time stamps, and how the
    numbers in the fields of -f are spread. With --plot: the last 30 s as curves, on a terminal as
    they come, else at the end.
    """
    from rtkit.cli.data.printing import PrintOptions
    from rtkit.component.values.fields import check_field
    from rtkit.probe.known_types import import_modules
    from rtkit.rtc.enums import PortType

    if form == PLOT and is_json:
        raise UsageProblem("--plot draws: no --json")

    import_modules(modules, folders)
    app.bound(duration_s)
    specs = specified(app, ports, may_part=True)
    streams = streams_at(app.tree_at, specs, PortType.OUT)
    types = types_of(streams)
    for cls in types.values():
        for field in fields:
            check_field(cls, field)
    for clock in {each.clock for each in streams} if form is None and not is_json else ():
        if abs(clock.offset_s) > clock.bound_s:
            ahead = f"{clock.offset_s:+.4f} s (± {clock.bound_s:.4f} s)"
            app.fail(f"clock of {clock.host}: {ahead}, not taken off its time stamps")
    sink = _sink(form or LINES, streams, types, PrintOptions(fields, is_full, is_json))
    limit = None if duration_s is not None else number
    with (
        reading(app.tree, "rtprint_reader", streams, rate=rate or 0.0, lossless=lossless) as probe,
        stdout_reader.while_read(probe.stop) as reader,
    ):
        app.verbose(f"{probe.component.instance} is connected")
        until = None if duration_s is None else time.monotonic() + duration_s
        for piece in _limited(probe.arrivals(until), limit, is_by_piece=rate is not None):
            sink.take(piece)
        reader.check()
        lost = 0 if rate else probe.lost  # at a rate values are passed over on purpose
        sink.finish(lost)
        if lost:
            app.report(f"{app.name}: {lost} values were lost")
        probe.check_connected()
    return 0 if sink.count else 1


def _sink(
    form: str, streams: tuple[Stream, ...], types: dict[str, type], options: PrintOptions
) -> Sink:
    from rtkit.cli.data import printing

    if form == STATS:
        return printing.Counter(streams, types, options)
    if form == PLOT:
        return printing.Plotter(streams, types, options)
    return printing.Printer(streams, types, options)


def _limited(
    pieces: Iterator[list[Arrival]], limit: int | None, *, is_by_piece: bool
) -> Iterator[list[Arrival]]:
    """Yield pieces until there were so many of them, or of their values."""
    left = limit
    for piece in pieces:
        taken = piece if left is None or is_by_piece else piece[:left]
        yield taken
        if left is not None:
            left -= 1 if is_by_piece else len(taken)
            if left <= 0:
                return
