"""``rtlisten``: print live properties as they change."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

from rtkit.cli.properties.asking import AT, PARAMETERS, connected, joined, record, shown, write_raw
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    COUNT,
    NumberChoice,
    arguments,
    flag,
    json_flag,
    lasting,
    option,
)

if TYPE_CHECKING:
    from rtkit.property.messages import PropertyEvent
    from rtkit.tree.property_subscription import PropertySubscription

_NS = 1_000_000_000


@command(
    "rtlisten",
    examples=(
        ("rtlisten robot.speed", "Every change, until Ctrl-C."),
        ("rtlisten -n 1 --every 0.5 robot.location", "At most two a second, and only one."),
        ("rtlisten /localhost/Robot0.rtc.ports.pose.count", "How much passes a port."),
        ("rtlisten --mode diff robot", "Which names come and go."),
    ),
    json=("property-event",),
    arguments=("live",),
    statuses={"1": "Nothing came at all, or it could not be done."},
)
def main(
    app: App,
    parameters: tuple[str, ...] = PARAMETERS,
    at: str | None = AT,
    number: int | None = option("-n --number N", "Stop after N.", COUNT),
    duration_s: float | None = lasting(long="--duration"),
    queue: int | None = option(
        "--queue N",
        "Keep N events while they cannot be sent (default 1: the latest).",
        click.IntRange(1, 10_000),
    ),
    every: float | None = option(
        "--every SECONDS",
        "At most one event in this time; the last one always comes.",
        NumberChoice(min=0.0),
    ),
    deadband: float | None = option(
        "--deadband NUMBER", "Only when a number has changed by this much.", NumberChoice(min=0.0)
    ),
    mode: str | None = option(
        "--mode",
        "Each change (default), each set, or of names what came and went.",
        click.Choice(["change", "all", "diff"]),
    ),
    is_json: bool = json_flag(),
    is_raw: bool = flag("--raw", "Bytes as they are, no quotes, no line end."),
    targets: tuple[str, ...] = arguments("TARGET..."),
) -> int:
    """Print live properties as they change.

    The present values come first. TARGET as of rtget; a service alone stands for the names it has.
    It ends after N events, after some time, when a property is removed or its service has gone. The
    status is 1 when nothing came at all.
    """
    if not targets:
        raise click.UsageError("No targets specified.")
    if is_raw and is_json:
        raise click.UsageError("--raw and --json exclude each other")
    options = {"queue": queue, "every": every, "deadband": deadband, "mode": mode}
    given = [f"{key}={value}" for key, value in options.items() if value is not None]
    app.bound(duration_s)
    until = None if duration_s is None else time.monotonic() + duration_s
    count = 0
    with connected(app, at) as places, ExitStack() as stack:
        from rtkit.tree.property_subscription import PropertySubscription

        subscription = stack.enter_context(
            PropertySubscription(places, targets, joined([*parameters, *given]))
        )
        for typed, event in _events(subscription, until):
            if event.code:
                from rtkit.property.codes import PropertyError
                from rtkit.tree.property_connections import printed_error

                raise printed_error(typed, PropertyError(event.code, "it has been removed"))
            if is_raw:
                write_raw(event.payload)
            else:
                line = _json(typed, event) if is_json else _line(typed, event, targets)
                terminal.write_now([line])
            count += 1
            if count == number:
                break
    return 0 if count else 1


def _events(
    subscription: PropertySubscription, until: float | None
) -> Iterator[tuple[str, PropertyEvent]]:
    """Yield events with the target as it was typed, until some time [s, monotonic].

    Raises:
        PropertyError: An owner has gone.
        BrokenPipeError: Nobody reads stdout any more.
    """
    from rtkit.cli.shared.stdout_reader import wait_for

    while True:
        while (event := subscription.take()) is not None:
            yield event
        if until is not None and time.monotonic() >= until:
            return
        wait_for([subscription.fileno()], until)


def _line(typed: str, event: PropertyEvent, targets: tuple[str, ...]) -> str:
    text = shown(event.payload)
    if len(targets) > 1:
        text = f"{terminal.printable(typed)} {text}"
    remarks = [event.quality] if event.quality != "good" else []
    remarks += [f"{event.dropped} dropped"] if event.dropped else []
    return f"{text}  ({', '.join(remarks)})" if remarks else text


def _json(typed: str, event: PropertyEvent) -> str:
    more = {
        "time": json_records.time_text(int(event.time * _NS)),
        "revision": event.revision,
        "quality": event.quality,
        "dropped": event.dropped,
    }
    return record("property-event", typed, event.payload, **more)
