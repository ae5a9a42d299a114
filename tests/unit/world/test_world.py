"""The simulated world: what a body meets, what sensors see of it, and what noise makes of that."""

from __future__ import annotations

import math
import subprocess
import sys
import time

import numpy as np
import pytest

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.world import Body, Bumper, Noise, Odometry, Polygon, Pose, Scene, moved

BOX = Polygon([(1, -1), (3, -1), (3, 1), (1, 1)])
ROOM = Polygon([(-5, -5), (5, -5), (5, 5), (-5, 5)], [[(-4, -4), (4, -4), (4, 4), (-4, 4)]])
SPIRAL = Polygon(  # 24 edges
    [(math.cos(a) * r, math.sin(a) * r) for a, r in ((i / 2, 2 + i / 8) for i in range(12))]
    + [(math.cos(a) * r, math.sin(a) * r) for a, r in ((i / 2, 1.7 + i / 8) for i in range(12))][
        ::-1
    ]
)


@pytest.mark.parametrize(
    ("outer", "why"),
    [
        ([(0, 0), (1, 0)], "three corners"),
        ([(0, 0), (1, 0), (2, 0)], "an area"),
        ([(0, 0), (1, 0), (1, math.nan)], "finite"),
        ([(0, 0), (1, 0), (1,)], "pairs of numbers"),
    ],
)
def test_a_ring_without_area_is_refused(outer, why) -> None:
    with pytest.raises(Malformed, match=why):
        Polygon(outer)


def test_corners_may_come_in_either_order() -> None:
    assert Scene([Polygon(BOX.outer[::-1])]).distance((2, 0)) == -1
    assert Scene([BOX]).distance((2, 0)) == -1


def test_a_hole_is_a_free_room() -> None:
    scene = Scene([ROOM])
    assert scene.distance((0, 0)) == 4
    assert scene.distance((4.5, 0)) == -0.5
    assert scene.distance((6, 0)) == 1
    assert list(scene.rays((0, 0), (0, math.pi / 2), 9.0)) == [4, pytest.approx(4)]


def test_a_ray_along_a_wall_ends_nowhere_and_one_at_a_corner_does() -> None:
    scene = Scene([BOX])
    assert scene.rays((0, 0), (math.atan2(1, 1),), 9.0)[0] == pytest.approx(math.sqrt(2))
    assert scene.rays((0, 2), (0.0,), 9.0)[0] == 9.0


def test_a_point_at_a_wall_sees_it_only_ahead() -> None:
    scene = Scene([BOX])
    assert list(scene.rays((1, 0), (0.0, math.pi), 9.0)) == [0.0, 9.0]
    assert scene.cone((1, 0), 0.0, 0.4, 9.0) == 0.0
    assert scene.cone((1, 0), math.pi, 0.4, 9.0) == 9.0


def test_a_cone_sees_the_nearest_place_within_it() -> None:
    scene = Scene([BOX])
    assert scene.cone((0, 0), 0.0, 0.4, 2.0) == 1.0
    assert scene.cone((0, 0), 0.5, 0.4, 2.0) == pytest.approx(1 / math.cos(0.3))
    assert scene.cone((0, 0), math.pi, 0.4, 2.0) == 2.0
    assert scene.cone((0, 0), math.pi, math.tau, 2.0) == 1.0
    assert scene.cone((0, 0), math.pi, 0.0, 2.0) == 2.0


def test_a_cone_with_a_side_all_but_parallel_to_a_wall_sees_it() -> None:
    scene = Scene([BOX])
    for off in (0.0, 1e-308, 1e-200, 1e-17):
        assert scene.cone((0, 1 - 1e-9), 0.2 + off, 0.4, 9.0) == pytest.approx(1.0)
        assert scene.cone((0, 0), math.pi / 2 - 0.2 + off, 0.4, 9.0) == 9.0


def test_nothing_is_seen_or_met_in_an_empty_scene() -> None:
    scene = Scene()
    assert scene.distance((0, 0)) == math.inf
    assert list(scene.rays((0, 0), (0.0,), 4.0)) == [4.0]
    assert scene.cone((0, 0), 0.0, 0.4, 2.0) == 2.0
    assert Body(scene, Pose(), 0.1).move(1, 0, 0, 9) == 9
    with pytest.raises(NotFound, match="empty"):
        scene.nearest((0, 0))


def test_an_omnidirectional_body_moves_to_its_left() -> None:
    there = moved(Pose(0, 0, math.pi / 2), 0, 1, 0, 2)
    assert there == pytest.approx((-2, 0, math.pi / 2))


def test_a_body_stops_where_it_touches() -> None:
    body = Body(Scene([BOX]), Pose(0, 0, 0), 0.25)
    assert body.move(0.5, 0, 0, 4) == pytest.approx(1.5)
    assert body.pose == pytest.approx((0.75, 0, 0))
    assert body.is_touching
    assert body.contact is not None
    assert body.contact.normal == pytest.approx((-1, 0))


def test_a_body_on_a_circle_stops_where_it_touches() -> None:
    body = Body(Scene([Polygon([(-9, 1), (9, 1), (9, 2), (-9, 2)])]), Pose(), 0.0)
    assert body.move(math.pi, 0, math.pi, 1) == pytest.approx(0.5, abs=1e-6)


def test_a_touching_body_turns_slides_and_leaves() -> None:
    body = Body(Scene([BOX]), Pose(0, 0, 0), 0.25)
    body.move(1, 0, 0, 1)
    assert body.move(0, 0, 1, 1) == 1
    assert body.move(0, 0, -1, 1) == 1
    assert body.move(0, 0.1, 0, 1) == 1
    assert body.move(-0.1, 0, 0, 1) == 1
    assert not body.is_touching
    assert body.collisions == 1


def test_pressing_by_more_than_a_centimetre_is_one_collision() -> None:
    body = Body(Scene([BOX]), Pose(0.7, 0, 0), 0.25)
    body.move(0.1, 0, 0, 0.55)
    assert (body.collisions, body.pressed) == (0, pytest.approx(0.005))
    for _ in range(5):
        body.move(0.1, 0, 0, 0.05)
    assert (body.collisions, body.pressed) == (1, pytest.approx(0.03))
    body.move(-1, 0, 0, 0.1)
    body.move(1, 0, 0, 0.2)
    assert body.collisions == 2


def test_a_body_does_not_begin_in_a_wall() -> None:
    with pytest.raises(Refused, match=r"radius 0\.5 at \(0\.8, 0\) is in a wall"):
        Body(Scene([BOX]), Pose(0.8, 0, 0), 0.5)
    with pytest.raises(Malformed, match="-1"):
        Body(Scene(), Pose(), -1)


def test_switches_close_by_sector() -> None:
    body, bumper = Body(Scene([BOX]), Pose(0.6, 0, 0), 0.35), Bumper()
    assert bumper.closed(body) == (False,) * 6
    body.move(1, 0, 0, 1)
    assert bumper.closed(body) == (True, False, False, False, False, False)
    body.move(0, 0, math.tau / 6, 1)  # what was ahead is to the right now
    assert bumper.closed(body) == (False, False, False, False, False, True)
    body.move(-0.02, 0, 0, 1)
    assert body.is_touching is False
    assert bumper.closed(body)[5] is True  # within a centimetre
    body.move(-0.05, 0, 0, 1)
    assert bumper.closed(body) == (False,) * 6


def test_objects_come_move_and_go() -> None:
    scene, part = Scene([ROOM]), Polygon([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
    scene.add("part", part, Pose(2, 0, math.pi / 4))
    assert scene.rays((0, 0), (0.0,), 9.0)[0] == pytest.approx(2 - math.sqrt(0.5))
    assert scene.touched((2, 0)) == ("part",)
    assert scene.touched((1, 0), 0.3) == ("part",)
    assert scene.touched((1, 0), 0.2) == ()
    body = Body(scene, Pose(), 0.1)
    body.move(1, 0, 0, 3)
    assert body.contact is not None
    assert scene.object_of(body.contact) == "part"
    assert body.touched_objects == ("part",)
    scene.move("part", Pose(2, 2, 0))
    assert (body.touched_objects, body.is_touching) == ((), False)
    body.move(1, 0, 0, 9)
    assert body.contact is not None
    assert scene.object_of(body.contact) == ""
    assert body.pose.x == pytest.approx(3.9)
    scene.remove("part")
    assert scene.objects == {}
    assert scene.distance((2, 2)) == 2
    for ask in (scene.remove, scene.shape, lambda name: scene.move(name, Pose())):
        with pytest.raises(NotFound, match="no object part"):
            ask("part")
    scene.add("part", part)
    with pytest.raises(Refused, match="part already"):
        scene.add("part", part)


def test_a_body_that_an_object_was_put_on_can_only_leave() -> None:
    scene = Scene()
    body = Body(scene, Pose(0.9, 0, 0), 0.25)
    scene.add("box", BOX)
    assert body.move(1, 0, 0, 1) == 0
    assert body.move(-1, 0, 0, 1) == 1


def test_noise_is_that_of_its_seed_and_leaves_what_had_no_echo() -> None:
    ranges = [1.0, 4.0, 0.001, 2.0]
    noisy = Noise(0.05, seed=3).on(ranges, 4.0)
    assert noisy == Noise(0.05, seed=3).on(np.array(ranges), 4.0)
    assert noisy != Noise(0.05, seed=4).on(ranges, 4.0)
    assert noisy[1] == 4.0
    assert all(0 <= each <= 4 for each in noisy)
    assert Noise(0.0).on(ranges, 4.0) == ranges
    many = Noise(0.05, seed=1).on([2.0] * 4000, 4.0)
    assert np.std(many) == pytest.approx(0.05, rel=0.1)
    with pytest.raises(Malformed, match="0 or more"):
        Noise(-1)


def drive(odometry: Odometry) -> Pose:
    pose = Pose()
    for _ in range(100):
        pose = moved(pose, 1, 0, 0.5, 0.1)
        odometry.follow(pose)
    return pose


def test_odometry_drifts_as_its_seed_says() -> None:
    exact = Odometry(Pose())
    assert drive(exact) == exact.pose
    drifting = [Odometry(Pose(), 0.02, 0.02, 0.02, seed=seed) for seed in (1, 1, 2)]
    true, _, _ = map(drive, drifting)
    assert drifting[0].pose == drifting[1].pose != drifting[2].pose
    assert 0 < math.dist(drifting[0].pose[:2], true[:2]) < 1.5


def test_odometry_without_errors_of_heading_keeps_the_heading() -> None:
    odometry = Odometry(Pose(), travel=0.1, seed=5)
    true = drive(odometry)
    assert odometry.pose.theta == pytest.approx(true.theta)
    assert odometry.pose != true


def quickest_ms(work, count: int = 20) -> float:
    best = math.inf
    for _ in range(count):
        began = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - began)
    return best * 1e3


def test_a_scan_and_a_step_are_quick() -> None:
    """181 rays against 24 edges, and 0.5 s of a body beside the wall: in the best of 20."""
    scene, bearings = Scene([SPIRAL]), np.radians(np.arange(-90, 91))
    assert len(SPIRAL.outer) == 24
    body = Body(scene, Pose(0, 0, 0), 0.1)

    def step() -> None:
        for _ in range(10):
            body.move(0.4, 0, 1.5, 0.05)

    assert quickest_ms(lambda: scene.rays((0, 0), bearings, 4.0)) < 0.2
    assert quickest_ms(step) < 1


def test_without_numpy_the_extra_is_named() -> None:
    script = (
        "import sys; sys.modules['numpy'] = None\n"
        "from rtkit.world import Polygon, Pose, Noise\n"
        "try:\n    from rtkit.world import Scene\n"
        "except ImportError as error:\n    print(error)\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "rtkit.world needs numpy: pip install 'rtkit[sim]'\n", done.stderr


DISC = np.array([(3.0, 0.0, 0.5)])


def test_a_body_is_stopped_by_a_disc_where_their_rims_meet() -> None:
    for scene in (Scene(), Scene([ROOM])):
        body = Body(scene, Pose(), 0.25)
        assert body.move(1.0, 0.0, 0.0, 10.0, DISC) == pytest.approx(2.25)
        assert body.pose == pytest.approx((2.25, 0.0, 0.0))
        assert body.contact is not None
        assert body.contact.normal == pytest.approx((-1.0, 0.0))
        assert (body.contact.edge, scene.object_of(body.contact)) == (-1, "")
        assert body.collisions == 1
        assert body.move(1.0, 0.0, 0.0, 1.0, DISC) == pytest.approx(0.0)
        assert body.move(-1.0, 0.0, 0.0, 1.0, DISC) == 1.0  # away from it, it goes


def test_a_disc_is_met_aside_and_along_an_arc() -> None:
    grazing = Body(Scene(), Pose(0.0, 0.6), 0.5)  # 3-4-5: centres are 1 apart, 0.6 of it aside
    assert grazing.move(1.0, 0.0, 0.0, 10.0, DISC) == pytest.approx(3.0 - 0.8)
    assert Body(Scene(), Pose(0.0, 1.1), 0.5).move(1.0, 0.0, 0.0, 10.0, DISC) == 10.0
    turning = Body(Scene(), Pose(), 0.0)  # a circle round (0, 1): at its top after half a turn
    top = np.array([(0.0, 2.0, math.sqrt(0.5))])
    chord = 2 * math.asin(math.sqrt(0.5) / 2)  # what the radius of the disc is of the circle
    assert turning.move(1.0, 0.0, 1.0, 4.0, top) == pytest.approx(math.pi - chord)


def test_what_is_met_first_stops_whichever_it_is() -> None:
    near = np.array([(0.6, 0.0, 0.1), (0.8, 0.0, 0.1)])
    for discs, far in ((DISC, 1.0), (near, 0.5)):
        body = Body(Scene([BOX]), Pose())
        assert body.move(1.0, 0.0, 0.0, 5.0, discs) == pytest.approx(far)
        assert body.contact is not None
        assert (body.contact.edge == -1) is (far == 0.5)


def test_bodies_that_stand_in_each_other_may_go_apart_only() -> None:
    body = Body(Scene(), Pose(2.6, 0.0), 0.25)
    assert body.move(1.0, 0.0, 0.0, 1.0, DISC) == 0.0
    assert body.move(-1.0, 0.0, 0.0, 1.0, DISC) == 1.0


def test_rays_end_at_a_disc_seen_from_outside() -> None:
    for scene, free in ((Scene(), 9.0), (Scene([ROOM]), 4.0)):
        found = scene.rays((0.0, 0.0), (0.0, math.pi, math.asin(0.5 / 3) + 1e-6), 9.0, DISC)
        assert found[:2].tolist() == pytest.approx([2.5, free])
        assert found[2] > 2.99
    assert Scene().rays((0.0, 0.3), (0.0,), 9.0, DISC)[0] == pytest.approx(3.0 - 0.4)  # 3-4-5
    assert Scene().rays((3.1, 0.0), (0.0, math.pi), 9.0, DISC).tolist() == [9.0, 9.0]  # its own
    assert Scene().rays((0.0, 0.0), (0.0,), 2.0, DISC)[0] == 2.0
    assert Scene([BOX]).rays((0.0, 0.0), (0.0,), 9.0, DISC)[0] == 1.0
