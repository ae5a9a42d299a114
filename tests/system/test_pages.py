"""README and pages work by copy and paste, and show what one gets."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fleetkit import NEEDS_HOSTS
from pagekit import MARK, ROOT, pages, script

from rtkit.cli.shared.commands import COMMANDS, TABLE
from rtkit.hosts import wheels
from rtkit.packages.wheel_target import WheelKind

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


def run(text: str, folder: Path, variables: dict[str, str], most_s: float = 110.0) -> str:
    """Run a script that must succeed and leave no socket; return what it shows."""
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", text],
        cwd=folder,
        env=variables,
        capture_output=True,
        text=True,
        timeout=most_s,
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


@NEEDS_HOSTS
@pytest.mark.timeout(240)  # rtkit is made on two hosts
def test_a_newcomer_comes_from_one_robot_to_a_fleet(
    shell: Any, variables: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a network of its own, so that names and addresses of the page can be had."""
    cache = variables["XDG_CACHE_HOME"] = str(ROOT / ".venv" / "cache")
    monkeypatch.setenv("XDG_CACHE_HOME", cache)
    wheels.wheels_for(_kind_here())  # there is no index where there is no network
    ssh = shell.folder / ".ssh"
    ssh.mkdir(mode=0o700)
    key = str(ssh / "id_ed25519")
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key], check=True)
    text, expected = script(ROOT / "docs" / "howto" / "fleet.md", is_roots=True)
    alone = "mount --make-rprivate /; mount -t tmpfs tmpfs /run; ip link set lo up; exec bash -euo"
    line = f"unshare -n -m -p --fork --kill-child --mount-proc sh -c '{alone} pipefail \"$0\"' all"
    (shell.folder / "all").write_text(text)
    told = run(line, shell.folder, variables, 220.0).split(f"{MARK}\n")
    assert [
        seen for seen, shown in zip(told, [*expected, ""], strict=True) if shown and seen != shown
    ] == []
    assert re.fullmatch(r"rtls: (host|manager on) robot2.*\n", told[2]), told[2]


def _kind_here() -> WheelKind:
    """Return the kind of the Python that an sshd finds, which may be another one than this."""
    program = "import sys; print('.'.join(map(str, sys.version_info[:2])))"
    path = {"PATH": "/usr/local/bin:/usr/bin:/bin"}
    version = subprocess.check_output(["python3", "-c", program], env=path, text=True).strip()
    return WheelKind(version, platform.machine(), platform.libc_ver()[1])


def test_every_command_is_in_the_table() -> None:
    page = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
    table = re.findall(r"^\| ((?:`rt\w+` ?)+)", page, re.MULTILINE)
    named = {name for row in table for name in re.findall(r"`(\w+)`", row)}
    assert named == set(COMMANDS.values()), "docs/commands.md: one row a command"
