"""The measurements can be listed and chosen; what they print is well formed, measured or not."""

from __future__ import annotations

import itertools
import json
import math
import os
import random
from pathlib import Path

import pytest

from bench import page, peers, placement, scale, table3
from bench.__main__ import GROUPS, main
from bench.harness import Missing, Row, table
from bench.pairs import alone, interval, medians, until_tight


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
    return Row(what, "ms", alone(figure, 2.0), target, is_ratio, "a floor")


def paired_row(ratios: list[float], target: float | None) -> Row:
    return Row("a", "ms", medians([(ratio, 1.0) for ratio in ratios]), target, True, "a floor")


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


@pytest.mark.parametrize(
    ("count", "ends"),
    # Ranks of a 95 % interval of the median, as tables of order statistics have them.
    [(5, None), (6, (1, 6)), (8, (1, 8)), (9, (2, 8)), (10, (2, 9)), (12, (3, 10)), (15, (4, 12)),
     (20, (6, 15)), (21, (6, 16)), (30, (10, 21)), (50, (18, 33)), (70, (27, 44))],
)  # fmt: skip
def test_interval_has_the_ranks_of_the_tables(count: int, ends: tuple[int, int] | None) -> None:
    values = [float(number) for number in range(count, 0, -1)]
    assert interval(values) == ends


def test_interval_encloses_the_median_as_often_as_it_says() -> None:
    chance = random.Random(1)
    hits = 0
    for _ in range(2000):
        low, high = interval([chance.expovariate(1.0) for _ in range(21)]) or (0.0, 0.0)
        hits += low <= math.log(2) <= high
    assert 0.95 <= hits / 2000 <= 0.99  # by the binomial 0.973


def test_pairs_repeat_until_their_ratio_is_known() -> None:
    noisy_then_quiet = itertools.chain([5.0, 1.0, 5.0, 1.0, 5.0, 1.0], itertools.repeat(2.0))
    pairs = until_tight(lambda: (next(noisy_then_quiet), 1.0), 6, extra_s=60.0)
    assert 6 < len(pairs) < 30
    assert not medians(pairs).is_noisy
    assert len(until_tight(lambda: (2.0, 1.0), 6)) == 6


def test_pairs_end_at_their_most_and_at_their_time() -> None:
    values = itertools.cycle([1.0, 2.0, 4.0])
    pairs = until_tight(lambda: (next(values), 1.0), 7, extra_s=60.0)
    assert len(pairs) == 35
    assert medians(pairs).is_noisy
    assert len(until_tight(lambda: (next(values), 1.0), 7, extra_s=0.0)) == 7


def test_a_row_tells_its_spread() -> None:
    told = json.loads(paired_row([1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6], 2.0).as_json())
    assert (told["pairs"], told["interval"], told["noisy"]) == (7, [1.0, 1.6], True)
    assert (told["figure_quartiles"], told["floor_quartiles"]) == ([1.15, 1.45], [1.0, 1.0])
    few = json.loads(paired_row([1.0, 3.0], None).as_json())
    assert (few["pairs"], few["interval"], few["noisy"]) == (2, None, False)
    assert "interval" not in json.loads(row("a", 3.0, 3.0).as_json())


@pytest.mark.parametrize(
    ("target", "verdict"), [(0.9, "MISSED"), (1.2, "too noisy"), (1.6, "ok"), (None, "too noisy")]
)
def test_a_target_within_a_wide_interval_is_open(target: float | None, verdict: str) -> None:
    line = paired_row([1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6], target)
    assert line.verdict == verdict
    text = table([line]).splitlines()[1]
    assert "1.30 (1.00-1.60)" in text
    assert "noisy" in text


def test_where_it_ran_is_told() -> None:
    told = json.loads(placement.as_json(0.25))
    assert (told["schema"], told["load_before"]) == ("rtkit.bench/1", 0.25)
    assert set(told["processors_allowed"]) == os.sched_getaffinity(0)


def test_peers_tell_why_when_nothing_can_be_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    assert main(["peers"]) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if line.startswith("{")][1:]
    told = [json.loads(line) for line in lines]
    assert len(told) == len(peers.PARTS)
    for line in told:
        assert line["verdict"] == "not measured"
        assert "No matching distribution found" in line["why"]


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
    rows: list[Row | Missing] = [
        row("a", 3.1, 3.0),
        row("b", 3.0, None),
        Missing("c", "no sshd on this machine"),
    ]
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
    for name in ("performance.md", "peers.md"):
        text = (Path(__file__).parents[2] / "docs" / name).read_text(encoding="utf-8")
        assert text.count(page.BEGIN) == text.count(page.END) == 1
