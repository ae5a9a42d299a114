"""Installs other systems from the package index, into a virtual environment in the cache."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from rtkit.errors import RtkitError


class PeerMissing(RtkitError):
    """Another system cannot be installed or started here."""


def programs(package: str, *others: str) -> Path:
    """Return the folder of the programs of an environment that has packages.

    Raises:
        PeerMissing: With what pip said.
    """
    folder = _folder()
    python = folder / "bin" / "python"
    if not python.exists():
        _run(["-m", "venv", "--without-pip", str(folder)])
    quick = ["--quiet", "--disable-pip-version-check", "--retries", "1", "--timeout", "20"]
    _run(["-m", "pip", "--python", str(python), "install", *quick, package, *others])
    return python.parent


def version(package: str) -> str:
    """Return the version of an installed package, after its name."""
    code = f"from importlib.metadata import version; print(version({package!r}))"
    python = str(_folder() / "bin" / "python")
    told = subprocess.run([python, "-c", code], capture_output=True, check=True, text=True).stdout
    return f"{package} {told.strip()}"


def _folder() -> Path:
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "rtkit-bench-peers" / f"python{sys.version_info[0]}.{sys.version_info[1]}"


def _run(words: list[str]) -> None:
    done = subprocess.run([sys.executable, *words], capture_output=True, check=False, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or done.stdout.strip().splitlines()
        errors = [line for line in lines if line.startswith("ERROR:")] or lines or ["no reason"]
        raise PeerMissing(f"pip install {words[-1]}: {errors[-1].removeprefix('ERROR: ')}")
