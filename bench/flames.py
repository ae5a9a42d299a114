"""Draws where the time of the headline paths goes: ``python -m bench.flames [NAME …]``.

Each path runs for some seconds while py-spy, which the package index gives, samples the processes
that take part. What they do is drawn as a flame graph beside the page, and the innermost frames of
most time are written into the page, between the marks of the path, with day, machine and command.
"""

from __future__ import annotations

import argparse
import datetime
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeAlias

from bench import page, ports, properties
from bench.data import flooding
from bench.flame_svg import Stack, importing, leaves, shares, svg
from bench.harness import command, create, manager, remove, until_listed
from bench.in_slaves.sitecustomize import INTERVAL_S
from bench.placement import machine
from bench.processes import children, parent
from bench.sampling import RATE_HZ, read, sampled, sampled_whole, spy
from rtkit.deployment.actions import ChangeState
from rtkit.rtc.enums import Transition

_PICTURES = "pictures/flames"
_IN_SLAVES = Path(__file__).parent / "in_slaves"
_SECONDS = 8.0
_RUNS = 40
_RECORDINGS = 8
_IMAGES = 1000
_MOST = 8
_COUNT = 20

Samples: TypeAlias = Counter[Stack]


class HeadlinePath(NamedTuple):
    """A path that is sampled: title of its picture, and what samples it by a program."""

    title: str
    sample: Callable[[str, str], Samples]


def _get(program: str, folder: str) -> Samples:
    with properties.by_line() as measure:
        (service,) = children(os.getpid())
        pids = {"client": os.getpid(), "service": service}
        return sampled(program, pids, folder, lambda: _for_a_while(measure))


def _trip(trip: ports.Trip, program: str, folder: str) -> Samples:
    with manager(ports.COMPONENTS) as tree:
        measure = ports.ping(tree, trip, os.path.join(folder, "median"))
        slaves = {process.name: process.pid for process in tree.snapshot().processes}
        pids = {"component that writes": slaves["p"], "component that echoes": slaves["e"]}
        return sampled(program, pids, folder, lambda: _for_a_while(measure))


def _launch(program: str, folder: str) -> Samples:
    os.environ.update(PYTHONPATH=str(_IN_SLAVES), RTKIT_BENCH_STACKS=folder)
    try:
        with manager() as tree:
            texts = [f"ConsoleIn?instance_name=N{n}&manager_name=n{n}" for n in range(_COUNT)]

            def launch() -> None:
                create(tree, texts)
                until_listed(tree, _COUNT)
                remove(tree, _COUNT)

            create(tree, texts[:1])
            slave = next(each.pid for each in tree.snapshot().processes if each.name == "n0")
            pids = {"manager": int(tree.get("manager.pid")), "zygote": parent(slave)}
            remove(tree, 1)
            found = sampled(program, pids, folder, lambda: _for_a_while(launch))
    finally:
        del os.environ["PYTHONPATH"], os.environ["RTKIT_BENCH_STACKS"]
    weight = round(1 / RATE_HZ / INTERVAL_S)
    whole = Counter({stack: count * weight for stack, count in found.items()})
    for file in Path(folder).glob("*.stacks"):
        whole += read(file.read_text(encoding="utf-8"), "slave")
    return whole


def _command(program: str, folder: str) -> Samples:
    with manager():
        found = Samples()
        for _ in range(_RUNS):
            found += sampled_whole(program, [sys.executable, command("rtls")], folder, "rtls")
    return found


def _recording(program: str, folder: str) -> Samples:
    found = Samples()
    with flooding() as flood:
        (source,) = (p.pid for p in flood.tree.snapshot().processes if p.name == "f")
        for number in range(_RECORDINGS):
            file = os.path.join(folder, f"{number}.mcap")
            words = ["--lossless", "-i", "-f", file, "-e", str(_IMAGES), flood.PORT]
            recorder = flood.connected([command("rtlog"), *words], _IMAGES, 1_000_000)
            pids = {"rtlog": recorder.pid, "component that writes": source}
            flow = partial(flood.tree.perform, ChangeState("F", "0", Transition.ACTIVATE))
            found += sampled(program, pids, folder, lambda: (flow(), recorder.communicate()))  # noqa: B023
            flood.end(recorder)
            os.unlink(file)
    return found


PATHS = {
    "get": HeadlinePath("GET of a property as a line", _get),
    "trip": HeadlinePath("Round trip of a small value", partial(_trip, ports.SMALL)),
    "image": HeadlinePath("Round trip of an image of 1 MB", partial(_trip, ports.IMAGE)),
    "launch": HeadlinePath("Launch of a slave with a component", _launch),
    "rtls": HeadlinePath("rtls as a whole process", _command),
    "rtlog": HeadlinePath("rtlog of images of 1 MB", _recording),
}


def _for_a_while(work: Callable[[], object]) -> None:
    until = time.monotonic() + _SECONDS
    while time.monotonic() < until:
        work()


def main(arguments: list[str]) -> int:
    """Draw the paths that are named, all when none is."""
    parser = argparse.ArgumentParser(prog="python -m bench.flames", description=__doc__)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(PATHS)}")
    parser.add_argument("--page", type=Path, default=Path("docs/floors.md"))
    options = parser.parse_args(arguments)
    unknown = [name for name in options.names if name not in PATHS]
    if unknown:
        print(f"there is no path {unknown[0]}; there is {', '.join(PATHS)}", file=sys.stderr)
        return 2
    program = spy()
    for name in options.names or PATHS:
        with tempfile.TemporaryDirectory(prefix="rtb") as folder:
            samples = PATHS[name].sample(program, folder)
        picture = options.page.parent / _PICTURES / f"{name}.svg"
        picture.parent.mkdir(parents=True, exist_ok=True)
        picture.write_text(svg(PATHS[name].title, samples), encoding="utf-8")
        page.put(options.page, f"flame {name}", section(name, samples))
        print(f"{picture}: {sum(samples.values())} samples", flush=True)
    return 0


def section(name: str, samples: Samples) -> str:
    """Return what the page has of a path: its picture, and where most time is spent."""
    day = datetime.datetime.now(tz=datetime.UTC).date().isoformat()
    load = os.getloadavg()[0]
    rows = [
        f"| {share:.0%} | {role} | `{frame.partition(' · ')[0]}` | {_where(frame)} |"
        for role, frame, share in leaves(samples, _MOST)
    ]
    sums = ", ".join(f"{kind} {share:.0%}" for kind, share in shares(samples).items())
    if name == "rtls":
        sums += f"; importing modules {importing(samples):.0%}"
    return "\n".join(
        (
            f"![{PATHS[name].title}]({_PICTURES}/{name}.svg)",
            "",
            f"Drawn on {day} by `make flames PATHS={name}`: {machine()}; load average {load:.1f}."
            f" Of the time: {sums}.",
            "",
            "| share | process | innermost frame | of |",
            "| ---: | --- | --- | --- |",
            *rows,
            "",
        )
    )


def _where(frame: str) -> str:
    return (frame.partition(" · ")[2] or "C code").strip("<>")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
