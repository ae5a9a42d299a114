"""The index of the command reference: each row names a case, or a test, that there is."""

from __future__ import annotations

import re
from pathlib import Path

INDEX = Path(__file__).parent / "reference.txt"
CASES = Path(__file__).parent / "cases"
TESTS = Path(__file__).parents[2]


def rows() -> list[tuple[str, str]]:
    lines = INDEX.read_text(encoding="utf-8").splitlines()
    # A row may speak of = itself; what it is covered by begins with a command or a path.
    pattern = re.compile(r"(.+?) = ((?:rt|[A-Z]+_?[A-Z]*=|unit/|laws/|system/).*)")
    found = []
    for line in lines:
        if line and not line.startswith("#"):
            match = pattern.fullmatch(line)
            assert match is not None, line
            found.append((match[1], match[2]))
    return found


def test_what_a_row_names_is_there() -> None:
    texts = [file.read_text(encoding="utf-8") for file in CASES.glob("*.txt")]
    typed = {line[2:] for text in texts for line in text.splitlines() if line.startswith("$ ")}
    missing = []
    for row, covered_by in rows():
        file, colons, test = covered_by.partition("::")
        if not colons or " " in file:
            is_there = covered_by in typed
        else:
            path = TESTS / file
            is_there = path.is_file() and f"def {test}(" in path.read_text(encoding="utf-8")
        if not is_there:
            missing.append(f"{row} = {covered_by}")
    assert missing == []


def test_each_section_has_rows_of_its_own() -> None:
    sections = INDEX.read_text(encoding="utf-8").split("\n## ")[1:]
    for section in sections:
        named = [line.partition(" = ")[0] for line in section.splitlines()[1:] if line]
        assert named, section
        assert len(named) == len(set(named)), section
