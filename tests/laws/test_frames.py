"""Laws of frames: a reading asked in two frames agrees with the locations, over two robots, too."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from rtkit.services.frames import (
    Frames,
    Pose,
    compose,
    inverse,
    transform,
    transform_covariance,
)

places = st.floats(-50, 50)
angles = st.floats(-3.1, 3.1)
poses = st.tuples(places, places, places, angles, st.floats(-1.5, 1.5), angles)
locations = st.one_of(st.tuples(places, places, places), poses)


def matrix(pose: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the 4x4 matrix of a pose, made the slow way of three turns."""
    made = np.eye(4)
    made[:3, 3] = pose[:3]
    for axis, angle in ((2, pose[5]), (1, pose[4]), (0, pose[3])):
        turn, (i, j) = np.eye(4), [(1, 2), (2, 0), (0, 1)][axis]
        turn[i, i] = turn[j, j] = np.cos(angle)
        turn[i, j], turn[j, i] = -np.sin(angle), np.sin(angle)
        made = made @ turn
    return made


def same(one: Pose, other: Pose) -> bool:
    """Return whether two poses are one: angles may be told in two ways."""
    return bool(np.allclose(matrix(one), matrix(other), atol=1e-7))


@given(poses, poses)
def test_poses_compose_as_matrices_do(outer: Pose, inner: Pose) -> None:
    assert np.allclose(matrix(compose(outer, inner)), matrix(outer) @ matrix(inner), atol=1e-9)
    assert same(compose(inverse(outer), compose(outer, inner)), inner)
    assert same(inverse(inverse(outer)), outer)


@given(poses, poses, locations)
def test_a_reading_in_two_frames_agrees_with_the_locations(
    r1: Pose, r2: Pose, seen: tuple[float, ...]
) -> None:
    robots = {"r1": r1, "r2": r2}
    frames = Frames(robots.__getitem__, base=lambda: r1)
    in_world = transform(r1, seen)
    assert frames.convert(seen) == pytest.approx(in_world, abs=1e-9)
    of_r2 = frames.convert(seen, "r1", "r2")
    assert transform(r2, of_r2)[:3] == pytest.approx(in_world[:3], abs=1e-7)
    back = frames.convert(of_r2, "r2", "base")
    assert back[:3] == pytest.approx(seen[:3], abs=1e-7)
    assert len(seen) == 3 or same(back, seen)


@given(poses, poses)
def test_a_covariance_is_that_of_what_was_moved(pose: Pose, location: Pose) -> None:
    told = np.array(compose(pose, location))
    assume(abs(np.cos(told[4])) > 0.1)  # the slopes are measured in steps
    slope = np.zeros((6, 6))
    for axis in range(6):
        near = list(location)
        near[axis] += 1e-6
        step = np.array(compose(pose, near)) - told
        step[3:] = (step[3:] + np.pi) % (2 * np.pi) - np.pi
        slope[:, axis] = step / 1e-6
    given_ = np.diag([0.1, 0.2, 0.3, 0.01, 0.02, 0.03]) + 0.001
    wanted = slope @ given_ @ slope.T
    found = np.array(transform_covariance(pose, location, given_.tolist()))
    assert np.allclose(found, wanted, rtol=1e-3, atol=1e-4)
    flat = transform_covariance(pose, location[:3], given_[:3, :3].tolist())
    assert np.allclose(flat, found[:3, :3])
