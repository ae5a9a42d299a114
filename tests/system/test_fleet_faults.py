"""Random faults of a fleet: links, hosts, managers and their processes, and what comes back."""

from __future__ import annotations

import os
import random

import pytest
from fleetkit import NEEDS_HOSTS
from forked import Commands

from campaign.fleet import FAULTS, fleet

pytestmark = [NEEDS_HOSTS, pytest.mark.timeout(280)]


def test_a_fleet_comes_back_whole_after_any_fault(commands: Commands) -> None:
    """Each kind once; `python -m campaign --hosts 2` has two hundred of them."""
    seed = 1 if os.environ.get("CI") else random.SystemRandom().randrange(1_000_000)
    print(f"seed {seed}")
    with fleet(2, seed, commands) as site:
        for what, host in site.faults(len(FAULTS)):
            setback = site.tried(what, host)
            print(f"{what} {host} {setback.recovery_s:.1f} s", flush=True)
            assert not setback.why
