"""``rtlog``: record what comes out of ports, and play it again."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import POSITIVE, arguments, flag, json_flag, lasting, option, several
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
        ("rtlog -a -f run.mcap", "Record all out ports, also those that come later."),
        ("rtlog -f run.mcap 'Robot*:pose'", "Record this port of all such components."),
        ("rtlog -d -f run.mcap", "What is in the recording."),
        ("rtlog --export csv -f run.mcap", "Its values for a spreadsheet, one field a line."),
        ("rtlog -p -r 0.5 -f run.mcap Map0.rtc:pose", "Play it at half its speed."),
    ),
    json=("recording", "value"),
    arguments=("out-port",),
)
def main(
    app: App,
    filename: str | None = option(
        "-f --filename FILE",
        "The recording; - is stdout (default when recording: rtlog_SECONDS.mcap).",
    ),
    is_play: bool = flag("-p --play", "Play the recording into in ports."),
    is_info: bool = flag("-d --display-info --info", "Tell what is in it, and end."),
    exported: str | None = option(
        "--export",
        "Write its values to stdout: lines of a text log, JSON Lines, or CSV.",
        click.Choice(FORMS_OUT),
    ),
    form: str | None = option(
        "-l --logger FORMAT", "mcap (default) or text; when playing the file's name tells."
    ),
    start: str | None = option("-s --start TIME|INDEX", "Play, or export, from here on."),
    end: str | None = option("-e --end TIME|INDEX", "Record, play or export up to here."),
    is_by_index: bool = flag("-i --index", "-s and -e are indices."),
    duration_s: float | None = lasting("Stop after this time; -e then has no effect."),
    rate: float | None = option(
        "-r --rate FACTOR",
        "Play so many times as fast; with -n so many entries each cycle (default 1).",
        POSITIVE,
    ),
    is_untimed: bool = flag("-n --ignore-times", "Play at a steady pace instead."),
    is_all: bool = flag(
        "-a --all --absolute-times",
        "Record all out ports, also those that come; with -p: play time stamps as recorded.",
    ),
    exec_rate: float | None = option(
        "-x --exec-rate HZ", "Cycles a second with -n (default 100).", POSITIVE
    ),
    folders: tuple[str, ...] = several("--path DIR", "Look for modules here too."),
    modules: tuple[str, ...] = several("-m --mod MODULE", "Import data types (repeatable)."),
    lossless: bool = flag("--lossless", "Lose no value; the component that writes waits instead."),
    is_json: bool = json_flag("With -d: as JSON."),
    ports: tuple[str, ...] = arguments("PORT[.STREAM]..."),
) -> None:
    r"""Record what comes out of ports, and play it again into others.

    \b
    rtlog -f run.mcap Robot0.rtc:pose Laser0.rtc:scan     record, until Ctrl-C
    rtlog -f run.mcap -a                                  record every out port
    rtlog -d -f run.mcap                                  what is in it
    rtlog -p -f run.mcap Map0.rtc:pose                    play it
    rtlog --export csv -f run.mcap                        its values, one field a line

    A port may be a pattern, 'Sensor*:out': * stands for any text, ? for any character. Without a
    slash it is one of names anywhere below the working directory. Ports that match and come later,
    or come back with their components, are recorded from then on. Ports may be of several hosts;
    beside a pattern all are at one manager.

    A recording is an MCAP file that other viewers open too: values in CDR, with their data types.
    Values that were recorded up to half a second ago can be read even after the recorder was
    killed. On a busy host values may be lost, large ones first; how many is told at the end. With
    --lossless none is: who writes waits. More by rtkit help connectors.

    Streams are named after their ports, Robot0_pose, or as a port is followed by .STREAM. A port
    that is played into takes the stream of the name given; without one the first stream of its
    data type that no other port has taken. Times are seconds since 1970; stamps are shifted to
    the present unless -a says otherwise.
    """
    from rtkit.cli.data import player, recorder
    from rtkit.probe.known_types import import_modules

    if sum((is_play, is_info, exported is not None)) > 1:
        raise UsageProblem("only one of -p, -d and --export can be used")
    if (is_play or is_info or exported) and filename is None:
        raise Malformed("No log file specified.")
    if exported and ports:
        raise UsageProblem("--export takes no ports: it writes all streams, each by its name")
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
        pace = player.PlaybackPace(rate or 1.0, is_untimed, exec_rate or 100.0, is_all, duration_s)
        player.play(app, str(filename), chosen, ports, part, pace, is_lossless=lossless)
    else:
        _refuse_when_recording(start, is_untimed, rate)
        name = filename or f"rtlog_{int(time.time())}.{'txt' if form == 'text' else 'mcap'}"
        ports = (*ports, "*:*") if is_all else ports
        recorder.record(app, name, chosen, ports, part, duration_s, is_lossless=lossless)


def _check_form(form: str) -> None:
    if form == "simpkl":
        raise Malformed("simpkl logs can execute code when they are read: use mcap")
    if form not in FORMATS:
        raise Malformed(f"Invalid logger type: {form} (one of {', '.join(FORMATS)})")


def _refuse_when_recording(start: str | None, is_untimed: bool, rate: float | None) -> None:
    for letter, given in (("-s", start is not None), ("-n", is_untimed), ("-r", rate is not None)):
        if given:
            raise UsageProblem(f"{letter} is for playing (-p)")


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
