"""Fusion: which markers are of one thing, who keeps its name, what moves and what is forgotten."""

from __future__ import annotations

import pytest

from rtkit import Marker, PropertyError
from rtkit.services.fusion import MarkerFusion
from rtkit.services.grids import MOST_CELLS, Grid


def ball(*location: float, **more: object) -> Marker:
    return Marker(location, **({"type": "ball", "time": 1.0} | more))  # type: ignore[arg-type]


def told(model: MarkerFusion) -> list[tuple[str, int]]:
    return [(each.id, each.features["count"]) for each in model.things()]


def only(model: MarkerFusion) -> Marker:
    (thing,) = model.things()
    return thing


def test_two_sensors_that_see_one_ball_are_one_marker_with_less_variance() -> None:
    model = MarkerFusion()
    model.observe([ball(1.0, 2.0, variance=0.04, source="left", color=(1, 0, 0))], 1.0)
    model.observe([ball(1.1, 2.0, variance=0.04, source="right", shape="round")], 1.0)
    thing = only(model)
    assert thing.location == pytest.approx((1.05, 2.0))
    assert thing.variance == pytest.approx(0.02)
    assert thing.features["count"] == 2
    assert (thing.features["color"], thing.features["shape"]) == ((1, 0, 0), "round")


def test_two_balls_of_one_look_stay_two() -> None:
    model = MarkerFusion()
    for _ in range(3):
        model.observe([ball(0.0, 0.0), ball(0.2, 0.0)], 1.0)
    assert told(model) == [("ball-1", 3), ("ball-2", 3)]
    assert [each.location for each in model.things()] == [(0.0, 0.0), (0.2, 0.0)]


def test_what_is_of_another_type_or_too_far_is_another_thing() -> None:
    model = MarkerFusion()
    model.observe([ball(0.0, 0.0)], 1.0)
    model.observe([ball(0.0, 0.0, type="box")], 1.0)
    model.observe([ball(0.5, 0.0)], 1.0)
    model.observe([ball(0.47, 0.0)], 1.0)
    assert told(model) == [("ball-1", 1), ("box-1", 1), ("ball-2", 2)]


def test_the_nearest_one_gets_it() -> None:
    model = MarkerFusion(gate=9.0)
    model.observe([ball(0.0, 0.0), ball(1.0, 0.0)], 1.0)
    model.observe([ball(0.6, 0.0)], 1.0)
    assert told(model) == [("ball-1", 1), ("ball-2", 2)]


def test_identity_is_kept() -> None:
    model = MarkerFusion()
    model.observe([ball(0.0, 0.0, id="tag7", source="left")], 1.0)
    model.observe([ball(0.1, 0.0, id="3", source="right")], 1.0)
    assert told(model) == [("tag7", 2)]
    # Each sensor knows it by a name of its own, wherever it is seen then.
    model.observe([ball(5.0, 0.0, id="3", source="right", time=2.0)], 2.0)
    assert told(model) == [("tag7", 3)]
    assert only(model).location == (5.0, 0.0)
    # Next to it, but the sensor says that it is another one.
    model.observe([ball(5.0, 0.0, id="4", source="right", time=2.0)], 2.0)
    model.observe([ball(9.0, 0.0, id="tag7", source="else", time=2.0)], 2.0)
    assert [name for name, _ in told(model)] == ["tag7", "4", "ball-1"]


def test_a_moved_object_is_followed() -> None:
    model = MarkerFusion(drift=0.02)
    for step in range(100):
        model.observe([ball(0.05 * step, 0.0, time=0.1 * step)], 100.0)
    assert told(model) == [("ball-1", 100)]
    thing = only(model)
    assert thing.location is not None
    assert thing.location[0] == pytest.approx(0.05 * 99, abs=0.2)
    assert thing.time == pytest.approx(9.9)


def test_what_comes_late_counts_for_its_time() -> None:
    model = MarkerFusion(drift=0.02)
    model.observe([ball(0.0, 0.0, time=10.0)], 10.0)
    model.observe([ball(1.0, 0.0, time=0.0, variance=0.1, color="old")], 10.0)
    model.observe([ball(0.1, 0.0, time=9.0, color="late")], 10.0)
    assert only(model).time == 10.0
    assert only(model).features["count"] == 3
    assert only(model).location[0] < 0.1  # type: ignore[index]


def test_what_was_not_seen_for_long_is_forgotten() -> None:
    model = MarkerFusion(most=2)
    for number in range(4):
        model.observe([ball(float(number), 0.0, time=float(number))], 100.0)
    assert [each.time for each in model.things()] == [2.0, 3.0]
    model.forget(2.5)
    assert [each.time for each in model.things()] == [3.0]


def test_what_a_clock_that_is_ahead_tells_is_seen_now_and_ages() -> None:
    model = MarkerFusion(drift=0.01)
    model.observe([ball(0.0, 0.0, time=1e99)], 10.0)
    model.observe([ball(0.1, 0.0, time=10.0)], 10.0)
    assert only(model).location == (0.05, 0.0)
    assert only(model).time == 10.0
    model.forget(10.5)
    assert told(model) == []


@pytest.mark.parametrize(
    "marker",
    [
        Marker(None, polar=(1.0, 2.0)),
        ball(float("nan"), 0.0),
        ball(float("inf"), 0.0),
        ball(0.0, 0.0, variance=0.0),
        ball(0.0, 0.0, variance=-1.0),
        ball(0.0, 0.0, covariance=((1.0, 2.0), (2.0, 1.0))),
        ball(0.0, 0.0, confidence=0.0),
        ball(0.0, 0.0, confidence=1.5),
        ball(9.0, 0.0, time=float("nan")),
        ball(9.0, 0.0, count=0),
        ball(9.0, 0.0, count="many"),
    ],
)
def test_what_cannot_be_fused_is_refused_with_all_beside_it(marker: Marker) -> None:
    model = MarkerFusion()
    with pytest.raises(PropertyError) as caught:
        model.observe([ball(0.0, 0.0), marker], 1.0)
    assert caught.value.code == "bad-value"
    assert not told(model)


def test_a_model_that_is_merged_again_counts_once() -> None:
    one, other = MarkerFusion(), MarkerFusion()
    one.observe([ball(0.0, 0.0), ball(3.0, 0.0)], 1.0)
    for _ in range(3):
        other.merge("one", one.things(), 1.0)
    assert told(other) == [("ball-1", 1), ("ball-2", 1)]
    one.observe([ball(0.1, 0.0)], 1.0)
    other.merge("one", one.things(), 1.0)
    found = [each.variance for each in other.things()]
    assert found == pytest.approx([each.variance for each in one.things()])
    one.observe([ball(7.0, 0.0, time=2.0)], 1.0)
    other.merge("one", one.things(), 1.0)
    assert len(told(other)) == 3


def test_a_thing_that_drifts_is_merged_by_what_is_new() -> None:
    one, other = MarkerFusion(drift=0.1), MarkerFusion(drift=0.1)
    for step in range(20):
        one.observe([ball(0.1 * step, 0.0, time=float(step))], 100.0)
        other.merge("one", one.things(), 100.0)
    assert told(other) == [("ball-1", 20)]
    assert only(other).location[0] == pytest.approx(1.9, abs=0.2)  # type: ignore[index]
    assert only(other).variance > 0.5 * only(one).variance  # type: ignore[operator]


def test_a_grid_has_means() -> None:
    grid = Grid(0.5)
    for x, y, value in ((0.1, 0.1, 20.0), (0.4, 0.4, 22.0), (1.2, -0.3, 5.0)):
        grid.observe(x, y, value)
    assert grid.at(0.2, 0.2) == (2, 21.0)
    assert grid.rows(0) == [[0, 0, 1], [2, 0, 0]]
    assert str(grid.rows(1)) == "[[nan, nan, 5.0], [21.0, nan, nan]]"
    assert grid.origin() == (0.0, -0.5, 0.5)


def test_a_grid_is_bounded() -> None:
    grid = Grid(0.5)
    grid.observe(0.0, 0.0, 1.0)
    for far in (1e300, 0.5 * MOST_CELLS, -1e9):
        with pytest.raises(PropertyError):
            grid.observe(far, far, 1.0)
    with pytest.raises(PropertyError):
        grid.observe(float("nan"), 0.0, 1.0)
    for nowhere in (float("nan"), float("inf")):
        with pytest.raises(PropertyError, match="finite"):
            grid.at(nowhere, 0.0)
    assert grid.rows(1) == [[1.0]]


def test_a_merged_grid_counts_once() -> None:
    one, other, third = (Grid(0.5, model) for model in ("one", "other", "third"))
    one.observe(-0.7, 0.2, 10.0)
    other.observe(-0.7, 0.2, 20.0)
    for value in (12.0, 11.0):
        one.observe(2.0, 1.0, value)
        other.merge(one.shares())
        third.merge(other.shares())
        one.merge(third.shares())
    for each in (one, other, third):
        assert each.at(-0.7, 0.2) == (2, 15.0)
        assert each.at(2.0, 1.0) == (2, 11.5)
    with pytest.raises(PropertyError):
        Grid(0.2, "fourth").merge(one.shares())
