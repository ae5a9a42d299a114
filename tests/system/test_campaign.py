"""A short campaign: each kind of fault once, on a system of twenty components at work."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from campaign.schedule import DECK

ROOT = Path(__file__).parents[2]


@pytest.mark.timeout(300)
def test_every_kind_of_fault(shell: Any) -> None:
    """The same faults each time a change is checked, others each time at the desk."""
    seed = ["--seed", "1"] if os.environ.get("CI") else []
    done = subprocess.run(
        [sys.executable, "-m", "campaign", "--faults", str(len(DECK)), "--patience", "3", *seed],
        cwd=ROOT,
        env=shell.environment,
        capture_output=True,
        text=True,
        timeout=280.0,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"{len(DECK)} faults, 0 with a broken promise" in done.stdout
