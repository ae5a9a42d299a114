"""Fail when a test was skipped for a reason that `EXPECTED` does not name; else say nothing."""

from __future__ import annotations

import re
import sys
from xml.etree import ElementTree

EXPECTED: tuple[str, ...] = ("mount namespace", "strace may not look into other processes")
"""Patterns of reasons that are no cause for alarm on the machine that checks changes."""


def main() -> int:
    """Read the reports whose paths are the arguments."""
    unexpected = 0
    cases = (case for name in sys.argv[1:] for case in ElementTree.parse(name).iter("testcase"))
    for case in cases:
        for skipped in case.iter("skipped"):
            reason = skipped.get("message", "")
            if not any(re.search(pattern, reason) for pattern in EXPECTED):
                unexpected += 1
                name = f"{case.get('classname')}::{case.get('name')}"
                print(f"unexpected skip: {name}: {reason}", file=sys.stderr)
    return 1 if unexpected else 0


if __name__ == "__main__":
    sys.exit(main())
