"""Break a system at random and check that it comes back: ``python -m campaign``.

It prints its seed; the same seed makes the same faults happen to the same processes. The exit
status is 1 when a promise was broken.
"""

from __future__ import annotations

import argparse
import os
import secrets
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from bench.harness import columns
from campaign.arena import Arena, arena
from campaign.floors import floors
from campaign.law import Law
from campaign.report import Conditions, conditions_line, document, rows
from campaign.schedule import Fault, schedule
from campaign.trial import Outcome, tried

FAULTS = 200


def main(arguments: list[str]) -> int:
    """Run a campaign."""
    parser = argparse.ArgumentParser(prog="python -m campaign", description=__doc__)
    parser.add_argument("--seed", type=int, help="which faults (drawn if not given)")
    parser.add_argument("--faults", type=int, default=FAULTS, help="how many (%(default)s)")
    parser.add_argument("--report", type=Path, help="file to write the table to, beside floors")
    parser.add_argument(
        "--patience", type=float, default=1.0, help="times that it may take what is promised"
    )
    options = parser.parse_args(arguments)
    seed = secrets.randbelow(1_000_000) if options.seed is None else options.seed
    print(f"seed {seed}, {options.faults} faults", flush=True)
    load, began = os.getloadavg()[0], time.monotonic()
    with arena() as site:
        outcomes = list(_all(site, schedule(seed, options.faults), options.patience))
        measured = floors() if options.report else ()
    conditions = Conditions(seed, time.monotonic() - began, load)
    failed = sum(bool(outcome.failures) for outcome in outcomes)
    print("\n" + columns(rows(outcomes, measured)))
    print(f"\n{conditions_line(conditions)}")
    print(f"{len(outcomes)} faults, {failed} with a broken promise")
    if options.report is not None:
        options.report.write_text(document(outcomes, measured, conditions), encoding="utf-8")
    return 1 if failed else 0


def _all(site: Arena, faults: list[Fault], patience: float) -> Iterator[Outcome]:
    """Have the faults happen until the system does not come back."""
    law = Law()
    for number, fault in enumerate(faults, start=1):
        outcome = tried(site, law, fault, patience)
        print(f"{number:3} {outcome.recovery_s:6.3f} s  {fault}", flush=True)
        for why in outcome.failures:
            print(f"    FAILED: {why}", flush=True)
        yield outcome
        if not outcome.is_back:
            print(site.log(), file=sys.stderr)
            return


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
