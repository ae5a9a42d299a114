"""Decision records: numbered without gaps, with a title, a date and a status."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

FILES = sorted((Path(__file__).parents[2] / "docs" / "decisions").glob("[0-9]*.md"))
HEAD = re.compile(
    r"# (\d+)\. \S[^\n]*\n\nDate: 20\d\d-\d\d-\d\d\. Status: (accepted|superseded)\.([^\n]*)\n\n"
)


def test_numbers_have_no_gaps() -> None:
    assert [int(file.name[:4]) for file in FILES] == list(range(1, len(FILES) + 1))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name[:4])
def test_a_decision_has_title_date_and_status(file: Path) -> None:
    found = HEAD.match(file.read_text(encoding="utf-8"))
    assert found, "begin with: # 48. Title, an empty line, Date: 2026-11-23. Status: accepted."
    assert int(found[1]) == int(file.name[:4])
    for other in re.findall(r"\b\d{4}\b", found[3]):
        assert any(each.name.startswith(other) for each in FILES), f"there is no decision {other}"
