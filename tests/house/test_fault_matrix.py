"""Each fault in `docs/faults.md`, and threat in `docs/security.md`, has tests; guards are there."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from guards import GUARDS, Guard

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in TEXT.splitlines()
    if line.startswith("| ") and not line.startswith(("| fault |", "| promise |", "| ---"))
]
THREATS = [
    [cell.strip() for cell in line.strip("|").split("|")]
    for line in (ROOT / "docs" / "security.md")
    .read_text(encoding="utf-8")
    .partition("## Threats\n")[2]
    .partition("\n## ")[0]
    .splitlines()
    if line.startswith("| ") and not line.startswith(("| threat |", "| ---"))
]
SECTIONS = ("Component code", "Processes", "Machine", "Several hosts")


def named_in(row: list[str]) -> list[str]:
    return re.findall(r"`([^`]+)`", row[-1])


def exists(test: str) -> bool:
    """Whether there is such a file, with such a function if one is named."""
    name, _, function = test.partition("::")
    file = ROOT / "tests" / name
    if not file.is_file():
        return False
    nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
    names = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
    return function in names if function else any(each.startswith("test_") for each in names)


def test_there_are_rows_of_each_kind() -> None:
    for section in SECTIONS:
        part = TEXT.partition(f"### {section}\n")[2].partition("###")[0]
        assert part.count("\n| ") > 5, section


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_each_fault_is_tried(row: list[str]) -> None:
    assert len(row) == 3
    assert all(row)
    assert named_in(row)
    assert [test for test in named_in(row) if not exists(test)] == []


def test_there_are_threats() -> None:
    assert len(THREATS) >= 19


@pytest.mark.parametrize("row", THREATS, ids=[row[0] for row in THREATS])
def test_each_threat_is_tried(row: list[str]) -> None:
    threat, outcome, _tests = row
    assert threat
    assert outcome
    assert named_in(row)
    assert [test for test in named_in(row) if "::" not in test or not exists(test)] == []


def test_a_test_that_is_not_there_is_noticed() -> None:
    assert not exists("system/test_faults.py::test_nothing_of_the_kind")
    assert not exists("system/test_nothing.py")


@pytest.mark.parametrize("guard", GUARDS, ids=str)
def test_each_guard_is_there_once(guard: Guard) -> None:
    assert exists(guard.test.partition("[")[0])
    text = (ROOT / guard.file).read_text(encoding="utf-8")
    assert text.count(guard.old) == 1
    ast.parse(text.replace(guard.old, guard.new))


def test_every_file_of_fault_tests_has_guards() -> None:
    files = {test.partition("::")[0] for row in ROWS for test in named_in(row)}
    guarded = {guard.test.partition("::")[0] for guard in GUARDS}
    assert guarded <= files
