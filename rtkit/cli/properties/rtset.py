"""``rtset``: set a live property."""

from __future__ import annotations

import re
import sys
import time
from typing import TYPE_CHECKING

import click

from rtkit.cli.properties.asking import AT, PARAMETERS, connected, joined, shown
from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option

if TYPE_CHECKING:
    from rtkit.tree.property_targets import PropertyTarget
    from rtkit.wires.property_client import PropertyClient

_NUMBER = re.compile(r"-(?:\.?\d|inf$).*")
_MARK = "\0"


class _TakesNumbers(click.Command):
    """Takes ``-0.5`` for a value, not for an option."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        end = args.index("--") if "--" in args else len(args)
        marked = [_MARK + each if _NUMBER.fullmatch(each) else each for each in args[:end]]
        return super().parse_args(ctx, marked + args[end:])


@command(
    "rtset",
    cls=_TakesNumbers,
    examples=(
        ("rtset robot.speed -0.5", "A number."),
        ("rtset robot.location.x 3", "A part of a vector."),
        ("rtset --echo robot.double 21", "An action: wait, and print what came of it."),
        ("rtset -p number=21 robot.double", "An action whose arguments are named."),
        ("rtset --if 7 robot.mode drive", "Only if nobody has changed it since."),
        ("rtset robot properties '((speed 0) (mode idle))'", "Several, all or none."),
        ("rtset /localhost/Motor0.rtc.state Active", "Of a component: it is activated."),
        ("rtset --file image.jpg robot.image", "The content of a file; much in blocks."),
    ),
    arguments=("live", "value", ""),
)
def main(
    app: App,
    parameters: tuple[str, ...] = PARAMETERS,
    at: str | None = AT,
    path: str | None = option("--file FILE", "Take the value from this file."),
    revision: int | None = option("--if REV", "Only if this is the revision.", int),
    has_echo: bool = flag("--echo", "Print the value that is in force then."),
    words: tuple[str, ...] = arguments("TARGET VALUE"),
) -> None:
    """Set a live property.

    An action is started by it.

    TARGET VALUE, or PATH PROPERTY VALUE. A VALUE of - is read from stdin. When the command
    returns without an error the value is in force: whoever asks now gets it, or a newer one.

    An action takes its arguments as a group, or as parameters with -p, then without a VALUE;
    it has started when the command returns, with --echo it is done and its outcome is printed;
    the status is 1 if it failed.
    """
    given = [each.removeprefix(_MARK) for each in words]
    wanted = 1 if path is not None else 2
    if len(given) == wanted + 1:
        given[:2] = [f"{given[0].rstrip('/')}/{given[1]}"]
    is_call = path is None and len(given) == 1 and bool(parameters or "?" in given[0])
    if len(given) != wanted and not is_call:
        raise click.UsageError("takes a target and a value")
    payload = _content(path) if path is not None else "" if is_call else given[1]
    if path is None and payload == "-":
        payload = _decoded(sys.stdin.buffer.read())
    more = [*parameters, *(["echo"] if has_echo else [])]
    if revision is not None:
        more.append(f"if={revision}")
    with connected(app, at, parameters) as places:
        from rtkit.property.blocks import as_bytes, blocks_of
        from rtkit.property.codes import PropertyError
        from rtkit.property.limits import LIMITS
        from rtkit.tree.property_connections import (
            asked,
            bound_of,
            check_outcome,
            ended,
            printed_error,
        )

        until = time.monotonic() + app.timeout_s
        place, end = places.find(given[0])
        if is_call:
            _check_action(place, end, app.timeout_s)
        more += bound_of(end, place.parameters, more, app.timeout_s)
        for where, block in blocks_of(as_bytes(payload)):
            target = place.target(joined([*more, *(f"{k}={v}" for k, v in where.items())]))
            sent = block if where else payload
            try:
                value = asked(lambda: end.ask(target, sent), place, end)  # noqa: B023
            except PropertyError as error:
                if not where or error.code != "bad-parameter":
                    raise
                text = f"longer than {LIMITS.text} bytes"  # it takes no blocks
                raise printed_error(place.typed, PropertyError("too-large", text)) from None
        if has_echo:
            value = ended(value, place, end, until)
            terminal.write([shown(value)])
            check_outcome(value, place.typed)


def _check_action(place: PropertyTarget, end: PropertyClient, timeout_s: float) -> None:
    """Refuse to set to nothing what is there and is no action."""
    from rtkit.property.codes import PropertyError
    from rtkit.tree.property_connections import printed_error

    meta = end.ask(f"{place.name}.meta?timeout={timeout_s:g}")
    if not meta.error and "<functional>true<" not in str(meta.payload):
        raise printed_error(place.typed, PropertyError("bad-value", "a value is needed: no action"))


def _content(path: str) -> str | bytes:
    with open(path, "rb") as stream:
        return _decoded(stream.read())


def _decoded(data: bytes) -> str | bytes:
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data
