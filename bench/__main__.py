"""Run all measurements, or the groups named: ``python -m bench [commands ports rates …]``.

One line of JSON per row as it is measured, then a table, on stdout. The exit status is 0 also
when a target is missed: machines differ, and the table says it.
"""

from __future__ import annotations

import importlib
import sys

from bench.harness import table

GROUPS = ("commands", "launch", "ports", "rates", "faults", "static", "profiles")


def main(names: list[str]) -> int:
    """Run these groups, all when none is named."""
    unknown = sorted(set(names) - set(GROUPS))
    if unknown:
        print(f"no such group: {', '.join(unknown)}; there are {', '.join(GROUPS)}")
        return 2
    rows = []
    for name in names or GROUPS:
        for row in importlib.import_module(f"bench.{name}").rows():
            print(row.as_json(), flush=True)
            rows.append(row)
    print("\n" + table(rows))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
