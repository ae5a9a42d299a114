"""Tells how near rtkit is to each kind of floor: ``python -m bench.floors``.

Reads the table of figures in ``docs/performance.md`` and writes, into ``docs/floors.md`` between
the marks of each kind, how many rows have such a floor, and their ratios. Why a floor cannot be
beaten, and where the rest goes, the page says in words.
"""

from __future__ import annotations

import re
import statistics
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from bench import page

KINDS = {
    "command": r"python -c: |as many bare Python processes that import",
    "ssh": r"(a|one|as many) (bare )?ssh|the same wheels|the wheels",
    "fork": r"fork of a Python|resting forks|TERM to as many resting forks|kill of a bare Python",
    "loop": r"the same components made by a plain loop|a method that calls",
    "manager": r".*the two zenoh sessions of a manager",
    "itself": r"rtls$|the same (command|for|in|of|over|at|to|pairs|page)|ten managers|start of"
    r"|native (components|ports)|a native component"
    r"|creation of the same|one processor|a page without|Starlette|the time that the search",
    "socket": r"a bare SOCK_SEQPACKET|a bare socket|a loop that sends|a client that writes",
    "memory": r"iceoryx2",
    "zenoh": r"bare zenoh",
    "clock": r"a (bare )?loop that sleeps",
    "parser": r"lxml: |json: |bench\.profiles: ",
    "dictionary": r"a dictionary of",
    "storing": r"the writer of the mcap package|write\(\) of",
    "model": r"the model's own work|carrying it out|a loop that only|OpenCV|a bare"
    r"|the method called",
    "none": r"nothing:",
    "promise": r"what was sent|all are to come|after which",
}
"""Expression by which the words for a floor begin, by the kind of the floor."""
_CELLS = 6


class Figure(NamedTuple):
    """One row of the table of figures that was measured."""

    what: str
    figure: str
    floor: str
    ratio: float
    floor_is: str


def figures(text: str) -> Iterator[Figure]:
    """Yield the measured rows of the table in a page."""
    table = text.partition(page.BEGIN)[2].partition(page.END)[0]
    for line in table.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split(" | ")]
        ratio = re.match(r"[0-9.]+", cells[3]) if len(cells) == _CELLS else None
        if ratio is not None:
            yield Figure(cells[0], cells[1], cells[2], float(ratio[0]), cells[5])


def kind_of(floor_is: str) -> str:
    """Return the kind of a floor by the words for it; "" for one of no kind."""
    return next((kind for kind, words in KINDS.items() if re.match(words, floor_is)), "")


def section(found: list[Figure]) -> str:
    """Return how many rows there are, and the ratios of the nearest and the farthest."""
    if not found:
        return "No row of the last run has this floor.\n"
    found = sorted(found, key=lambda each: each.ratio)
    ratios = [each.ratio for each in found]
    shown = {each.what: each for each in (found[0], *found[-2:])}
    rows = [
        f"| {each.what} | {each.figure} | {each.floor} | {each.ratio:.2f} x |"
        for each in shown.values()
    ]
    spread = f"{ratios[0]:.2f} to {ratios[-1]:.2f} times the floor"
    middle = f"median {statistics.median(ratios):.2f}. The nearest and the farthest:"
    told = f"{len(found)} rows: {spread}, {middle}" if len(found) > 1 else "One row:"
    head = "| measured | figure | floor | ratio |\n| --- | ---: | ---: | ---: |"
    return "\n".join((told, "", head, *rows, ""))


def main() -> int:
    """Write the sections anew."""
    source, target = Path("docs/performance.md"), Path("docs/floors.md")
    text = source.read_text(encoding="utf-8")
    known = list(figures(text))
    for kind in KINDS:
        found = [each for each in known if kind_of(each.floor_is) == kind]
        page.put(target, f"floor {kind}", section(found))
    day = re.search(r"^Measured on .*", text, re.MULTILINE)
    page.put(target, "floors", f"{day[0] if day else ''}\n")
    for each in known:
        if not kind_of(each.floor_is):
            print(f"no kind of floor in bench/floors.py: {each.floor_is}", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
