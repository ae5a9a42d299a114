"""``rtlog``: record what comes out of ports, and play it again."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.choice import NumberChoice, lasting
from rtkit.cli.shared.command import command
from rtkit.errors import Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.recording.entries import RecordingSelection

FORMATS = ("mcap", "text")
FORMS_OUT = ("text", "json", "csv")
_NS = 1_000_000_000


@command(
    "rtlog",
    examples=(
        ("rtlog -f run.mcap Robot0.rtc:pose", "Record every pose until Ctrl-C."),
        ("rtlog -d -f run.mcap", "What is in the recording."),
        ("rtlog --export csv -f run.mcap", "Its values for a spreadsheet, one field a line."),
        ("rtlog -p -r 0.5 -f run.mcap Map0.rtc:pose", "Play it at half its speed."),
    ),
    json=("recording", "value"),
    arguments=("out-port",),
)
@click.option(
    "-f",
    "--filename",
    metavar="FILE",
    help="The recording; - is stdout (default when recording: rtlog_SECONDS.mcap).",
)
@click.option("-p", "--play", "is_play", is_flag=True, help="Play the recording into in ports.")
@click.option(
    "-d", "--display-info", "--info", "is_info", is_flag=True, help="Tell what is in it, and end."
)
@click.option(
    "--export",
    "exported",
    type=click.Choice(FORMS_OUT),
    help="Write its values to stdout: lines of a text log, JSON Lines, or CSV.",
)
@click.option(
    "-l",
    "--logger",
    "form",
    metavar="FORMAT",
    help="mcap (default) or text; when playing the file's name tells.",
)
@click.option("-s", "--start", metavar="TIME|INDEX", help="Play, or export, from here on.")
@click.option("-e", "--end", metavar="TIME|INDEX", help="Record, play or export up to here.")
@click.option("-i", "--index", "is_by_index", is_flag=True, help="-s and -e are indices.")
@lasting("Stop after this time; -e then has no effect.")
@click.option(
    "-r",
    "--rate",
    type=NumberChoice(min=0.0, min_open=True),
    metavar="FACTOR",
    help="Play so many times as fast; with -n so many entries each cycle (default 1).",
)
@click.option(
    "-n", "--ignore-times", "is_untimed", is_flag=True, help="Play at a steady pace instead."
)
@click.option(
    "-a", "--absolute-times", "is_absolute", is_flag=True, help="Play time stamps as recorded."
)
@click.option(
    "-x",
    "--exec-rate",
    type=NumberChoice(min=0.0, min_open=True),
    metavar="HZ",
    help="Cycles a second with -n (default 100).",
)
@click.option("--path", "folders", multiple=True, metavar="DIR", help="Look for modules here too.")
@click.option(
    "-m",
    "--mod",
    "modules",
    multiple=True,
    metavar="MODULE",
    help="Import data types (repeatable).",
)
@click.option(
    "--lossless", is_flag=True, help="Lose no value; the component that writes waits instead."
)
@click.option("--json", "is_json", is_flag=True, help="With -d: as JSON.")
@click.argument("ports", nargs=-1, metavar="PORT[.STREAM]...")
def main(
    app: App,
    ports: tuple[str, ...],
    filename: str | None,
    is_play: bool,
    is_info: bool,
    exported: str | None,
    form: str | None,
    start: str | None,
    end: str | None,
    is_by_index: bool,
    duration_s: float | None,
    rate: float | None,
    is_untimed: bool,
    is_absolute: bool,
    exec_rate: float | None,
    folders: tuple[str, ...],
    modules: tuple[str, ...],
    lossless: bool,
    is_json: bool,
) -> None:
    r"""Record what comes out of ports, and play it again into others.

    \b
    rtlog -f run.mcap Robot0.rtc:pose Laser0.rtc:scan     record, until Ctrl-C
    rtlog -d -f run.mcap                                  what is in it
    rtlog -p -f run.mcap Map0.rtc:pose                    play it
    rtlog --export csv -f run.mcap                        its values, one field a line

    A recording is an MCAP file that other viewers open too: values in CDR, with their data types.
    What was recorded up to half a second ago can be read even after the recorder was killed.
    On a busy host values may be lost, large ones first; how many is told at the end. With
    --lossless none is: who writes waits. More by rtkit help connectors.

    Streams are named after their ports, Robot0_pose, or as a port is followed by .STREAM. A port
    that is played into takes the stream of the name given; without one the first stream of its
    data type that no other port has taken. Times are seconds since 1970; stamps are shifted to
    the present unless -a says otherwise.
    """
    from rtkit.cli.data import player, recorder
    from rtkit.probe.types import import_modules

    if sum((is_play, is_info, exported is not None)) > 1:
        raise UsageProblem("only one of -p, -d and --export can be used")
    if (is_play or is_info or exported) and filename is None:
        raise Malformed("No log file specified.")
    if form is not None:
        _check_form(form)
    chosen = form or ("text" if str(filename).endswith(".txt") else "mcap")
    if (is_info or exported) and chosen == "text":
        feature = "info" if is_info else "export"
        raise Refused(f'Log type "text" does not support feature "{feature}".')
    if is_by_index and start is None and end is None:
        app.fail("warning: -i has no effect without -s or -e")
    import_modules(modules, folders)
    part = _part(start, end, is_by_index, has_duration=duration_s is not None)
    if is_info:
        player.describe(app, str(filename), is_json=is_json)
    elif exported:
        from rtkit.cli.data.export import export

        export(app, str(filename), exported, part)
    elif is_play:
        pace = player.PlaybackPace(
            rate or 1.0, is_untimed, exec_rate or 100.0, is_absolute, duration_s
        )
        player.play(app, str(filename), chosen, ports, part, pace, is_lossless=lossless)
    else:
        _refuse_when_recording(start, is_untimed, rate)
        name = filename or f"rtlog_{int(time.time())}.{'txt' if form == 'text' else 'mcap'}"
        recorder.record(app, name, chosen, ports, part, duration_s, is_lossless=lossless)


def _check_form(form: str) -> None:
    if form == "simpkl":
        raise Malformed("simpkl logs can execute code when they are read: use mcap")
    if form not in FORMATS:
        raise Malformed(f"Invalid logger type: {form} (one of {', '.join(FORMATS)})")


def _refuse_when_recording(start: str | None, is_untimed: bool, rate: float | None) -> None:
    for option, given in (("-s", start is not None), ("-n", is_untimed), ("-r", rate is not None)):
        if given:
            raise UsageProblem(f"{option} is for playing (-p)")


def _part(
    start: str | None, end: str | None, is_by_index: bool, *, has_duration: bool
) -> RecordingSelection:
    from rtkit.recording.entries import RecordingSelection

    return RecordingSelection(
        _place(start, "-s", is_by_index),
        None if has_duration else _place(end, "-e", is_by_index),
        is_by_index,
    )


def _place(text: str | None, option: str, is_by_index: bool) -> int | None:
    """Read an index, or a time in seconds, exactly to the nanosecond."""
    if text is None:
        return None
    whole, dot, decimals = text.partition(".")
    is_number = whole.isascii() and whole.isdigit() and (not dot or decimals.isdigit())
    if not is_number or len(whole) > 12 or (is_by_index and dot):
        kind = "an index" if is_by_index else "a time in seconds"
        raise UsageProblem(f"{option} needs {kind}, not {text}")
    return int(whole) if is_by_index else int(whole) * _NS + int(f"{decimals:0<9}"[:9] or 0)
