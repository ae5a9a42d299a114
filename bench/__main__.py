"""Runs all measurements, or those named: ``python -m bench [--page FILE] [slaves/stop …]``.

A name is a group, or a part of one; ``-l`` lists them. On stdout come one line of JSON that tells
where it runs, one per row as it is measured, and then a table; ``--page`` also writes that table
into a page, between its marks, with ``--placement`` as the words for where it ran. The exit status
is 0 also when a target is missed: machines differ, and the table says it. It is 1 when a part
failed, whose rows are missing; the others are measured all the same.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path

from bench import page, placement, scale, table3
from bench.harness import Lines, Missing, Row, table

GROUPS = (
    "commands",
    "launch",
    "many",
    "scale",
    "slaves",
    "managers",
    "hosts",
    "links",
    "spread",
    "ports",
    "openrtm",
    "streams",
    "rates",
    "data",
    "faults",
    "restarts",
    "static",
    "profiles",
    "properties",
    "events",
    "group",
    "search",
    "prompt",
    "planner",
    "vision",
    "secure",
    "web",
    "table3",
    "peers",
)
_NAMED_ONLY = {"peers"}
"""Groups that are measured when they are named only: they need a package index."""
_BUSY = 0.5
"""Load average of a machine that is not quite at rest."""

Part = Callable[[], Lines]


def main(arguments: list[str]) -> int:
    """Run the rows that are named, all when none is."""
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("names", nargs="*", help="groups, or parts of them")
    parser.add_argument("-l", "--list", action="store_true", help="list the parts")
    parser.add_argument("--page", type=Path, help="page that the table is written into")
    parser.add_argument("--placement", default="no processor reserved", help="where it ran")
    options = parser.parse_args(arguments)
    parts = _parts()
    if options.list:
        print("\n".join(parts))
        return 0
    chosen: dict[str, Part] = {}
    for wanted in options.names or [each for each in GROUPS if each not in _NAMED_ONLY]:
        found = {key: part for key, part in parts.items() if f"{key}/".startswith(f"{wanted}/")}
        if not found:
            print(f"nothing is measured as {wanted}; there is {', '.join(parts)}", file=sys.stderr)
            return 2
        chosen.update(found)
    others = os.getloadavg()[0]
    print(placement.as_json(others), flush=True)
    rows, failed = _measured(chosen)
    print("\n" + table(rows))
    print(
        f"\n{placement.machine()}; governor {placement.governor() or 'unknown'};"
        f" load average before {others:.1f}, after {os.getloadavg()[0]:.1f}"
    )
    if options.page is not None:
        page.write(options.page, rows, others, options.placement)
    if others > _BUSY:
        print(
            "The machine was at work before: believe ratios, not times, and none that is too noisy."
        )
    print(table3.pivots(rows) + scale.curves(rows), end="")
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


def _measured(parts: Mapping[str, Part]) -> tuple[list[Row | Missing], list[str]]:
    """Return the rows, and the parts that failed: half an hour of others is not to be lost."""
    rows: list[Row | Missing] = []
    failed = []
    for name, part in parts.items():
        try:
            for row in part():
                print(row.as_json(), flush=True)
                rows.append(row)
        except Exception:
            traceback.print_exc()
            failed.append(name)
    return rows, failed


def _parts() -> dict[str, Part]:
    """Return what each module offers as ``PARTS``, by group and name."""
    modules = {group: importlib.import_module(f"bench.{group}") for group in GROUPS}
    return {
        f"{group}/{name}": part
        for group, module in modules.items()
        for name, part in module.PARTS.items()
    }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
