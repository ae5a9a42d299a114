"""``rtinject``: write values into ports."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping
from typing import IO, TYPE_CHECKING

import click

from rtkit.api.ports import streams_of, types_of, writing
from rtkit.cli.data.arguments import FOLDERS, MODULES, specified
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import POSITIVE, arguments, flag, lasting, option
from rtkit.errors import Malformed, UsageProblem

if TYPE_CHECKING:
    from rtkit.api.ports import Probe
    from rtkit.probe.templates import Template

_ENDLESS = -1


@command(
    "rtinject",
    examples=(
        ("rtinject -c 42 Robot0.rtc:speed", "One value, and wait until it has arrived."),
        ("rtinject -c '{vx: 0.5}' -r 10 -t 1 Robot0.rtc:velocity", "Ten a second for 1 s."),
        ("rtinject --lossless Robot0.rtc:way < points.jsonl", "Each line of a file."),
    ),
    arguments=("in-port",),
)
def main(
    app: App,
    const: str | None = option("-c --const VALUE", "The value; else lines of stdin."),
    file: IO[str] | None = option("-f --file FILE", "Lines of a file.", click.File()),
    number: int | None = option(
        "-n --number N",
        "Write so many values, -1 endlessly (default 1 with -c, else all lines).",
        click.IntRange(min=_ENDLESS),
    ),
    rate: float | None = option(
        "-r --rate HZ", "Values per second (default 1 with -c, else as they are read).", POSITIVE
    ),
    duration_s: float | None = lasting("Write for so long; -n then has no effect."),
    modules: tuple[str, ...] = MODULES,
    folders: tuple[str, ...] = FOLDERS,
    lossless: bool = flag("--lossless", "Wait where the port has no room for a value."),
    ports: tuple[str, ...] = arguments("PORT[.STREAM]..."),
) -> None:
    r"""Write values into ports.

    A value is a JSON or YAML literal of the port's data type; nothing of it is executed. Fields
    that are left out are zero, a time stamp is the present time. A type of nothing but a time
    stamp and data takes the data alone.

    \b
    rtinject -c 42 Motor0.rtc:speed
    rtinject -c '{velocity: {vx: 0.5}}' Motor0.rtc:velocity
    rtinject -c '{"tm": {time}, "data": [1, 2, 3]}' -n 10 -r 100 Arm0.rtc:angles

    It returns when everything has arrived at the ports. While it runs a component of its own,
    rtinject_writer0, is connected to them.
    """
    from rtkit.probe.known_types import import_modules
    from rtkit.probe.templates import templates
    from rtkit.rtc.enums import PortType

    if const is not None and file is not None:
        raise UsageProblem("-c and -f cannot be used together")
    if number == 0:
        raise UsageProblem("-n 0 writes nothing")
    import_modules(modules, folders)
    app.bound(duration_s)
    specs = specified(app, ports)
    streams = streams_of(app.tree, specs, PortType.IN)
    types = types_of(streams)
    if const is not None:
        times = 1 if number is None else number
        values = _repeated(_typed(const, types), times if duration_s is None else _ENDLESS)
    elif file is not None:
        values = templates(file, types, file.name)
    else:
        values = templates(sys.stdin, types, "<stdin>")
    period_s = 1.0 / rate if rate else (1.0 if const is not None else 0.0)
    limit = _ENDLESS if number is None else number
    if duration_s is not None:
        limit = _ENDLESS
    with writing(app.tree, "rtinject_writer", streams, types, lossless=lossless) as probe:
        app.verbose(f"{probe.component.instance} is connected")
        _write(probe, values, period_s, limit, duration_s)
        probe.flush()


def _typed(text: str, types: Mapping[str, type]) -> Template:
    """Read what was typed behind -c.

    Raises:
        Malformed: It is no value of the ports' types.
    """
    from rtkit.probe.templates import Template

    try:
        return Template(text, types)
    except Malformed as error:
        raise Malformed(f"-c {text}: {error}") from error


def _repeated(template: Template, number: int) -> Iterator[Template]:
    while number:
        yield template
        number -= 1


def _write(
    probe: Probe, values: Iterator[Template], period_s: float, limit: int, duration_s: float | None
) -> None:
    """Write values at a steady rate until one of the limits."""
    from rtkit.component.types import Time

    begin = time.monotonic()
    until = None if duration_s is None else begin + duration_s
    for count, value in enumerate(values):
        due = begin + count * period_s
        if count == limit or (until is not None and max(due, time.monotonic()) >= until):
            return
        probe.wait(due)
        for name, data in value.at(Time.now()).items():
            probe.write(name, data)
