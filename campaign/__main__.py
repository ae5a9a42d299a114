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
from campaign import fleet
from campaign.arena import Arena, arena
from campaign.fleet import Setback
from campaign.floors import floors
from campaign.law import Law
from campaign.report import (
    Conditions,
    conditions_line,
    document,
    hosts_rows,
    hosts_section,
    rows,
    write,
    write_hosts,
)
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
    parser.add_argument(
        "--hosts",
        type=int,
        default=0,
        help="break a system over so many further hosts instead (root, and openssh-server)",
    )
    options = parser.parse_args(arguments)
    seed = secrets.randbelow(1_000_000) if options.seed is None else options.seed
    if options.hosts and (why := fleet.missing()):
        print(f"no hosts: {why}", file=sys.stderr)
        return 0
    print(f"seed {seed}, {options.faults} faults", flush=True)
    load, began = os.getloadavg()[0], time.monotonic()
    if options.hosts:
        setbacks = list(_of_hosts(options.hosts, seed, options.faults))
        conditions = Conditions(seed, time.monotonic() - began, load)
        failed = sum(bool(each.why) for each in setbacks)
        _tell(hosts_rows(setbacks), conditions, len(setbacks), failed)
        if options.report is not None:
            write_hosts(options.report, hosts_section(setbacks, options.hosts, conditions))
        return 1 if failed else 0
    with arena() as site:
        outcomes = list(_all(site, schedule(seed, options.faults), options.patience))
        measured = floors() if options.report else ()
    conditions = Conditions(seed, time.monotonic() - began, load)
    failed = sum(bool(outcome.failures) for outcome in outcomes)
    _tell(rows(outcomes, measured), conditions, len(outcomes), failed)
    if options.report is not None:
        write(options.report, document(outcomes, measured, conditions))
    return 1 if failed else 0


def _tell(cells: list[tuple[str, ...]], conditions: Conditions, count: int, failed: int) -> None:
    print("\n" + columns(cells))
    print(f"\n{conditions_line(conditions)}")
    print(f"{count} faults, {failed} with a broken promise")


def _of_hosts(hosts: int, seed: int, count: int) -> Iterator[Setback]:
    """Have faults happen to a system over hosts until it does not come back."""
    with fleet.fleet(hosts, seed) as site:
        for number, (what, host) in enumerate(site.faults(count), start=1):
            setback = site.tried(what, host)
            print(f"{number:3} {setback.recovery_s:6.3f} s  {what} {host}", flush=True)
            yield setback
            if setback.why:
                print(f"    FAILED: {setback.why}", flush=True)
                return


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
