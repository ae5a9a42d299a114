"""Geometry of the simulated world: compared with the slow way to know the same."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rtkit.world import Body, Polygon, Pose, Scene, moved

EPS = 1e-8
Segment = tuple[tuple[float, float], tuple[float, float]]
angles = st.floats(-7.0, 7.0)
speeds = st.floats(-1.0, 1.0)
turns = st.one_of(
    st.sampled_from([0.0, 5e-324, -1e-160]), st.floats(-1e-7, 1e-7), st.floats(-3.0, 3.0)
)


@st.composite
def polygons(draw: st.DrawFn) -> Polygon:
    """Return a star-shaped polygon, mostly not convex, with corners off any grid."""
    x, y = draw(st.floats(-4, 4)), draw(st.floats(-4, 4))
    count = draw(st.integers(3, 8))
    radii = draw(st.lists(st.floats(0.3, 2.0), min_size=count, max_size=count))
    turn = draw(st.floats(0, 1))
    corners = [
        (x + r * math.cos(a), y + r * math.sin(a))
        for r, a in ((r, (i + turn) * math.tau / count) for i, r in enumerate(radii))
    ]
    return Polygon(corners)


scenes = st.lists(polygons(), min_size=1, max_size=3).map(Scene)
points = st.tuples(st.floats(-6, 6), st.floats(-6, 6))


def segments(scene: Scene) -> list[Segment]:
    return [
        (ring[i - 1], ring[i])
        for wall in scene.walls
        for ring in wall.rings
        for i in range(len(ring))
    ]


def far(point: tuple[float, float], segment: Segment) -> float:
    (ax, ay), (bx, by) = segment
    dx, dy = bx - ax, by - ay
    along = ((point[0] - ax) * dx + (point[1] - ay) * dy) / (dx * dx + dy * dy)
    along = min(1.0, max(0.0, along))
    return math.dist(point, (ax + along * dx, ay + along * dy))


def crossed(point: tuple[float, float], bearing: float, segment: Segment) -> float:
    """Return how far along a ray a segment is, by solving the two equations."""
    (ax, ay), (bx, by) = segment
    cx, cy = math.cos(bearing), math.sin(bearing)
    under = cx * (by - ay) - cy * (bx - ax)
    if under == 0:
        return math.inf
    wx, wy = ax - point[0], ay - point[1]
    length = (wx * (by - ay) - wy * (bx - ax)) / under
    share = (wx * cy - wy * cx) / under
    return length if length >= 0 and 0 <= share <= 1 else math.inf


@given(scenes, points, st.lists(angles, min_size=1, max_size=9))
def test_rays_end_at_the_nearest_segment_that_they_cross(scene, point, bearings) -> None:
    assume(scene.distance(point) > 0.01)
    found = scene.rays(point, bearings, 5.0)
    for bearing, length in zip(bearings, found, strict=True):
        slow = min(5.0, *(crossed(point, bearing, each) for each in segments(scene)))
        grazing = any(
            abs(crossed(point, bearing + by, each) - slow) > 0.01
            for by in (-1e-9, 1e-9)
            for each in segments(scene)
            if crossed(point, bearing, each) == slow
        )
        assert grazing or length == pytest.approx(slow, abs=1e-6)


@given(scenes, points)
def test_distance_is_that_of_the_nearest_segment(scene, point) -> None:
    slow = min(far(point, each) for each in segments(scene))
    assert abs(scene.distance(point)) == pytest.approx(slow, abs=1e-9)
    assert math.dist(point, scene.nearest(point)) == pytest.approx(slow, abs=1e-9)


@given(scenes, points, angles, st.floats(0.0, 7.0))
@settings(max_examples=60)
def test_cone_sees_what_dense_rays_see(scene, point, bearing, width) -> None:
    assume(scene.distance(point) > 0.1)
    width = min(width, math.tau)
    seen = scene.cone(point, bearing, width, 4.0)
    dense = scene.rays(point, np.linspace(bearing - width / 2, bearing + width / 2, 3000), 4.0)
    assert seen <= dense.min() + EPS
    # Rays that are so near to each other miss no more than this of a wall that is so near.
    assert dense.min() <= seen + 0.05 or scene.cone(point, bearing, width - 0.01, 4.0) > seen


@given(points, angles, speeds, speeds, turns, st.floats(0, 9), st.floats(0, 9))
def test_two_motions_lead_where_one_does(place, theta, vx, vy, omega, first, second) -> None:
    start = Pose(*place, theta)
    twice = moved(moved(start, vx, vy, omega, first), vx, vy, omega, second)
    once = moved(start, vx, vy, omega, first + second)
    assert math.dist(twice[:2], once[:2]) < 1e-9
    assert abs(math.remainder(twice.theta - once.theta, math.tau)) < 1e-9
    assert -math.pi < once.theta <= math.pi


def slow_contact(scene: Scene, start: Pose, radius: float, twist: tuple, dt: float) -> float:
    """Return when a body first is nearer than its radius, by fine steps and halving."""
    steps = 400
    for step in range(1, steps + 1):
        if scene.distance(moved(start, *twist, dt * step / steps)[:2]) < radius:
            low, high = dt * (step - 1) / steps, dt * step / steps
            for _ in range(60):
                middle = (low + high) / 2
                is_in = scene.distance(moved(start, *twist, middle)[:2]) < radius
                low, high = (low, middle) if is_in else (middle, high)
            return high
    return dt


radii = st.sampled_from([0.0, 0.1, 0.5])


@given(scenes, points, angles, speeds, speeds, turns, st.floats(0.1, 6.0), radii)
@settings(max_examples=150, deadline=None)
def test_contact_is_when_fine_steps_find_it(scene, place, theta, vx, vy, omega, dt, radius) -> None:
    start = Pose(*place, theta)
    assume(scene.distance(place) > radius + 1e-6)
    twist = (vx, vy, omega)
    found = scene.contact(start, radius, twist, dt)
    time = dt if found is None else found.time
    # What only grazes a wall may slip between two fine steps, so that the other way is bounded.
    assert time <= slow_contact(scene, start, radius, twist, dt) + 1e-6
    if found is not None:
        there = moved(start, *twist, found.time)
        assert scene.gap(there[:2]) == pytest.approx(radius, abs=EPS)
        x, y = scene.nearest(there[:2])
        assert math.hypot(*found.normal) == pytest.approx(1.0)
        if radius:
            away = ((there.x - x) / radius, (there.y - y) / radius)
            assert math.dist(away, found.normal) < 1e-4


moves = st.lists(st.tuples(speeds, speeds, turns, st.floats(0.01, 3.0)), max_size=12)


@given(scenes, points, angles, moves, radii)
@settings(max_examples=150, deadline=None)
def test_body_is_never_in_a_wall(scene, place, theta, steps, radius) -> None:
    assume(scene.distance(place) > radius)
    body = Body(scene, Pose(*place, theta), radius)
    for vx, vy, omega, dt in steps:
        before = body.pose
        time = body.move(vx, vy, omega, dt)
        assert 0 <= time <= dt
        assert body.pose == moved(before, vx, vy, omega, time)
        assert body.clearance > radius - EPS
        if time < dt:
            assert body.is_touching
            body.move(-vx, -vy, -omega, min(0.01, time))  # the way that it came is free


@given(scenes, points, angles, moves)
@settings(max_examples=30, deadline=None)
def test_the_same_moves_lead_to_the_same_place(scene, place, theta, steps) -> None:
    assume(scene.distance(place) > 0.1)
    ends = set()
    for _ in range(2):
        body = Body(Scene(scene.walls), Pose(*place, theta), 0.1)
        for step in steps:
            body.move(*step)
        ends.add((body.pose, body.collisions, body.pressed))
    assert len(ends) == 1
