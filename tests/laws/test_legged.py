"""Laws of the legged robot: its feet on the ground never slip, and always carry it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rtkit
from rtkit.services.legged import (
    COXA,
    FEMUR,
    LEGS,
    TIBIA,
    Foot,
    Leg,
    LeggedRobot,
    Legs,
    Point,
    in_base,
    joints,
)
from rtkit.services.world import HomeWorld
from rtkit.world import Polygon, Scene

speeds = st.one_of(st.just(0.0), st.floats(-0.5, 0.5))
twists = st.tuples(speeds, speeds, st.one_of(st.just(0.0), st.floats(-2.0, 2.0)))
commands = st.lists(st.tuples(twists, st.floats(0.01, 0.2), st.integers(1, 12)), max_size=6)


def step(legs: Legs, home: HomeWorld, twist: Any, seconds: float) -> None:
    """Move the body as the legs allow it, as far as walls do."""
    home.set_moves([("walker", *legs.possible(twist, seconds), seconds)])
    legs.moved(home.get_poses(["walker"])[0], seconds)


def foot_of(leg: Leg, angles: Point) -> Point:
    """Return where the foot is in the base at angles of hip, femur and tibia [m]."""
    yaw, femur, tibia = angles
    out = COXA + FEMUR * math.cos(femur) + TIBIA * math.cos(femur + tibia)
    bearing = leg.out + yaw
    height = FEMUR * math.sin(femur) + TIBIA * math.sin(femur + tibia)
    return leg.x + out * math.cos(bearing), leg.y + out * math.sin(bearing), height


def check(legs: Legs, before: tuple[Foot, ...], pose: tuple[float, ...]) -> None:
    down = [foot for foot in legs.feet if foot.is_down]
    assert len(down) >= 3
    for was, now in zip(before, legs.feet, strict=True):
        if was.is_down and now.is_down:
            assert now.at == was.at  # it has not slipped
        if now.is_down:
            assert now.at[2] == pytest.approx(0.0)
        else:
            assert now.at[2] >= 0.0
    if legs.pose != pose:
        carriers = [w for w, n in zip(before, legs.feet, strict=True) if w.is_down]
        assert len(carriers) >= 3  # it has moved over feet that stood
    for leg, foot in zip(LEGS, legs.feet, strict=True):
        place = in_base(foot.at, legs.pose)
        angles = joints(leg, place)
        if foot.is_down:
            assert angles is not None
        if angles is not None:
            assert foot_of(leg, angles) == pytest.approx(place, abs=1e-9)
    assert is_over([foot.at[:2] for foot in down], legs.pose[:2])


def is_over(corners: list[Any], place: Any) -> bool:
    """Return whether a place is inside of the hull of others."""
    away = np.array(corners) - place
    bearings = np.sort(np.arctan2(away[:, 1], away[:, 0]))
    gaps = np.diff([*bearings, bearings[0] + math.tau])
    return bool(gaps.max() < math.pi)


@settings(max_examples=60, deadline=None)
@given(commands, st.booleans())
def test_feet_on_the_ground_never_slip_and_carry_the_body(moves: Any, has_walls: bool) -> None:
    home = HomeWorld(pace=0)
    if has_walls:
        walls = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)]
        home._scene = Scene([Polygon([(-1, -1), (1, -1), (1, 1), (-1, 1)], [walls])])
    legs = LeggedRobot(world=home, body="walker")._chassis
    assert isinstance(legs, Legs)
    home.bodies.set("walker", rtkit.Marker(legs.pose[:2], radius=0.2))
    for twist, seconds, times in moves:
        for _ in range(times):
            before, pose = legs.feet, legs.pose
            step(legs, home, twist, seconds)
            check(legs, before, pose)
    for _ in range(40):
        before, pose = legs.feet, legs.pose
        step(legs, home, (0.0, 0.0, 0.0), 0.05)
        check(legs, before, pose)
    assert legs.is_settled


@given(twists)
def test_it_goes_where_it_is_driven_in_the_end(twist: Any) -> None:
    """No command leaves it with its legs in a knot."""
    home = HomeWorld(pace=0)
    legs = LeggedRobot(world=home, body="walker")._chassis
    assert isinstance(legs, Legs)
    home.bodies.set("walker", rtkit.Marker(legs.pose[:2], radius=0.2))
    went = 0.0
    for _ in range(60):
        before = legs.pose
        step(legs, home, twist, 0.05)
        went += math.dist(before, legs.pose)
    wanted = math.hypot(twist[0], twist[1]) + abs(twist[2])
    assert went > 0.5 * min(wanted, 0.2) * 3 or wanted < 1e-3
