"""``rtget``: print the values of live properties."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import click

from rtkit.cli.properties.asking import (
    AT,
    PARAMETERS,
    connected,
    joined,
    raw,
    record,
    shown,
    write_raw,
)
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    MayWatch,
    arguments,
    flag,
    json_flag,
    option,
    watch_option,
)
from rtkit.cli.shared.watch import watch
from rtkit.errors import RtkitError


@command(
    "rtget",
    cls=MayWatch,
    examples=(
        ("rtget robot", "The names that a service has."),
        ("rtget robot.speed robot.location.x", "Two values, a line each."),
        (
            "rtget /localhost/Motor0.rtc.state",
            "Of a component; also of managers, and localhost.load.",
        ),
        ("rtget -p values -p names='(speed mode)' robot", "Several names with their values."),
        ("rtget robot.speed.meta", "Type, unit, range, time, quality of a property."),
        ("rtget --raw robot.image > image.jpg", "Bytes, as they are; many of them in blocks."),
        (
            "rtget -o image.jpg robot.image",
            "The same into a file, whole or not at all.",
        ),
    ),
    json=("property",),
    arguments=("live",),
)
def main(
    app: App,
    parameters: tuple[str, ...] = PARAMETERS,
    at: str | None = AT,
    is_json: bool = json_flag(),
    is_raw: bool = flag("--raw", "Bytes as they are, no quotes, no line end."),
    output: str | None = option("-o --output FILE", "Write the value, as it is, to this file."),
    period_s: float | None = watch_option(
        "Get again, every second or --watch=SECONDS, until interrupted."
    ),
    targets: tuple[str, ...] = arguments("TARGET..."),
) -> int:
    """Print the values of live properties, a line each.

    TARGET is SERVICE.NAME, or a path such as /localhost/SERVICE/NAME; in place of a service it may
    be a component, a manager or this host (/localhost/Motor0.rtc.state). Elsewhere it is an address
    such as http://HOST:PORT/ps/SERVICE/NAME; rtkit help wires lists their forms. Alone, a service
    stands for the names it has. Behind the name of a property .meta asks what is known of it,
    .properties what is below, .parameters, .gui, .history more. Properties that cannot be got are
    reported behind the others.
    """
    if not targets:
        raise click.UsageError("No targets specified.")
    if is_raw and is_json:
        raise click.UsageError("--raw and --json exclude each other")
    if output is not None:
        if is_json or period_s is not None or len(targets) > 1:
            raise click.UsageError("--output takes the value of one target, as it is")
        is_raw = True
    with connected(app, at, parameters) as places:
        from rtkit.property.codes import PropertyError
        from rtkit.tree.property_connections import asked

        def value(target: str) -> tuple[str, str | bytes]:
            place, end = places.find(target)

            def get(block: Mapping[str, int]) -> str | bytes:
                more = joined([*parameters, *(f"{k}={v}" for k, v in block.items())])
                return asked(lambda: end.ask(place.target(more)), place, end)

            try:
                return place.typed, get({})
            except PropertyError as error:
                if error.code != "too-large" or not is_raw:
                    raise
            from rtkit.property.blocks import joined_blocks

            return place.typed, joined_blocks(get)

        def lines_of(values: Iterable[tuple[str, str | bytes]]) -> list[str]:
            if is_json:
                return [record("property", typed, payload) for typed, payload in values]
            return [shown(payload) for _, payload in values]

        if period_s is not None:
            watch(lambda: lines_of(map(value, targets)), period_s)
            return 0
        values, failures = [], []
        for target in targets:
            try:
                values.append(value(target))
            except RtkitError as error:
                failures.append(error)
        if output is not None:
            from rtkit.link.atomic import write_output

            for _, payload in values:
                write_output(raw(payload), output)
        elif is_raw:
            for _, payload in values:
                write_raw(payload)
        else:
            terminal.write(lines_of(values))
    for failure in failures[:-1]:
        app.fail(str(failure))
    if failures:
        raise failures[-1]
    return 0
