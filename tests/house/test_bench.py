"""The measurements can be listed and chosen; what they print is well formed, measured or not."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from bench import page, scale, table3
from bench.__main__ import GROUPS, main
from bench.harness import Missing, Row, table


def test_every_group_offers_parts(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["-l"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert {name.partition("/")[0] for name in listed} == set(GROUPS)


def test_what_is_not_there_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["slav"]) == 2
    outcome = capsys.readouterr()
    assert outcome.out == ""
    assert "nothing is measured as slav; there is commands/reading, " in outcome.err


def row(what: str, figure: float, target: float | None, *, is_ratio: bool = False) -> Row:
    return Row(what, "ms", figure, 2.0, figure / 2, target, is_ratio, "a floor")


@pytest.mark.parametrize(
    ("line", "verdict"),
    [
        (row("a", 3.0, 3.0), "ok"),
        (row("a", 3.1, 3.0), "MISSED"),
        (row("a", 3.0, 1.5, is_ratio=True), "ok"),
        (row("a", 3.0, 1.4, is_ratio=True), "MISSED"),
        (row("a", 3.0, None), "-"),
        (Missing("a", "no sshd on this machine"), "not measured"),
    ],
)
def test_a_line_says_whether_its_target_is_met(line: Row | Missing, verdict: str) -> None:
    assert json.loads(line.as_json())["verdict"] == verdict
    assert verdict in table([line]).splitlines()[1]


def test_the_cost_of_one_more_component_is_drawn_as_a_curve() -> None:
    assert scale.curves([row("something else", 1.0, None)]) == ""
    rows = [
        row(f"a component by {way}, {there} others there", figure, 1.3, is_ratio=True)
        for way in ("a call", "one rtmgr")
        for there, figure in (("0", 2.0), ("10,000", 2.2))
    ]
    lines = scale.curves(rows).splitlines()
    assert (lines[1], lines[4]) == ("a component by a call", "a component by one rtmgr")
    assert lines[2].split() == ["0", "1.00", "x", "█" * 20]
    assert lines[3].split() == ["10,000", "1.10", "x", "█" * 22]


def test_table_3_has_a_place_for_each_of_its_rows() -> None:
    assert table3.pivot([row("something else", 1.0, None)]) == ""
    measured = row("Table 3: rtmgr, one command, own processes, 10 components, each", 21.3, None)
    lines = table3.pivot([measured]).splitlines()
    assert lines[1] == "Table 3"
    assert [line.split("  ")[0] for line in lines[3:]] == [
        "rtmgr, one command each",
        "rtmgr, one command",
        "ssh, by hand",
        "ssh, by script",
        "ssh, by script, a login each",
    ]
    assert lines[4].split()[-1] == "21"
    assert lines[5].count("not measured") == 4


def test_a_page_gets_the_table_between_its_marks(tmp_path: Path) -> None:
    file = tmp_path / "performance.md"
    file.write_text(f"before\n\n{page.BEGIN}old\n{page.END}\nafter\n", encoding="utf-8")
    rows = [row("a", 3.1, 3.0), row("b", 3.0, None), Missing("c", "no sshd on this machine")]
    page.write(file, rows, 0.2, "pinned to processors 2-3")
    text = file.read_text(encoding="utf-8")
    assert text.startswith(f"before\n\n{page.BEGIN}Measured on ")
    assert "load average before 0.2; pinned to processors 2-3.\n" in text
    assert "| a | 3.1 ms | 2 ms | 1.55 x | 3 ms MISSED | a floor |\n" in text
    assert "| c | - | - | - | - | not measured: no sshd on this machine |\n" in text
    assert text.endswith(f"{page.END}\nafter\n")
    page.write(file, rows, 0.2, "again")
    assert file.read_text(encoding="utf-8").count("Measured on") == 1


def test_a_page_without_marks_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "performance.md"
    file.write_text("nothing\n", encoding="utf-8")
    with pytest.raises(ValueError, match="there is no place between"):
        page.write(file, [], 0.0, "")
    assert file.read_text(encoding="utf-8") == "nothing\n"


def test_the_page_of_figures_has_its_place() -> None:
    text = (Path(__file__).parents[2] / "docs" / "performance.md").read_text(encoding="utf-8")
    assert text.count(page.BEGIN) == text.count(page.END) == 1
