"""Laws of fusion: order, variance, one model or two; each compared with a reference in numpy."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as some

from rtkit import Marker, PropertyError
from rtkit.services.fusion import Estimate, MarkerFusion, difference, distance, fuse, inverse

SIZES = some.sampled_from([2, 3, 6])
PLACES = some.floats(-2.0, 2.0)
SPREADS = some.floats(1e-3, 1.0)


@some.composite
def covariances(draw: Any, size: int) -> numpy.ndarray:
    factor = numpy.array([[draw(PLACES) for _ in range(size)] for _ in range(size)]) * 0.2
    made: numpy.ndarray = factor @ factor.T + draw(SPREADS) * numpy.eye(size)
    return made


@some.composite
def looks(draw: Any, size: int | None = None, angle: float = 0.5) -> Marker:
    size = size or draw(SIZES)
    place = [draw(PLACES) for _ in range(size)]
    place[3:] = [each / 2.0 * angle for each in place[3:]]
    covariance = draw(covariances(size))
    return Marker(place, type="ball", covariance=covariance.tolist(), time=1.0)


@some.composite
def many(draw: Any) -> list[Marker]:
    return draw(some.lists(looks(draw(SIZES)), min_size=1, max_size=6))  # type: ignore[no-any-return]


def reference(seen: list[Marker]) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Return mean and covariance by the normal equations of weighted least squares."""
    informations = [numpy.linalg.inv(numpy.array(each.covariance)) for each in seen]
    total = sum(informations)
    weighted = sum(
        each @ numpy.array(look.location) for each, look in zip(informations, seen, strict=True)
    )
    return numpy.linalg.solve(total, weighted), numpy.linalg.inv(total)


def fused(seen: list[Marker], gate: float = math.inf) -> Marker:
    model = MarkerFusion(gate=gate)
    for each in seen:
        model.observe([each], 1.0)
    (thing,) = model.things()
    return thing


def spread(marker: Marker) -> numpy.ndarray:
    assert marker.location is not None
    if marker.variance is not None:
        return marker.variance * numpy.eye(len(marker.location))
    return numpy.array(marker.covariance)


def assert_alike(one: Marker, other: Marker) -> None:
    assert one.location is not None
    assert other.location is not None
    assert numpy.allclose(one.location, other.location, atol=1e-6)
    assert numpy.allclose(spread(one), spread(other), rtol=1e-6, atol=1e-9)
    assert one.features["count"] == other.features["count"]
    assert one.time == other.time
    assert (one.confidence or 0.0) == pytest.approx(other.confidence or 0.0)


@given(some.integers(1, 6).flatmap(covariances))
def test_the_inverse_is_that_of_numpy(rows: numpy.ndarray) -> None:
    assert numpy.allclose(inverse(rows.tolist()), numpy.linalg.inv(rows), rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("rows", [[[0.0]], [[-1.0]], [[1.0, 2.0], [2.0, 1.0]], [[math.nan]]])
def test_what_is_no_covariance_is_refused(rows: list[list[float]]) -> None:
    with pytest.raises(PropertyError) as caught:
        inverse(rows)
    assert caught.value.code == "bad-value"


@given(many())
def test_fused_as_by_least_squares(seen: list[Marker]) -> None:
    found = fused(seen)
    mean, covariance = reference(seen)
    assert numpy.allclose(numpy.array(found.location), mean, atol=1e-6)
    assert numpy.allclose(spread(found), covariance, rtol=1e-6, atol=1e-9)
    assert found.features["count"] == len(seen)


@given(many(), some.randoms())
def test_the_order_does_not_matter(seen: list[Marker], chance: Any) -> None:
    other = list(seen)
    chance.shuffle(other)
    assert_alike(fused(seen), fused(other))


@given(many())
def test_the_variance_shrinks_with_each_look(seen: list[Marker]) -> None:
    for fewer, more in pairwise([seen[:end] for end in range(1, len(seen) + 1)]):
        less = spread(fused(fewer)) - spread(fused(more))
        assert numpy.linalg.eigvalsh(less).min() > -1e-9


@given(looks(2), looks(3))
def test_a_place_on_the_floor_tells_nothing_of_the_height(flat: Marker, whole: Marker) -> None:
    found, other = fused([flat, whole]), fused([whole, flat])
    assert_alike(found, other)
    information = numpy.linalg.inv(numpy.array(whole.covariance))
    information[:2, :2] += numpy.linalg.inv(numpy.array(flat.covariance))
    assert numpy.allclose(spread(found), numpy.linalg.inv(information), rtol=1e-6, atol=1e-9)


@given(looks(), looks())
def test_the_distance_is_that_of_mahalanobis(one: Marker, other: Marker) -> None:
    assert one.location is not None
    assert other.location is not None
    size = min(len(one.location), len(other.location))
    apart = numpy.array(one.location[:size]) - numpy.array(other.location[:size])
    both = spread(one)[:size, :size] + spread(other)[:size, :size]
    expected = math.sqrt(apart @ numpy.linalg.solve(both, apart))
    made = [Estimate(each.location or (), spread(each).tolist()) for each in (one, other)]
    assert distance(*made) == pytest.approx(expected, rel=1e-6, abs=1e-9)
    if expected > 1e-3:
        assert distance(*made, bound=expected * 0.99) is None


@given(some.floats(-3.0, 3.0), some.floats(-0.1, 0.1))
def test_angles_meet_on_the_short_way(yaw: float, turn: float) -> None:
    near = ((0.0,) * 5 + (math.pi + turn,), (0.0,) * 5 + (-math.pi - turn,))
    rows = tuple(map(tuple, numpy.eye(6).tolist()))
    met = fuse(Estimate(near[0], rows), Estimate(near[1], rows))
    assert abs(difference(met.mean, (0.0,) * 5 + (math.pi,))[5]) < 1e-6
    assert difference((0.0,) * 5 + (yaw,), (0.0,) * 5 + (yaw + math.tau,))[5] == pytest.approx(0)


@given(many(), some.integers(0, 6), some.integers(0, 6))
def test_two_models_that_are_merged_know_what_one_would(
    seen: list[Marker], first: int, second: int
) -> None:
    """Each model has some of the looks; they are merged whenever, also twice."""
    shared, left, right = (
        MarkerFusion(gate=math.inf),
        MarkerFusion(gate=math.inf),
        MarkerFusion(gate=math.inf),
    )
    shared.merge("left", left.things(), 1.0)
    for number, look in enumerate(seen):
        (left if number % 2 else right).observe([look], 1.0)
        if number in (first, second):
            shared.merge("left", left.things(), 1.0)
            shared.merge("right", right.things(), 1.0)
    for _ in range(2):
        shared.merge("left", left.things(), 1.0)
        shared.merge("right", right.things(), 1.0)
    (thing,) = shared.things()
    assert_alike(thing, fused(seen))


@given(some.lists(some.floats(0.05, 1.0), min_size=1, max_size=5), some.randoms())
def test_who_is_less_sure_counts_less(confidences: list[float], chance: Any) -> None:
    seen = [Marker((float(i), 0.0), variance=0.1, confidence=c, time=1.0)
            for i, c in enumerate(confidences)]  # fmt: skip
    found = fused(seen)
    weights = numpy.array(confidences)
    assert found.location is not None
    assert found.location[0] == pytest.approx(numpy.average(range(len(seen)), weights=weights))
    assert found.confidence == pytest.approx(1.0 - numpy.prod(1.0 - weights))
    other = list(seen)
    chance.shuffle(other)
    assert_alike(found, fused(other))
