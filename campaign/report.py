"""What a campaign came to, for people: recovery times of each kind of fault, beside floors."""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from bench.placement import machine
from campaign.fleet import FAULTS, Setback
from campaign.floors import Floor
from campaign.layout import MANAGER, NAMES, SLAVES, WIRES, members
from campaign.schedule import DECK
from campaign.trial import Outcome

_HEAD = ("fault", "count", "median", "p99", "max", "floor", "others' longest pause")
_BY_PROCESS = ("kill a slave", "kill two slaves", "exit")
_BY_MANAGER = ("kill the manager", "kill manager", "kill everything", "kill in", "disk full")
"""How kinds begin after which a manager is started."""


class Conditions(NamedTuple):
    """Where and how a campaign was run."""

    seed: int
    seconds: float
    load: float


def conditions_line(conditions: Conditions) -> str:
    """Return machine, seed and load, in one line."""
    return (
        f"Seed {conditions.seed}, {conditions.seconds:.0f} s, {machine()};"
        f" load average before {conditions.load:.1f}"
    )


def percentile(values: Sequence[float], share: float) -> float:
    """Return the least value that so large a share of all does not exceed."""
    ranked = sorted(values)
    return ranked[max(0, math.ceil(share * len(ranked)) - 1)]


def rows(outcomes: Sequence[Outcome], floors: Sequence[Floor]) -> list[tuple[str, ...]]:
    """Return the cells of the table, its head first."""
    told: list[tuple[str, ...]] = [_HEAD]
    for kind in DECK:
        its = [outcome for outcome in outcomes if outcome.fault.kind == kind]
        if not its:
            continue
        times = [outcome.recovery_s for outcome in its]
        pauses = [outcome.pause_s for outcome in its if outcome.pause_s]
        told.append(
            (
                kind,
                *_metrics(times),
                _floor(kind, floors),
                f"{max(pauses):.3f} s" if pauses else "-",
            )
        )
    return told


def hosts_rows(setbacks: Sequence[Setback]) -> list[tuple[str, ...]]:
    """Return the cells of the table of faults over several hosts, its head first."""
    times = {what: [each.recovery_s for each in setbacks if each.what == what] for what in FAULTS}
    return [_HEAD[:5], *((what, *_metrics(its)) for what, its in times.items() if its)]


def _metrics(times: Sequence[float]) -> tuple[str, ...]:
    figures = (statistics.median(times), percentile(times, 0.99), max(times))
    return (str(len(times)), *(f"{figure:.3f} s" for figure in figures))


def _floor(kind: str, floors: Sequence[Floor]) -> str:
    is_of = (kind.startswith(_BY_PROCESS), kind.startswith(_BY_MANAGER))
    for floor, is_its in zip(floors, is_of, strict=False):
        if is_its:
            return f"{floor.seconds:.3f} s"
    return "-"


def document(outcomes: Sequence[Outcome], floors: Sequence[Floor], conditions: Conditions) -> str:
    """Return the whole report (Markdown)."""
    broken = [f"- {each.fault}: {'; '.join(each.failures)}" for each in outcomes if each.failures]
    measured = "; ".join(f"{each.what}, {each.seconds:.3f} s" for each in floors)
    return _DOCUMENT.format(
        count=len(outcomes),
        conditions=conditions_line(conditions),
        components=len(NAMES),
        inside=len(members(MANAGER)),
        slaves=len(SLAVES),
        wires=len(WIRES),
        table=_table(rows(outcomes, floors)),
        floors=measured,
        verdict="\n".join(["Broken were:", "", *broken]) if broken else "None was broken.",
    )


def hosts_section(setbacks: Sequence[Setback], hosts: int, conditions: Conditions) -> str:
    """Return the section on several hosts (Markdown), without its head."""
    broken = [f"- {each.what} {each.host}: {each.why}" for each in setbacks if each.why]
    return _HOSTS_SECTION.format(
        count=len(setbacks),
        conditions=conditions_line(conditions),
        hosts=hosts,
        table=_table(hosts_rows(setbacks)),
        verdict="\n".join(["Not back were:", "", *broken]) if broken else "It always came back.",
    )


def _table(cells: Sequence[tuple[str, ...]]) -> str:
    lines = ["| " + " | ".join(each) + " |" for each in cells]
    lines.insert(1, "| --- " + "| ---: " * (len(cells[0]) - 1) + "|")
    return "\n".join(lines)


def write(file: Path, text: str) -> None:
    """Write the report, but keep its section on several hosts."""
    _, head, hosts = _read(file)
    file.write_text("\n".join([text, head + hosts]) if head else text, encoding="utf-8")


def write_hosts(file: Path, text: str) -> None:
    """Write the section on several hosts, and keep the rest of the report."""
    file.write_text(f"{_read(file)[0].rstrip()}\n\n{_HOSTS}{text}", encoding="utf-8")


def _read(file: Path) -> tuple[str, str, str]:
    return (file.read_text(encoding="utf-8") if file.exists() else "").partition(_HOSTS)


_HOSTS = "## Over several hosts\n"
_HOSTS_SECTION = """
{count} faults. {conditions}.
The hosts are network namespaces of one machine, each with an sshd of its own.

This host and {hosts} others are linked. Numbers go from here to the first of them and from there to
here, and from each further one to the one before it; each sender and receiver has a process of its
own, and is to be made again on failure. `campaign/fleet.py` has the program.

{table}

Times are from the fault (cut, lossy, slow, stop: from its end, after up to 4 s; power off: from
when the host is on again, with an empty disk) until `rtcheck` finds all as desired, each component
is there once, and numbers come at each receiver. After a kill of a manager its user types
`rtmgr start`; after a power failure `rtmgr start --host` and `rtapply`, with the installation of
rtkit there. {verdict}
"""
_DOCUMENT = """# What comes of {count} faults

Written by `make campaign`, not by hand. `make campaign SEED=…` does the same to the same again.

{conditions}.

{components} components at 50 Hz, {inside} in the manager and the rest in {slaves} slaves; {wires}
connections with blocking buffers, which carry numbered values, and each calls a service of the
next one. An object is served beside them. Each component is to be made again
on failure (`rtkit.restart=on-failure`), and when a callback takes longer than 1 s
(`rtkit.health.stuck=restart`). `campaign/` has the program.

{table}

Times are from the fault (what is stopped: from when it goes on) until all components are Active and
connected, those that died live again, and values come over every connection. A restart waits
0.1 s, and twice as long each further time within 30 s; a callback that hangs has its second, and
is found within the next; slow starts and activations sleep as long as they were told to. The last
column is the longest time that a component which the fault did not concern was without a cycle.

Floors, measured beside the same system at work: {floors}.

Promises, looked at after each fault: it is over within the wait of the law of restarts and 10 s;
then a plan has nothing to do; components were made again just once if the
fault ended them, else not (by two faults on top of each other, twice at most); a value that is set
while the manager is killed, or its disk is full, is the same after everything was killed, and the
new one if that was acknowledged; all others went on in their process; no value of a connection
whose ends both live on was lost or came twice; what raises, hangs or prints in a getter, a setter,
an action or a service keeps nobody else from an answer. {verdict}
"""
