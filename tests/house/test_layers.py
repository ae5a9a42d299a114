"""Arrows point down, cores know no I/O: what import-linter checks."""

from __future__ import annotations

from pathlib import Path

import pytest
from importlinter.cli import lint_imports_command

ROOT = Path(__file__).parents[2]


def test_arrows_point_down(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    with pytest.raises(SystemExit) as leaving:
        lint_imports_command(["--no-cache"])
    assert leaving.value.code == 0
