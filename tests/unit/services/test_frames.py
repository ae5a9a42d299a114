"""Frames: poses by hand, names that are unknown, frames that stand in frames."""

from __future__ import annotations

from math import pi

import pytest

import rtkit
from rtkit.services.frames import ORIGIN, Frames, compose, inverse, transform, transform_covariance

AT = (1.0, 2.0, 0.0, 0.0, 0.0, pi / 2)
ROBOTS = {"robots/r1": AT, "robots/r2": (4.0, 2.0, 0.0, 0.0, 0.0, pi)}


def lookup(name: str) -> tuple[float, ...]:
    if name == "slow":
        raise rtkit.PropertyError("timeout", "no answer")
    if name not in ROBOTS:
        raise rtkit.PropertyError("no-service", "nobody has that name")
    return ROBOTS[name]


def test_forward_is_along_the_heading() -> None:
    assert transform(AT, (1.0, 0.0)) == pytest.approx((1.0, 3.0))
    assert transform(AT, (1.0, 0.0, 0.5)) == pytest.approx((1.0, 3.0, 0.5))
    assert compose(AT, (1.0, 0, 0, 0, 0, pi)) == pytest.approx((1, 3, 0, 0, 0, -pi / 2))
    assert compose(inverse(AT), AT) == pytest.approx(ORIGIN)


def test_roll_and_pitch_turn_as_written() -> None:
    assert transform((0, 0, 0, pi / 2, 0, 0), (0, 1, 0)) == pytest.approx((0, 0, 1))
    assert transform((0, 0, 0, 0, pi / 2, 0), (1, 0, 0)) == pytest.approx((0, 0, -1))
    upright = compose((0, 0, 0, 0, pi / 2, 0), (0, 0, 0, 0.3, 0, 0))
    assert transform(upright, (0, 1, 0)) == pytest.approx(
        transform((0, 0, 0, 0, pi / 2, 0), transform((0, 0, 0, 0.3, 0, 0), (0, 1, 0)))
    )


def test_a_covariance_turns_with_its_frame() -> None:
    turned = transform_covariance(AT, (0, 0), ((4.0, 1.0), (1.0, 9.0)))
    assert [*turned[0], *turned[1]] == pytest.approx([9.0, -1.0, -1.0, 4.0])
    with pytest.raises(rtkit.PropertyError, match="2 rows"):
        transform_covariance(AT, (0, 0), ((1.0,),))


def test_what_one_robot_sees_is_told_to_the_other() -> None:
    frames = Frames(lookup, base=lambda: AT)
    assert frames.convert((1, 0), "base", "robots/r2") == pytest.approx((3.0, -1.0))
    assert frames.convert((0, 0, 0, 0, 0, 0), "base") == pytest.approx(AT)
    assert frames.convert((5, 5), "base", "base") == (5.0, 5.0)


def test_a_named_frame_stands_in_another_one() -> None:
    frames = Frames(lookup, base=lambda: AT)
    frames.add("door", (0, 0, 0, 0, 0, pi))
    frames.add("mast", (0.2, 0, 0.5), "base")
    frames.add("eye", (0, 0, 0.1, 0, 0, -pi / 2), "mast")
    assert frames.pose("eye") == pytest.approx((1.0, 2.2, 0.6, 0, 0, 0))
    assert frames.convert((1, 1), "world", "door") == pytest.approx((-1, -1))


@pytest.mark.parametrize("name", ["kitchen", "", "loop"])
def test_an_unknown_frame_is_a_bad_parameter(name: str) -> None:
    frames = Frames(lookup)
    frames.add("loop", ORIGIN, "circle")
    frames.add("circle", ORIGIN, "loop")
    with pytest.raises(rtkit.PropertyError, match="frame") as refused:
        frames.pose(name)
    assert refused.value.code == "bad-parameter"


def test_frames_of_who_is_alone_are_world_and_base() -> None:
    assert Frames().pose("world") == ORIGIN
    with pytest.raises(rtkit.PropertyError, match="no frame: base"):
        Frames().pose("base")
    with pytest.raises(rtkit.PropertyError) as refused:
        Frames().add("base", ORIGIN)
    assert refused.value.code == "bad-value"


def test_who_is_only_silent_is_no_unknown_frame() -> None:
    with pytest.raises(rtkit.PropertyError) as silent:
        Frames(lookup).pose("slow")
    assert silent.value.code == "timeout"


def test_a_location_of_another_size_is_a_bad_value() -> None:
    with pytest.raises(rtkit.PropertyError, match="2, 3 or 6") as refused:
        transform(ORIGIN, (1, 2, 3, 4))
    assert refused.value.code == "bad-value"
