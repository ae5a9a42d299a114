"""Give tests that failed a second run by themselves, and say by name which needed it.

The machine that checks changes is shared: a test with a time-out can fail there because something
else had the processors. Such a test is a bug still, so it is told; it is no reason to refuse a
change. More than `FEW` failures, or one that fails again, are.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

FEW = 5
LAST_FAILED = Path(".pytest_cache/v/cache/lastfailed")


def main() -> int:
    """Run what failed last; the arguments are the reports that a whole run leaves."""
    missing = [name for name in sys.argv[1:] if not Path(name).exists()]
    if missing or not LAST_FAILED.exists():
        print("the tests did not come to their end", file=sys.stderr)
        return 1
    failed = sorted(json.loads(LAST_FAILED.read_text(encoding="utf-8")))
    if not 0 < len(failed) <= FEW:
        print(f"{len(failed)} tests failed: no second run", file=sys.stderr)
        return 1
    print(f"== again, alone: {len(failed)}", flush=True)
    command = [sys.executable, "-m", "pytest", "--doctest-modules", *failed]
    status = subprocess.run(command, check=False).returncode
    for name in failed:
        print(f"FAILED FIRST{'' if status else ', passed alone'}: {name}", file=sys.stderr)
    return status


if __name__ == "__main__":
    sys.exit(main())
