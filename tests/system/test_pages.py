"""README and pages work by copy and paste, and show what one gets."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pagekit import MARK, ROOT, pages, script

from rtkit.cli.shared.commands import COMMANDS, TABLE

TAUGHT = [ROOT / "examples" / name / "README.md" for name in ("bug", "home", "manipulation")]
WITH_EXAMPLES = [page for page in (*pages(), *TAUGHT) if script(page).text]
HERE = {"EXAMPLES": str(ROOT / "examples")}


@pytest.fixture
def variables(shell: Any) -> dict[str, str]:
    """What a user has: commands on the path, a home, no settings of rtkit."""
    strangers = ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_MODULE_PATH", "XDG_")
    kept = {k: v for k, v in shell.environment.items() if not k.startswith(strangers)}
    commands = shell.folder / "bin"
    commands.mkdir()
    python = f'exec "{sys.executable}"'
    modules = {name: module for name, (module, _) in TABLE.items()} | {"rtkit": "rtkit.cli"}
    begin = "import sys; sys.argv[0] ="
    scripts = {
        name: f'{python} -c \'{begin} "{name}"; from {module} import main; exit(main())\' "$@"'
        for name, module in modules.items()
    }
    others = {"python": f'{python} "$@"', "pytest": f'{python} -m pytest "$@"'}
    for name, line in {**scripts, **others}.items():
        (commands / name).write_text(f"#!/bin/sh\n{line}\n", encoding="utf-8")
        (commands / name).chmod(0o755)
    (shell.folder / "x").mkdir(mode=0o700)
    return {
        **kept,
        **HERE,
        "HOME": str(shell.folder),
        "XDG_RUNTIME_DIR": str(shell.folder / "x"),
        "PATH": f"{commands}{os.pathsep}{os.environ['PATH']}",
    }


def run(text: str, folder: Path, variables: dict[str, str]) -> str:
    """Run a script that must succeed and leave no socket; return what it shows."""
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", text],
        cwd=folder,
        env=variables,
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    log = folder / ".local" / "state" / "rtkit" / "manager.log"
    told = f"{done.stdout}\n{done.stderr}\n{log.read_text() if log.exists() else ''}"
    assert done.returncode == 0, told
    sockets = folder / "x" / "rtkit"
    assert not sockets.exists() or list(sockets.iterdir()) == []
    return done.stdout


@pytest.mark.timeout(120)  # tables of thirty commands, on a busy machine
@pytest.mark.parametrize("page", WITH_EXAMPLES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_shows_what_its_examples_print(
    shell: Any, variables: dict[str, str], page: Path
) -> None:
    text, expected = script(page)
    for tool in ("node",):
        if re.search(rf"^{tool} ", text, re.MULTILINE) and shutil.which(tool) is None:
            pytest.skip(f"{tool} absent")
    assert run(text, shell.folder, variables).split(f"{MARK}\n") == [*expected, ""]


def test_every_command_is_in_the_table() -> None:
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    table = re.findall(r"^\| ((?:`rt\w+` ?)+)", page, re.MULTILINE)
    named = {name for row in table for name in re.findall(r"`(\w+)`", row)}
    assert named == set(COMMANDS.values()), "docs/commands.md: one row a command"
