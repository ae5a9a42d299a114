"""Runs all measurements, or those named: ``python -m bench [commands slaves/stop …]``.

A name is a group, or a part of one; ``-l`` lists them. One line of JSON per row as it is measured,
then a table, on stdout. The exit status is 0 also when a target is missed: machines differ, and
the table says it.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable

from bench import table3
from bench.harness import Lines, Missing, Row, table

GROUPS = (
    "commands",
    "launch",
    "many",
    "slaves",
    "ports",
    "rates",
    "data",
    "faults",
    "restarts",
    "static",
    "profiles",
    "properties",
    "prompt",
    "planner",
    "table3",
)
_BUSY = 0.5
"""Load average of a machine that is not quite at rest."""

Part = Callable[[], Lines]


def main(names: list[str]) -> int:
    """Run these, all when none is named."""
    parts = _parts()
    if names == ["-l"]:
        print("\n".join(parts))
        return 0
    chosen: dict[str, Part] = {}
    for wanted in names or GROUPS:
        found = {key: part for key, part in parts.items() if f"{key}/".startswith(f"{wanted}/")}
        if not found:
            print(f"nothing is measured as {wanted}; there is {', '.join(parts)}", file=sys.stderr)
            return 2
        chosen.update(found)
    rows: list[Row | Missing] = []
    others = os.getloadavg()[0]
    for part in chosen.values():
        for row in part():
            print(row.as_json(), flush=True)
            rows.append(row)
    print("\n" + table(rows))
    if others > _BUSY:
        print(
            f"\nThe machine was at work before (load {others:.1f}, {os.cpu_count()} processors):"
            " believe ratios, not times."
        )
    print(table3.pivot(rows), end="")
    return 0


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
