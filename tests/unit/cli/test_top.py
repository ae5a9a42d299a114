"""The page of rttop: numbers, columns, what fits."""

from __future__ import annotations

import pytest

from rtkit.api.rates import Rater, RateRow
from rtkit.cli.observing.top.page import TITLES, Look, cut, ordered, short, table
from rtkit.cli.observing.top.screen import keys_of
from rtkit.deployment.facts import ComponentFacts, ProcessFacts, Snapshot
from rtkit.deployment.metrics import ComponentMetrics, ContextMetrics, Metrics, ProcessMetrics
from rtkit.rtc.enums import ExecutionKind, LifeCycleState
from rtkit.rtc.profiles import ExecutionContextProfile, TypeProfile

BUSY = RateRow(
    "Busy0.rtc", "manager", "Busy0", "p", 1, "Active", "", "0", 2,
    100.0, 99.84, 0.00123, 0.02, 12.5, 38 * 2**20, {"out": 99.8}, {},
)  # fmt: skip
IDLE = RateRow("Idle0.rtc", "manager", "Idle0", "p", 1, "Inactive", "", "0", 0, 10.0)
BAD = RateRow("Bad0.rtc", "manager", "Bad0", "p", 1, "Error", "ValueError: " + "x" * 90, "0", 0)
ROWS = [BUSY, IDLE, BAD]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (0, "0"),
        (0.1234, "0.12"),
        (9.994, "9.99"),
        (9.996, "10.0"),
        (99.96, "100"),
        (999.4, "999"),
        (999.6, "1.00k"),
        (12_345.0, "12.3k"),
        (2.5e6, "2.50M"),
        (3e9, "3.00G"),
    ],
)
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert short(value) == text


@pytest.mark.parametrize("width", [20, 40, 60, 80, 100, 200])
def test_no_line_is_wider_than_the_terminal_and_columns_stand_below_each_other(width: int) -> None:
    head, *lines = table(ordered(ROWS, Look()), Look(width=width, height=20))
    assert all(len(line) <= width for line in (head, *lines))
    assert "NAME^" in head
    if width >= 80:
        at = head.index("STATE")
        rows = [line for line in lines if ".rtc" in line]
        assert [line[at:].split()[0] for line in rows] == ["Error", "Active", "Inactive"]


def test_without_width_nothing_is_cut() -> None:
    lines = table(ROWS, Look())
    assert any(line.strip() == BAD.why for line in lines)
    assert all(title in lines[0] for title in TITLES)
    assert "99.8/100" in lines[1]
    assert "-/10.0" in lines[2]


@pytest.mark.parametrize(
    ("title", "order"),
    [
        ("NAME", ["Bad0", "Busy0", "Idle0"]),
        ("STATE", ["Bad0", "Busy0", "Idle0"]),
        ("CPU%", ["Busy0", "Bad0", "Idle0"]),
        ("RST", ["Busy0", "Bad0", "Idle0"]),
    ],
)
def test_what_is_not_known_comes_last(title: str, order: list[str]) -> None:
    look = Look(TITLES.index(title))
    assert [row.instance for row in ordered(ROWS, look)] == order
    mark = "^" if title in ("NAME", "STATE") else "v"
    assert f"{title}{mark}" in table(ROWS, look)[0]


def test_the_selected_row_stays_in_sight() -> None:
    rows = [IDLE._replace(path=f"C{number:02}.rtc") for number in range(50)]
    for selected in ("C00.rtc", "C25.rtc", "C49.rtc"):
        lines = table(rows, Look(selected=selected, width=80, height=10))
        assert len(lines) == 10
        assert next(line for line in lines if line.startswith(">")).split()[0] == f">{selected}"


def test_what_is_wide_is_cut_by_columns() -> None:
    assert cut("日本語", 5) == "日本~"
    assert cut("abc", 3) == "abc"


def test_keys() -> None:
    assert keys_of("a\x1b[A\x1b[6~q") == ["a", "up", "page down", "q"]


def metrics(number: int, ticks: int, *, has_work: bool = True) -> Metrics:
    context = ContextMetrics("0", has_work, True, ticks, ticks * 0.002, 0.005)
    component = ComponentMetrics("A", (context,), {"out": ticks}, {})
    process = ProcessMetrics(5, "p", True, (component,), number * 0.25, 1000)
    return Metrics("run", number, (process,), 0.0, number * 2.0)


def snapshot() -> Snapshot:
    context = ExecutionContextProfile(
        "0", ExecutionKind.PERIODIC, 100.0, "A", state=LifeCycleState.ACTIVE
    )
    component = ComponentFacts("A", TypeProfile("T"), "p", contexts=(context,))
    process = ProcessFacts("p", True, 5, "up")
    return Snapshot("host", "manager", 1, "0", (process,), (component,))


def test_rates_are_differences() -> None:
    rater = Rater()
    rater.take(metrics(1, 10))
    (row,) = rater.rows(snapshot(), {"A": "A.rtc"})
    assert (row.reached_hz, row.cpu_percent, rater.has_rates) == (None, None, False)
    assert not rater.is_whole
    rater.take(metrics(2, 210))
    (row,) = rater.rows(snapshot(), {"A": "A.rtc"})
    assert (row.reached_hz, row.mean_s, row.longest_s) == (100.0, pytest.approx(0.002), 0.005)
    assert (row.out_hz, row.in_hz, row.cpu_percent) == (100.0, None, 12.5)
    assert rater.is_whole
    rater.take(metrics(3, 210, has_work=False))
    (row,) = rater.rows(snapshot(), {"A": "A.rtc"})
    assert row.reached_hz is None  # at rest, not failing
    assert rater.totals() == (12.5, 1000)
