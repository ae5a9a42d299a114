"""Fail when a test was skipped for a reason that `EXPECTED` does not name; else say nothing."""

from __future__ import annotations

import re
import sys
from xml.etree import ElementTree

EXPECTED: tuple[str, ...] = ()
"""Patterns of reasons that are no cause for alarm on the machine that checks changes."""


def main() -> int:
    """Read the report whose path is the first argument."""
    unexpected = 0
    for case in ElementTree.parse(sys.argv[1]).iter("testcase"):
        for skipped in case.iter("skipped"):
            reason = skipped.get("message", "")
            if not any(re.search(pattern, reason) for pattern in EXPECTED):
                unexpected += 1
                name = f"{case.get('classname')}::{case.get('name')}"
                print(f"unexpected skip: {name}: {reason}", file=sys.stderr)
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
