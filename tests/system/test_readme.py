"""The README works by copy and paste, and shows what one gets."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rtkit.cli import COMMANDS, MODULES

README = Path(__file__).parents[2] / "README.md"
BLOCK = re.compile(r"^(<!-- not run[^\n]*\n)?```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
MARK = "-- end of block --"


LIVE = "## Live properties"


def blocks(is_live: bool = False) -> list[tuple[str, str]]:
    """Return language and text of each block that is to be run or compared.

    Those about live properties need nothing of what the others leave behind.
    """
    before, _, live = README.read_text(encoding="utf-8").partition(LIVE)
    section, _, after = live.partition("\n## ")
    found = BLOCK.findall(section if is_live else before + after)
    return [(language, text) for not_run, language, text in found if not not_run]


@pytest.fixture
def variables(shell: Any) -> dict[str, str]:
    """What a user has: commands on the path, a home, no settings of rtkit."""
    strangers = ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_MODULE_PATH", "XDG_")
    kept = {k: v for k, v in shell.environment.items() if not k.startswith(strangers)}
    commands = shell.folder / "bin"
    commands.mkdir()
    python = f'exec "{sys.executable}"'
    scripts = {
        name: f"{python} -c 'from {module} import main; exit(main())' \"$@\""
        for name, module in MODULES.items()
    }
    for name, line in {**scripts, "python": f'{python} "$@"'}.items():
        (commands / name).write_text(f"#!/bin/sh\n{line}\n", encoding="utf-8")
        (commands / name).chmod(0o755)
    (shell.folder / "x").mkdir(mode=0o700)
    return {
        **kept,
        "HOME": str(shell.folder),
        "XDG_RUNTIME_DIR": str(shell.folder / "x"),
        "PATH": f"{commands}{os.pathsep}{os.environ['PATH']}",
    }


def run(script: str, folder: Path, variables: dict[str, str]) -> str:
    """Run a script that must succeed and leave no socket; return what it shows."""
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", script],
        cwd=folder,
        env=variables,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    log = folder / ".local" / "state" / "rtkit" / "manager.log"
    assert done.returncode == 0, done.stderr + (log.read_text() if log.exists() else "")
    assert list((folder / "x" / "rtkit").iterdir()) == []
    return done.stdout


@pytest.mark.parametrize("is_live", [False, True])
def test_the_first_five_minutes_show_what_the_readme_says(
    shell: Any, variables: dict[str, str], is_live: bool
) -> None:
    parts = blocks(is_live)
    script = "".join(f"{text}echo '{MARK}'\n" for kind, text in parts if kind == "sh")
    expected: list[str] = []
    for kind, text in parts:
        if kind == "sh":
            expected.append("")
        elif kind == "text":
            expected[-1] = text
    assert run(script, shell.folder, variables).split(f"{MARK}\n") == [*expected, ""]


def test_the_python_of_the_readme_runs(shell: Any, variables: dict[str, str]) -> None:
    (code,) = [text for kind, text in blocks() if kind == "python"]
    script = f"rtmgr start\npython - <<'END'\n{code}\nEND\nrtmgr stop"
    assert run(script, shell.folder, variables) == "/localhost/In0.rtc Active\n"


def test_every_command_is_in_the_table() -> None:
    table = re.findall(r"^\| ((?:`rt\w+` ?)+)", README.read_text(encoding="utf-8"), re.MULTILINE)
    named = {name for row in table for name in re.findall(r"`(\w+)`", row)}
    assert named == set(COMMANDS.values()), "README.md, section Commands: one row a command"
