"""``rtget``: print the values of live properties."""

from __future__ import annotations

import click

from rtkit.cli import _out
from rtkit.cli._app import App, WrongArguments, command
from rtkit.cli._properties import connected, joined, place_options, record, shown, write_raw
from rtkit.cli._watch import MayWatch, WatchOption, watch


@command("rtget", cls=MayWatch)
@place_options
@click.option("--json", "is_json", is_flag=True, help="One JSON object a line.")
@click.option("--raw", "is_raw", is_flag=True, help="Bytes as they are, no quotes, no line end.")
@click.option(
    "--watch",
    "period_s",
    cls=WatchOption,
    type=click.FloatRange(min=0.05),
    metavar="SECONDS",
    help="Get again, every second or --watch=SECONDS, until interrupted.",
)
@click.argument("targets", nargs=-1, metavar="TARGET...")
def main(
    app: App,
    parameters: tuple[str, ...],
    at: str | None,
    is_json: bool,
    is_raw: bool,
    period_s: float | None,
    targets: tuple[str, ...],
) -> None:
    """Print the values of live properties, a line each.

    TARGET is SERVICE.NAME, or a path such as /localhost/SERVICE/NAME; in place of a service it
    may be a component, a manager or this host (/localhost/Motor0.rtc.state). Elsewhere it is
    http://HOST:PORT/ps/SERVICE/NAME, ice://HOST:PORT/SERVICE/NAME or serial:DEVICE/NAME. Alone, a
    service stands for the names it has. Behind the name of a property .meta asks what is known of
    it, .properties what is below, .parameters, .gui, .history more.
    """
    if not targets:
        raise WrongArguments("No targets specified.")
    if is_raw and is_json:
        raise click.UsageError("--raw and --json exclude each other")
    with connected(app, at) as places:
        from rtkit.tree.properties import asked

        found = [places.find(target) for target in targets]
        more = joined(parameters)

        def values() -> list[tuple[str, str | bytes]]:
            return [
                (place.typed, asked(lambda: end.ask(place.target(more)), place.typed))  # noqa: B023
                for place, end in found
            ]

        if is_raw:
            for _, payload in values():
                write_raw(payload)
            return

        def look() -> list[str]:
            if is_json:
                return [record("property", typed, payload) for typed, payload in values()]
            return [shown(payload) for _, payload in values()]

        if period_s is None:
            _out.write(look())
        else:
            watch(look, period_s)
