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


def test_the_planner_and_its_two_worlds_know_nothing_of_each_other() -> None:
    """Deployments and manipulation tasks are problems; what solves them imports neither."""
    forbidden = {
        ROOT / "rtkit" / "planner": ("rtkit.deployment", "manipulation", "rtkit.component"),
        ROOT / "rtkit" / "deployment": ("manipulation", "examples"),
        ROOT / "examples" / "manipulation": ("rtkit.deployment",),
    }
    found = []
    for folder, names in forbidden.items():
        files = list(folder.rglob("*.py"))
        assert files, folder
        for file in files:
            found += [
                f"{file.relative_to(ROOT)}: {imported}"
                for imported in imported_by(file)
                if imported.startswith(names)
            ]
    assert found == []


def imported_by(file: Path) -> list[str]:
    """Return the modules that a file names in its imports, wherever they stand."""
    names = []
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names += [node.module or "", *(f"{node.module}.{each.name}" for each in node.names)]
    return names
