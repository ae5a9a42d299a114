"""What is written of runs: rows, results, tables; and which answer is right."""

from __future__ import annotations

import csv
import io
import itertools
import json
from itertools import pairwise
from math import pi

import jsonrecords
import pytest
from bug import records
from bug.records import Row
from bug_runs import CORNERS, WORLD, record, rows


def test_a_trajectory_has_the_columns_that_are_stated_and_a_row_a_step() -> None:
    lines = list(csv.reader(io.StringIO(records.trajectory_csv(rows()))))
    assert lines[0] == ["t", "x", "y", "theta", "mode"]
    assert lines[1] == ["0.000000", "0.000000", "-4.000000", "1.570796", "goal"]
    assert len(lines) == 1 + len(rows())
    times = [float(line[0]) for line in lines[1:]]
    assert all(b - a == 0.5 for a, b in itertools.pairwise(times))


@pytest.mark.parametrize("theta", [pi, -pi + 1e-9, -1e-12, 3.14159265, -3.1415926])
def test_an_angle_is_within_its_bounds_also_when_it_is_rounded(theta: float) -> None:
    line = records.trajectory_csv([Row(0.0, -0.0, -1e-9, theta, "goal")]).splitlines()[1]
    assert -pi < float(line.split(",")[3]) <= pi
    assert "-0.000000" not in line


def test_odometry_has_columns_of_its_own_where_there_is_noise() -> None:
    text = records.trajectory_csv([Row(0.0, 1.0, 2.0, 0.5, "goal", (1.1, 2.1, 0.6))])
    assert text == (
        "t,x,y,theta,mode,odom_x,odom_y,odom_theta\n"
        "0.000000,1.000000,2.000000,0.500000,goal,1.100000,2.100000,0.600000\n"
    )


def test_a_result_is_as_its_schema_says() -> None:
    """Schema rtkit.bug-run/1, with the kind bug-run."""
    text = records.result_json(record())
    (found,) = jsonrecords.checked(json.dumps(json.loads(text)))
    assert found["path_length"] == pytest.approx(11.2586, abs=1e-4)
    assert found["hits"] == [[0.0, -0.95]]
    assert found["leaves"] == [[0.0, 1.8]]
    assert found["steps"] == len(rows()) - 1
    assert found["time"] == rows()[-1].t


def test_what_is_unreachable_has_no_shortest_path_and_no_ratio() -> None:
    made = record(status="unreachable", shortest=None, bound=None)
    assert records.result_of(made)["shortest"] is None
    assert records.table_rows([made])[0][6] == ""


@pytest.mark.parametrize(
    ("reachable", "status", "collisions", "is_right"),
    [
        (True, "reached", 0, True),
        (True, "unreachable", 0, False),
        (True, "gave-up", 0, False),
        (True, "reached", 1, False),
        (False, "unreachable", 0, True),
        (False, "reached", 0, False),
        (None, "reached", 0, True),
        (None, "unreachable", 0, True),
        (None, "gave-up", 0, False),
    ],
)
def test_an_answer_is_right_by_what_the_world_says(
    reachable: bool | None, status: str, collisions: int, is_right: bool
) -> None:
    from dataclasses import replace

    world = replace(WORLD, reachable=reachable)
    made = record(environment=world, status=status, collisions=collisions)
    assert made.is_right is is_right
    assert records.line_of(made).endswith(": WRONG") is not is_right


def test_a_table_is_sorted_by_its_columns_from_the_left() -> None:
    made = [record(v, s) for v in ("rev1", "alg1") for s in ("laser", "ir", "laser+ir")]
    lines = list(csv.reader(io.StringIO(records.table_csv(made))))
    assert ",".join(lines[0]) == (
        "environment,variant,sensors,direction,status,path_length,ratio,time,hits,leaves,"
        "reversals,collisions,min_clearance"
    )
    assert lines[1:] == sorted(lines[1:])
    assert records.table_md(made).count("\n| one-box") == 6
    assert "ends at the goal_margin of its world before the goal" in records.table_md(made)
    assert "\n6 of 6 runs gave the right answer" in records.table_md(made)


def test_a_file_is_there_as_a_whole_or_not_at_all(tmp_path) -> None:
    records.write(tmp_path / "a", "b.txt", "first")
    with pytest.raises(UnicodeEncodeError):
        records.write(tmp_path / "a", "b.txt", "\udc80")
    assert [each.name for each in (tmp_path / "a").iterdir()] == ["b.txt"]
    assert (tmp_path / "a" / "b.txt").read_text() == "first"


def test_the_length_is_that_of_the_rows_as_written() -> None:
    assert CORNERS[0][0] == (0.0, -4.0)
    written = records.trajectory_csv(rows()).splitlines()[1:]
    places = [tuple(map(float, line.split(",")[1:3])) for line in written]
    total = sum(
        ((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 for a, b in itertools.pairwise(places)
    )
    assert record().path_length == pytest.approx(total, abs=1e-9)


@pytest.mark.parametrize(("variant", "sensors"), [("tangentbug", "ir"), ("alg1", "laser")])
def test_as_many_changes_of_mode_are_in_the_rows_as_hits_and_leaves(
    variant: str, sensors: str
) -> None:
    from bug.assembly import variants
    from bug.environments import shipped
    from bug.simulation import simulate

    run = simulate(shipped()["visited"], variants()[variant], sensors)
    assert run.rows[0].mode == "goal"
    changes = [(a.mode, b.mode) for a, b in pairwise(run.rows)]
    assert changes.count(("goal", "follow")) == len(run.hits)
    assert changes.count(("follow", "goal")) == len(run.leaves)
