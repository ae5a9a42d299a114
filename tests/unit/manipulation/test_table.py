"""The simulated table: what jaws and loads run into, what they grip, what they feel."""

from __future__ import annotations

import math

import pytest
from manipulation.execution import CELL, SEARCH
from manipulation.orders import Order, Report
from manipulation.table import CAPTURE, Body, Table, table_of
from manipulationkit import SITES

from rtkit.world import Pose

WALL = frozenset({(3, 1)})


def table(**things: Body) -> Table:
    return Table(5, 5, WALL, things, Pose(CELL, CELL, 0.0), speed=0.2)


def body(x: float, y: float, **more: object) -> Body:
    return Body((x * CELL, y * CELL), **more)  # type: ignore[arg-type]


def done(on: Table, kind: str, x: float = 0, y: float = 0, theta: float = 0.0) -> Report:
    """Have one order done to its end."""
    on.take(Order(on.report.number + 1, kind, x * CELL, y * CELL, theta))
    for _ in range(10_000):
        if on.tick(0.01).outcome != "busy":
            return on.report
    raise AssertionError("it never ends")


def test_travel_takes_its_time_and_ends_where_it_should() -> None:
    on = table()
    on.take(Order(1, "travel", 0.1, 0.3))
    ticks = 0
    while on.tick(0.01).outcome == "busy":
        ticks += 1
    assert ticks == pytest.approx(100, abs=2)  # 0.2 m at 0.2 m/s
    assert (on.report.x, on.report.y) == pytest.approx((0.1, 0.3))
    assert on.report.outcome == "done"


@pytest.mark.parametrize(
    ("x", "y", "theta", "side"), [(2, 1, 0, "ahead"), (2, 1, math.pi / 2, "right")]
)
def test_a_wall_stops_the_jaws_and_is_felt_on_its_side(
    x: float, y: float, theta: float, side: str
) -> None:
    on = table()
    done(on, "travel", x, y, theta)
    report = done(on, "travel", 3, 1, theta)
    assert (report.outcome, report.contact) == ("touched", side)
    assert report.contact_x == pytest.approx(0.25)
    assert report.x == pytest.approx(0.225)


def test_the_edge_of_the_table_stops_the_jaws() -> None:
    assert done(table(), "travel", 0, 1).outcome == "touched"


def test_things_are_felt_on_the_way_but_not_above_them() -> None:
    on = table(cup=body(1, 3))
    assert done(on, "travel", 1, 3).outcome == "touched"
    assert done(on, "travel", 1, 1).outcome == "done"
    assert done(on, "over", 1, 3).outcome == "done"
    assert done(on, "travel", 1, 4).outcome == "done"  # what it stood above does not hold it back
    assert done(on, "travel", 1, 3).outcome == "touched"


def test_jaws_grip_what_is_between_them_and_nothing_else() -> None:
    on = table(cup=body(1.3, 3))
    done(on, "over", 1, 3)
    report = done(on, "grip")
    assert (report.outcome, report.is_gripping, report.is_closed) == ("empty", False, False)
    done(on, "over", 1 + SEARCH[1][0], 3)
    report = done(on, "grip")
    assert (report.outcome, report.is_gripping) == ("done", True)
    done(on, "over", 1, 3)
    done(on, "travel", 1, 5)
    report = done(on, "release")
    assert not report.is_gripping
    assert on.things["cup"].at == pytest.approx((0.1, 0.5))


def test_the_spots_that_are_searched_cover_half_a_place() -> None:
    spots = [(dx * CELL, dy * CELL) for dx, dy in SEARCH]
    for x in range(-50, 51, 5):
        for y in range(-50, 51, 5):
            off = (x / 1000, y / 1000)
            assert any(max(abs(off[0] - a), abs(off[1] - b)) <= CAPTURE for a, b in spots)


def test_a_load_runs_into_what_the_empty_hand_would_pass() -> None:
    tall = ((0, 0), (0, 1))
    on = table(beam=body(1, 2, shape=tall), cup=body(3, 3))
    assert done(on, "over", 1, 2).outcome == "done"
    done(on, "grip")
    assert done(on, "travel", 3, 2).outcome == "touched"
    done(on, "over", 1, 2)
    done(on, "release")
    assert done(on, "travel", 3, 2).outcome == "done"


def test_a_bar_is_gripped_along_it_only_and_turns_with_the_jaws() -> None:
    on = table(rod=body(2, 3, shape=((0, 0), (1, 0)), is_bar=True), cup=body(1, 4))
    done(on, "over", 2, 3, math.pi / 2)
    assert done(on, "grip").outcome == "empty"
    done(on, "turn", 2, 3, 0.0)
    assert done(on, "grip").outcome == "done"
    assert done(on, "turn", 2, 3, math.pi / 2).outcome == "done"
    assert on.things["rod"].turned == pytest.approx(math.pi / 2)
    assert done(on, "turn", 2, 3, math.pi).outcome == "touched"  # it swings into the cup


def test_an_order_is_done_once() -> None:
    on = table()
    order = Order(1, "travel", 0.1, 0.2)
    on.take(order)
    while on.tick(0.01).outcome == "busy":
        on.take(order)
    on.take(order)
    assert on.order is None
    assert done(on, "jump").outcome == "refused"


@pytest.mark.parametrize("site", SITES)
def test_things_lie_within_half_a_place_in_free_room(site: str) -> None:
    for seed in range(20):
        on = table_of(SITES[site], seed=seed)
        for told, true in zip(SITES[site]["things"], on.things.values(), strict=True):
            off = [abs(a / CELL - b) for a, b in zip(true.at, told["at"], strict=True)]
            assert max(off) <= 0.5
    assert table_of(SITES[site], seed=3).things == table_of(SITES[site], seed=3).things
