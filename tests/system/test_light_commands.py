"""Commands of this host import and open only what their question takes, as whole processes."""

from __future__ import annotations

import subprocess
from typing import Any

import pytest

RUNS_PROCESSES = True
KEEPS_MANAGER = True
HEAVY = ("zenoh", "inspect", "socket", "ast")
LINES = (
    "rtls -l /localhost",
    "rtcat /localhost/manager.mgr",
    "rtcat -ll /localhost",
    "rtfind / -t m",
    "rtmgr status",
    "rtact /localhost/nobody.rtc",
)


@pytest.mark.parametrize("line", LINES)
def test_a_command_that_asks_loads_no_zenoh(shell: Any, manager: Any, line: str) -> None:
    interpreter, *rest = shell.command(line)
    done = subprocess.run(
        [interpreter, "-X", "importtime", *rest],
        env=shell.environment,
        cwd=shell.folder,
        capture_output=True,
        text=True,
        check=False,
    )
    imported = {row.rpartition("|")[2].strip() for row in done.stderr.splitlines()}
    assert "rtkit.link.requests.client" in imported, done.stderr
    assert imported & set(HEAVY) == set()
