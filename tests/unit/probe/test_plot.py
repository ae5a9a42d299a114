"""Charts of characters."""

from __future__ import annotations

import math

from rtkit.probe.plot import MARKS, Chart


def test_a_line_goes_from_corner_to_corner():
    chart = Chart(100.0)
    for number in range(11):
        chart.add("data", float(number), number * 2.0)
    lines = chart.lines(40, 8)
    assert lines[0].startswith("20 |")
    assert lines[0].endswith("*")
    assert lines[5].startswith(" 0 |*")
    assert lines[-2].endswith(" 10 s")
    assert lines[-1] == "* data 20"
    assert max(map(len, lines)) <= 40
    assert len(lines) == 8


def test_one_value_and_none():
    assert Chart(1.0).lines(40, 8) == ["nothing came yet"]
    chart = Chart(1.0)
    chart.add("", 0.0, 5.0)
    assert sum("*" in line for line in chart.lines(40, 8)[:-1]) == 1
    assert chart.lines(40, 8)[-1] == "* value 5"


def test_what_is_no_number_is_only_told():
    chart = Chart(1.0)
    chart.add("x", 0.0, math.nan)
    assert chart.lines(40, 8) == ["* x nan"]
    chart.add("x", 0.0, math.inf)
    chart.add("x", 0.1, 1.0)
    assert len(chart.lines(40, 8)) == 8


def test_old_points_go():
    chart = Chart(1.0)
    chart.add("x", 0.0, 1000.0)
    chart.add("x", 5.0, 1.0)
    assert "1000" not in "".join(chart.lines(40, 8))


def test_no_more_curves_than_marks():
    chart = Chart(1.0)
    for number in range(len(MARKS) + 2):
        chart.add(f"c{number}", 0.0, number)
    assert chart.lines(80, 8)[-1].endswith("(2 more: -f chooses)")
