"""The image of examples/container: what hadolint says of it, and what its page promises."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from rtkit.cli.shared.commands import TABLE

ROOT = Path(__file__).parents[2]
FILE = ROOT / "examples" / "container" / "Containerfile"
TEXT = re.sub(r"\\\n\s*", "", FILE.read_text(encoding="utf-8"))
LINES = [line.split(maxsplit=1) for line in TEXT.splitlines() if line and line[0] != "#"]


def last(instruction: str) -> str:
    return [text for word, text in LINES if word == instruction][-1]


def test_hadolint_finds_nothing() -> None:
    folder = Path(sys.executable).parent
    hadolint = shutil.which("hadolint", path=str(folder)) or shutil.which("hadolint")
    if hadolint is None:
        pytest.skip("hadolint is not installed")
    done = subprocess.run([hadolint, str(FILE)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout + done.stderr) == (0, "")


def test_nothing_runs_as_root_or_in_a_shell() -> None:
    assert re.fullmatch(r"[1-9]\d*:[1-9]\d*", last("USER"))
    (command,) = re.findall(r"CMD (\[.*\])", last("HEALTHCHECK"))
    for name, *_ in (json.loads(last("ENTRYPOINT")), json.loads(command)):
        assert name in TABLE
    assert last("STOPSIGNAL") == "SIGTERM"
    assert all(re.fullmatch(r"python:3\.\d+-slim( AS \w+)?", t) for w, t in LINES if w == "FROM")


def test_what_the_package_is_built_of_is_there() -> None:
    """All that pyproject.toml names is copied, and all that is copied is there."""
    copied = [text.split()[:-1] for word, text in LINES if word == "COPY" and text[:2] != "--"]
    names = {name for words in copied for name in words}
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {"pyproject.toml", "rtkit", project["project"]["readme"], *wheel["force-include"]}
    needed |= {*project["project"]["license-files"], *wheel["shared-data"]}
    assert names == needed
    assert all((ROOT / name).exists() for name in names)
