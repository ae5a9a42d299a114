"""Arrows point down, cores know no I/O: what import-linter checks."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_arrows_point_down() -> None:
    # In a process of its own: the linter turns off every logger of the one that it runs in.
    script = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    done = subprocess.run(
        [sys.executable, "-c", script, "--no-cache"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_runs_a_module_stands_last_in_it() -> None:
    """What stands behind it is not there yet when the module runs as a process."""
    early = []
    for file in (ROOT / "rtkit").rglob("*.py"):
        for node in ast.parse(file.read_text(encoding="utf-8")).body[:-1]:
            if isinstance(node, ast.If) and "__main__" in ast.unparse(node.test):
                early.append(f"{file.relative_to(ROOT)}:{node.lineno}")
    assert early == []
