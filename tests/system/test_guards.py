"""Tests of faults fail without what they protect: each is run in a copy of rtkit, twice."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from guards import GUARDS, Guard

ROOT = Path(__file__).parents[2]
NEEDED = ("rtkit", "tests", "profiles", "schemas", "examples", "bench", "campaign", "docs", "man")
BOUND_S = 200
WHEELS = str(ROOT / ".venv" / "cache")
"""Where wheels for hosts are kept, which a copy would have to fetch."""


def copy(folder: Path) -> Path:
    """Copy all that tests need."""
    for name in NEEDED:
        ignored = shutil.ignore_patterns("__pycache__", "*.pyc")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    for name in ("pyproject.toml", "README.md", "CHANGELOG.md", "Makefile"):
        shutil.copy(ROOT / name, folder / name)
    return folder


def run(folder: Path, test: str) -> subprocess.CompletedProcess[str]:
    """Run a test, of a copy of rtkit."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-x",
        "-p",
        "no:cacheprovider",
        "-p",
        "no:xdist",
    ]
    kept = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    return subprocess.run(
        [*command, "--timeout", "60", f"tests/{test}"],
        cwd=folder,
        env={"XDG_CACHE_HOME": WHEELS, **kept, "PYTHONPATH": str(folder), "CI": "true"},
        capture_output=True,
        text=True,
        timeout=BOUND_S,
        check=False,
    )


@pytest.mark.campaign
@pytest.mark.timeout(3 * BOUND_S)
@pytest.mark.parametrize("guard", GUARDS, ids=str)
def test_it_fails_without_its_guard(guard: Guard, tmp_path: Path) -> None:
    folder = copy(tmp_path)
    whole = run(folder, guard.test)
    assert whole.returncode == 0, whole.stdout
    file = folder / guard.file
    file.write_text(file.read_text().replace(guard.old, guard.new))
    done = run(folder, guard.test)
    assert done.returncode == 1, done.stdout
    assert " failed" in done.stdout
