"""``rtbug``: runs of Bug navigation, an example of one system in many deployments."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments, check_at_most_one, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    COUNT,
    NumberChoice,
    arguments,
    flag,
    json_flag,
    option,
    several,
    together,
)
from rtkit.errors import Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.api.tree import Tree

_RUN, _LIST, _WHERE = _WORDS = ("run", "list", "where")
_MOST = 100
"""How many managers of this command may run at once."""
_RIGHT, _WRONG, _UNREACHABLE, _GAVE_UP = 0, 1, 7, 8
_WATCHED_SPEEDUP = 10.0
SEED = click.IntRange(min=0, max=2**31 - 1)


class Asked(NamedTuple):
    """Says which runs are meant, and how they are done."""

    files: tuple[str, ...] = several("--environments FILE", "Worlds of this file, too.")
    own: tuple[str, ...] = several("--variants FILE", "Variants of this file, too.")
    is_all: bool = flag("--all", "The 42 runs: seven variants, laser and ir, three worlds.")
    worlds: tuple[str, ...] = several("--world NAME", "In this world.")
    variants: tuple[str, ...] = several("--variant NAME", "With this variant.")
    sensors: tuple[str, ...] = several("--sensors NAME", "With laser, ir, laser+ir or bumper.")
    directions: tuple[str, ...] = several(
        "--direction SIDE", "Turning left (default) or right at a wall."
    )
    seed: int = option("--seed N", "Seed of the noise (default 0).", SEED, default=0)
    noise: float = option(
        "--noise METRES",
        "Sigma of ranges and odometry (default 0).",
        NumberChoice(min=0, max=1),
        default=0.0,
    )
    speedup: float | None = option(
        "--speedup X",
        "X times as fast as real time (default 0: no waiting; 10 with --watch).",
        NumberChoice(min=0),
    )
    step_limit: int | None = option(
        "--step-limit N", "Give a run up after N control steps (default 20000).", COUNT
    )
    out: str | None = option("-o --out DIR", "Write tables, trajectories and pictures there.")


@command(
    "rtbug",
    examples=(
        (
            "rtbug run --world one-box --variant bug2 --sensors laser --out runs",
            "One run, and its files.",
        ),
        ("rtbug run --all --out runs", "Seven variants, two sets of sensors, three worlds."),
        ("rtbug run --world visited --variant alg1 --sensors laser --watch", "Watch one."),
        ("rtbug list", "Variants, sensors and worlds."),
    ),
    json=("bug-run", "bug-word"),
    arguments=("words",),
    words=_WORDS,
    values={
        "--environments": "file",
        "--variants": "file",
        "--world": "bug-world",
        "--variant": "bug-variant",
        "--sensors": "bug-sensors",
        "--direction": "bug-side",
    },
    statuses={"1": "A run gave a wrong answer, or counted a collision, or could not be done."},
)
def main(
    app: App,
    asked: Asked = together(Asked),
    is_watched: bool = flag("--watch", "Draw each run in the terminal while it goes on."),
    is_quiet: bool = flag("-q --quiet", "Print only what went wrong."),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments("run|list|where"),
) -> int:
    r"""Run Bug navigation, an example of one system in many deployments.

    A robot finds its way among obstacles that it does not know, or finds that there is none.

    \b
    rtbug run    deploy and run each combination of what is named, to its end
    rtbug list   variants, sensors and worlds that there are, and which --all runs;
                 with -v where a variant was published
    rtbug where  the folder of the example: components, profiles, README.md

    A run is a deployment of system.yaml at a manager of this command, which ends with it: every
    component is in a slave of its own. The next run is the cheapest plan from the one before; -v
    shows its steps. Its end is right where the robot reaches a goal that can be reached, or reports
    that it cannot be. While it goes on, other commands show it: rtls, rttop, rtget.

    \b
    DIR/WORLD/VARIANT-SENSORS-SIDE/  trajectory.csv, result.json, trajectory.svg
    DIR/table.csv, table.md, DIR/WORLD.svg   all runs of this call

    The same seed gives the same files. With --exit-detail a single run ends with 0 reached, 7
    unreachable, 8 given up, whatever the world says.
    """
    if not words or words[0] not in _WORDS:
        raise WrongArguments(no_such("word", words[0], _WORDS) if words else "No word specified.")
    check_at_most_one(words, "word")
    running = _running()
    if words[0] == _WHERE:
        terminal.write([str(running.FOLDER)])
        return 0
    try:
        worlds = running.read_worlds(asked.files)
        known = running.read_variants(asked.own)
    except ImportError as error:  # numpy is missing; the text says so
        raise Refused(str(error)) from error
    if words[0] == _LIST:
        return _list(app, running, worlds, known, is_json)
    choices = _choices(running, worlds, known, asked)
    out = None if asked.out is None else Path(asked.out)
    if out is not None:
        running.check_writable(out)
    speedup = asked.speedup
    if speedup is None:
        speedup = _WATCHED_SPEEDUP if is_watched else 0.0
    look = _watcher(app, worlds) if is_watched else None  # refused before a manager is started
    with _manager(app) as (tree, prefix):
        options = running.Options(
            asked.files, speedup, asked.noise, asked.step_limit or running.STEP_LIMIT, prefix
        )
        runner = running.Runner(tree, worlds, known, options, app.verbose, look)
        records = _run(app, running, runner, choices, out, is_json=is_json, is_quiet=is_quiet)
    if out is not None:
        running.write_tables(out, records)
    if app.has_exit_detail and len(records) == 1:
        details = {"reached": _RIGHT, "unreachable": _UNREACHABLE}
        return details.get(records[0].status, _GAVE_UP)
    return _RIGHT if all(record.is_right for record in records) else _WRONG


def _running() -> Any:
    """Import the example, which is no part of this package."""
    from rtkit.resources import resource

    folder = resource("examples")
    if folder not in sys.path:
        sys.path.insert(0, folder)
    return import_module("bug.running")


def _choices(running: Any, worlds: Any, known: Any, asked: Asked) -> list[Any]:
    """Return the runs that are meant.

    Raises:
        UsageProblem: A word is none of those that there are, or nothing says what to run.
    """
    names = {
        "world": (asked.worlds, tuple(worlds)),
        "variant": (asked.variants, tuple(known)),
        "sensors": (asked.sensors, running.SENSORS),
        "direction": (asked.directions or ("left",), running.DIRECTIONS),
    }
    for what, (typed, there) in names.items():
        for word in typed:
            if word not in there:
                raise UsageProblem(f"--{what}: {no_such(what, word, there)}")
    of_paper = running.PAPER if asked.is_all else ((), (), ())
    wanted = [asked.worlds or of_paper[0], asked.variants or of_paper[1]]
    wanted.append(asked.sensors or of_paper[2])
    for what, found in zip(("--world", "--variant", "--sensors"), wanted, strict=True):
        if not found:
            raise UsageProblem(f"no {what} given: name one, or --all")
    return list(running.combinations(*wanted, names["direction"][0], asked.seed))


def _run(
    app: App,
    running: Any,
    runner: Any,
    choices: Sequence[Any],
    out: Path | None,
    *,
    is_json: bool,
    is_quiet: bool,
) -> list[Any]:
    """Do all runs, and write what came of each."""
    import json

    from rtkit.cli.shared.progress import counted, metered

    records: list[Any] = []
    try:
        with metered(app, "runs", is_writing=True) as show:
            for number, choice in enumerate(choices):
                counted(show)(number, len(choices))
                record = runner.run(choice)
                records.append(record)
                if out is not None:
                    running.write_run(out, record)
                if is_json:
                    terminal.write_now([json.dumps(running.result_of(record))])
                elif not is_quiet or not record.is_right:
                    head = f"[{number + 1}/{len(choices)}] " if len(choices) > 1 else ""
                    terminal.write_now([head + running.line_of(record)])
    except KeyboardInterrupt:
        if len(choices) > 1 and out is not None:
            app.fail(f"interrupted: {len(records)} of {len(choices)} runs are complete in {out}")
        raise
    right = sum(record.is_right for record in records)
    if len(choices) > 1 and not is_json and not is_quiet:
        terminal.write_now([f"{right} of {len(records)} right"])
    return records


def _list(app: App, running: Any, worlds: Any, known: Any, is_json: bool) -> int:
    from rtkit.cli.shared import json_records

    of_all = {word for words in running.PAPER for word in words}
    found = [
        ("variant", name, each.assembly.summary or each.assembly.source, each.assembly.source)
        for name, each in known.items()
    ]
    found += [("sensors", name, about, "") for name, about in running.SENSORS.items()]
    found += [("world", name, each.note, "") for name, each in worlds.items()]
    if is_json:
        keys = ("kind", "name", "about", "source")
        records = (
            {**dict(zip(keys, each, strict=True)), "is_of_all": each[1] in of_all} for each in found
        )
        terminal.write(json_records.lines("bug-word", records))
        return 0
    shown = [
        (kind, name, "--all" if name in of_all else "", about)
        + ((source,) if app.is_verbose else ())
        for kind, name, about, source in found
    ]
    terminal.write(terminal.table([tuple(map(terminal.printable, each)) for each in shown]))
    return 0


def _watcher(app: App, worlds: Any) -> Any:
    """Return what draws a run, where stdout is a terminal.

    Raises:
        Refused: It is none.
    """
    if not terminal.is_terminal() or os.environ.get("TERM", "dumb") == "dumb":
        raise Refused("--watch draws in a terminal, and stdout is none")
    return import_module("bug.watching").Watcher(
        worlds, terminal.write_now, has_colour=terminal.has_colour()
    )


@contextmanager
def _manager(app: App) -> Iterator[tuple[Tree, str]]:
    """Start a manager that finds the components; yield the connection, and a prefix for names.

    It ends with this command, also when that is killed.

    Raises:
        Refused: It cannot be started.
    """
    from rtkit.api.connect import connect
    from rtkit.container.orphans import began_at
    from rtkit.errors import Unreachable
    from rtkit.link.running import managers
    from rtkit.manager.child_process import ENDS_WITH
    from rtkit.manager.launch import start
    from rtkit.settings.configuration import CommandLineSettings

    folders = [str(_running().FOLDER), os.environ.get("RTKIT_MODULE_PATH", "")]
    own = {
        "RTKIT_MODULE_PATH": os.pathsep.join(filter(None, folders)),
        "RTKIT_PORT": "none",
        ENDS_WITH: f"{os.getpid()}:{began_at(os.getpid())}",
    }
    os.environ.update(own)
    is_alone = not managers()
    for number in range(1, _MOST):
        name = "bug" if number == 1 else f"bug{number}"
        if name in managers():
            continue
        os.environ["RTKIT_MANAGER"] = name
        try:
            start(name, CommandLineSettings(""), app.timeout_s)
        except Refused:
            if name in managers():
                continue  # another one was quicker
            raise
        break
    with connect(name, app.timeout_s, notify=app.verbose) as tree:
        try:
            yield tree, "" if is_alone and number == 1 else f"{name}."
        finally:
            try:
                tree.stop_manager()
            except Unreachable:
                if name in managers():
                    raise
