"""Robots by hand: one program for unlike robots, in time that the tests make pass."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

import rtkit
from rtkit.errors import InvalidDocument, Refused
from rtkit.services import driving
from rtkit.services.frames import transform
from rtkit.services.legged import LeggedRobot
from rtkit.services.mobilerobot import DifferentialRobot, MobileRobot
from rtkit.services.world import HomeWorld
from rtkit.world import Polygon, Scene

KINDS = (DifferentialRobot, LeggedRobot, MobileRobot)
Make = Callable[..., Any]


@pytest.fixture
def home() -> HomeWorld:
    return HomeWorld(pace=0)


@pytest.fixture
def enter() -> Iterator[Make]:
    with ExitStack() as stack:
        yield stack.enter_context


def wall(home: HomeWorld, *corners: tuple[float, float]) -> None:
    home._scene = Scene([*home._scene.walls, Polygon(corners)])


def go(robot: Any, seconds: float = 60.0) -> float:
    """Have time pass until the behaviour has ended and the robot stands; return how much."""
    chassis, spent = robot._chassis, 0.0
    while spent < seconds - 1e-9:
        driving.advance(chassis.world, [chassis], 0.05)
        spent += 0.05
        is_led = chassis.running is not None and chassis.running.state == "running"
        if not is_led and chassis.velocity == (0.0, 0.0, 0.0) and chassis.is_settled:
            break
    return spent


def state(robot: Any, name: str = "moveto") -> str:
    return str(getattr(robot.behaviors, f"get_{name}")().attributes["state"])


def one_metre(robot: Any) -> None:
    """The client program: it knows no robot."""
    robot.behaviors.set_moveto(rtkit.Marker((1.0, 0.0)))


@pytest.mark.parametrize("kind", KINDS)
def test_one_program_moves_unlike_robots_a_metre_forward(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    robot = enter(kind(world=home, start=(1.0, 2.0, 0.6)))
    assert state(robot) == "idle"
    one_metre(robot)
    assert state(robot) == "running"
    assert go(robot) < 10
    assert state(robot) == "done"
    wanted = (1 + math.cos(0.6), 2 + math.sin(0.6), 0.6)
    x, y, *_, heading = robot.get_location()
    assert (x, y, heading) == pytest.approx(wanted, abs=0.02)
    assert robot.get_status() == "ready"


@pytest.mark.parametrize("kind", KINDS)
def test_a_marker_kept_in_front_keeps_it_moving(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    robot = enter(kind(world=home, top_speed=0.2))
    for _ in range(40):
        one_metre(robot)
        go(robot, 0.2)
        assert robot.get_status() == "moving"
    assert robot.get_location()[0] > 1.2


@pytest.mark.parametrize("kind", KINDS)
def test_a_route_is_gone_and_what_remains_is_shown(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    robot = enter(kind(world=home))
    corners = [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0, 0.0, 0.0, 0.0, math.pi)]
    robot.behaviors.set_moveto([rtkit.Marker(each, frame="world") for each in corners])
    lengths = []
    while state(robot) == "running":
        told = robot.behaviors.get_moveto()
        lengths.append(len(told.find("remaining").leaf))
        assert told.find("target").find("location").leaf == corners[3 - lengths[-1]]
        go(robot, 0.05)
    assert list(dict.fromkeys(lengths)) == [3, 2, 1]
    x, y, *_, heading = robot.get_location()
    assert (x, y, abs(heading)) == pytest.approx((0, 1, math.pi), abs=0.03)
    assert robot.behaviors.get_moveto().find("remaining").leaf == ()


def test_a_new_target_replaces_the_old_one(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home))
    robot.behaviors.set_moveto(rtkit.Marker((9.0, 0.0)))
    go(robot, 1.0)
    robot.behaviors.set_moveto(rtkit.Marker((0.5, 0.0), frame="world"))
    go(robot)
    assert robot.get_location()[0] == pytest.approx(0.5, abs=0.02)


def test_stop_and_velocity_take_over(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home))
    one_metre(robot)
    go(robot, 0.5)
    robot.set_velocity((0, 0, 0, 0, 0, 0))
    assert state(robot) == "running"  # who drives not at all takes nothing over
    robot.behaviors.stop()
    assert state(robot) == "stopped"
    go(robot)
    assert robot.get_velocity() == (0,) * 6
    one_metre(robot)
    robot.set_velocity((0.0, 0.3, 0, 0, 0, 1.0))
    assert state(robot) == "stopped"
    go(robot, 0.5)
    assert robot.get_motion() == pytest.approx((0, 0, 0, 0, 0, 1.0))  # wheels go not sideways


@pytest.mark.parametrize("kind", KINDS)
def test_a_velocity_is_told_as_it_was_set_and_the_motion_as_it_is(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    wall(home, (0.3, -1), (0.5, -1), (0.5, 1), (0.3, 1))
    robot = enter(kind(world=home))
    robot.set_velocity((0.2, 0, 0, 0, 0, 0))
    assert (robot.get_velocity()[0], robot.get_motion()[0]) == (0.2, 0.0)  # before it moves
    go(robot, 2.0)
    assert (robot.get_velocity()[0], robot.get_motion()[0]) == (0.2, 0.0)  # at the wall
    robot.set_velocity((0,) * 6)
    assert robot.get_velocity() == (0,) * 6
    robot.behaviors.set_moveto(rtkit.Marker((-1.0, 0.0)))
    go(robot, 0.5)
    assert any(robot.get_velocity())
    go(robot)
    assert robot.get_velocity() == robot.get_motion() == (0,) * 6


def test_velocity_may_be_given_in_another_frame(home: HomeWorld, enter: Make) -> None:
    robot = enter(LeggedRobot(world=home, start=(0, 0, math.pi / 2)))
    robot.set_velocity((0.1, 0, 0, 0, 0, 0), frame="world")
    go(robot, 2.0)
    assert robot.get_location()[:2] == pytest.approx((0.2, 0.0), abs=0.02)
    assert robot.get_velocity(frame="world")[:2] == pytest.approx((0.1, 0.0), abs=1e-6)
    assert robot.get_velocity()[:2] == pytest.approx((0.0, -0.1), abs=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_in_the_way_ends_it_with_the_reason(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    wall(home, (0.6, -1), (0.8, -1), (0.8, 1), (0.6, 1))
    robot = enter(kind(world=home))
    one_metre(robot)
    go(robot)
    assert state(robot) == "failed"
    assert "something is in the way at (0.4" in str(robot.behaviors.get_moveto().find("error").leaf)
    assert robot.get_location()[0] < 0.6


@pytest.mark.parametrize("kind", KINDS)
def test_robots_bump_into_each_other_as_into_walls(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    robot = enter(kind(world=home, body="one"))
    enter(DifferentialRobot(world=home, body="other", start=(1.0, 0.0, 0.0)))
    robot.behaviors.set_moveto(rtkit.Marker((2.0, 0.0)))
    go(robot)
    touching = 1.0 - 0.15 - max(robot.get_dimensions()[:2]) / 2  # where both rims meet
    assert robot.get_location()[0] == pytest.approx(touching, abs=1e-6)
    error = robot.behaviors.get_moveto().find("error")
    assert f"something is in the way at ({touching:.2f} 0.00)" in str(error.leaf)
    collisions = [home.bodies.get(name).features["collisions"] for name in ("one", "other")]
    assert collisions == [1, 0]
    assert home.bodies.get("other").location == (1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    home.bodies.set("other", None)
    robot.behaviors.set_moveto(rtkit.Marker((2.0, 0.0), frame="world"))
    go(robot)
    assert state(robot) == "done"


@pytest.mark.parametrize("kind", KINDS)
def test_a_laser_sees_other_robots_and_not_its_own(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    laser = enter(kind(world=home)).sensors["laser"]
    assert set(laser.get_ranges()) == {4.0}
    enter(DifferentialRobot(world=home, start=(2.0, 0.0, 0.0), body="ahead"))
    enter(DifferentialRobot(world=home, start=(0.0, 1.0, 0.0), body="left"))
    ranges = laser.get_ranges()  # a ray for each degree, from the right to the left
    assert ranges[90] == pytest.approx(2.0 - 0.15)
    assert ranges[180] == pytest.approx(1.0 - 0.15)
    aside = math.radians(3)
    chord = 2 * math.cos(aside) - math.sqrt(0.15**2 - (2 * math.sin(aside)) ** 2)
    assert ranges[93] == ranges[87] == pytest.approx(chord)
    assert {ranges[90 + 5], ranges[0]} == {4.0}  # asin(0.15 / 2) is 4.3 degrees
    wall(home, (1.0, -1.0), (1.2, -1.0), (1.2, 1.0), (1.0, 1.0))
    assert laser.get_ranges()[90] == pytest.approx(1.0)  # and none behind a wall


def test_what_is_told_of_places_and_motions_is_plain(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home, start=(-0.0, 0.0, math.pi / 2), body="one"))
    robot.set_velocity((0.3, 0, 0, 0, 0, 0))
    go(robot, 1.0)
    there = (0.0, 0.3, 0.0, 0.0, 0.0, 1.570796327)
    for told in (robot.get_location(), home.bodies.get("one").location):
        assert repr(told) == repr(there)
    assert repr(robot.get_velocity()) == repr((0.3, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert repr(robot.get_velocity(frame="world")) == repr((0.0, 0.3, 0.0, 0.0, 0.0, 0.0))
    assert repr(robot.get_location(frame="base")) == repr((0.0,) * 6)
    assert repr(robot.actuators["left"].get_speed()) == "7.5"


@pytest.mark.parametrize(
    ("target", "why"),
    [
        (rtkit.Marker((1.0, 0.0), frame="kitchen"), "no frame: kitchen"),
        (rtkit.Marker(None, polar=(1, 0)), "no location"),
        (rtkit.Element("ball"), "a marker"),
        ([], "a marker"),
        (rtkit.Marker((math.nan, 0.0)), "finite"),
        (rtkit.Marker((math.inf, 0.0)), "finite"),
        (rtkit.Marker((1.0, 0.0, 0.0, 0.0, 0.0, math.nan), frame="world"), "finite"),
    ],
)
def test_what_is_no_target_is_refused_and_the_old_one_kept(
    home: HomeWorld, enter: Make, target: Any, why: str
) -> None:
    robot = enter(DifferentialRobot(world=home))
    one_metre(robot)
    with pytest.raises(rtkit.PropertyError, match=why) as refused:
        robot.behaviors.set_moveto(target)
    assert refused.value.code == ("bad-parameter" if "frame" in why else "bad-value")
    assert state(robot) == "running"


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("kind", KINDS)
def test_a_velocity_that_is_no_number_is_refused_and_the_place_kept(
    home: HomeWorld, enter: Make, kind: Make, number: float
) -> None:
    robot = enter(kind(world=home))
    for velocity in ((number, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0, number)):
        with pytest.raises(rtkit.PropertyError, match="finite") as refused:
            robot.set_velocity(velocity)
        assert refused.value.code == "bad-value"
    one_metre(robot)
    assert state(robot) == "running"


class Circling:
    def __init__(self, chassis: Any, route: Any) -> None:
        self.remaining = list(route)
        self.left = 2.0

    def step(self, seconds: float) -> tuple[float, float, float] | None:
        self.left -= seconds
        if self.left < 1.0 and self.remaining[0].x > 5:
            raise KeyError("map")
        return (0.2, 0.0, 1.0) if self.left > 0 else None


def test_a_behaviour_is_plugged_in_by_its_name(home: HomeWorld, enter: Make) -> None:
    robot = enter(LeggedRobot(world=home, behaviors=f"circle={__name__}:Circling"))
    robot.behaviors.set_circle(rtkit.Marker((1.0, 0.0)))
    assert 1.9 < go(robot) < 3.5
    assert (state(robot, "circle"), state(robot)) == ("done", "idle")
    robot.behaviors.set_circle(rtkit.Marker((9.0, 0.0), frame="world"))
    go(robot)
    error = robot.behaviors.get_circle().find("error")
    assert (state(robot, "circle"), str(error.leaf)) == ("failed", "KeyError: 'map'")
    one_metre(robot)
    assert (state(robot, "circle"), state(robot)) == ("idle", "running")


@pytest.mark.parametrize("words", ["circle", "circle=os:absent", "circle=no_such_module:X"])
def test_a_behaviour_that_is_not_there_is_refused(words: str) -> None:
    with pytest.raises(rtkit.PropertyError, match="no behaviour circle"):
        MobileRobot(behaviors=words)


def test_wheels_turn_as_the_robot_went(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home))
    robot.set_velocity((0.2, 0, 0, 0, 0, 0.5))
    go(robot, 1.0)
    left, right = robot.actuators["left"], robot.actuators["right"]
    assert left.get_speed() == pytest.approx((0.2 - 0.5 * 0.12) / 0.04)
    assert right.get_angle() - left.get_angle() == pytest.approx(0.5 * 0.24 / 0.04)


def test_sensors_agree_with_the_location_in_any_frame(home: HomeWorld, enter: Make) -> None:
    wall(home, (2, -3), (3, -3), (3, 3), (2, 3))
    home.objects.set("ball", rtkit.Marker((1.0, 1.5, 0.1), type="ball", color=(1.0, 0.1, 0.1)))
    home.objects.set("hidden", rtkit.Marker((4.0, 1.5, 0.1), type="ball"))
    robot = enter(LeggedRobot(world=home, start=(1, 0, math.pi / 2)))
    other = enter(DifferentialRobot(world=home, start=(1, 3, 0), body="other"))
    assert robot.sensors["laser"].get_ranges()[0] == pytest.approx(1.0)  # the wall, on the right
    eye = robot.sensors["eye"]
    ball, seen = eye.get_markers()
    assert (ball.id, ball.features["color"], ball.frame) == ("ball", (1.0, 0.1, 0.1), "")
    assert ball.location == pytest.approx((1.5, 0.0, 0.1))
    assert (seen.id, seen.type) == ("other", "robot")
    in_world = eye.get_markers(frame="world")[0]
    assert in_world.location == pytest.approx((1.0, 1.5, 0.1))
    assert eye.get_location(frame="world") == pytest.approx((1, 0.1, 0.12, 0, 0, math.pi / 2))
    other._frames.add("shelf", (1.0, 1.0, 0.0))
    assert other.get_location(frame="shelf")[:2] == pytest.approx((0.0, 2.0))


@pytest.mark.parametrize("kind", KINDS)
def test_each_sensor_of_a_robot_tells_readings_as_markers_in_any_frame(
    home: HomeWorld, enter: Make, kind: type[MobileRobot]
) -> None:
    wall(home, (2, -3), (3, -3), (3, 3), (2, 3))
    robot = enter(kind(world=home, start=(1.0, 0.0, 0.5)))
    for sensor in robot.sensors.values():
        assert rtkit.Word("sensor") in sensor.type
        assert sensor.get_data() is not None
        place = sensor.get_location("world")
        own, far = sensor.get_markers(), sensor.get_markers("world")
        for one, other in zip(own, far, strict=True):
            there = transform(robot.get_location(), one.location)
            assert other.location == pytest.approx(there, abs=1e-8)
        with pytest.raises(rtkit.PropertyError, match="no frame"):
            sensor.get_markers("cellar")
    assert far[0].location == place  # of the camera
    laser = robot.sensors["laser"]
    hits = [each.location for each in laser.get_markers("world")]
    assert hits
    assert all(x == pytest.approx(2.0, abs=1e-8) for x, _, _ in hits)
    before = laser.get_ranges()[90]
    laser.set_location((0.1, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert laser.get_ranges()[90] == pytest.approx(before - 0.1)


def test_an_eye_is_the_less_sure_the_further_off(home: HomeWorld, enter: Make) -> None:
    for far in (1.0, 4.0):
        home.objects.set(f"at{far:g}", rtkit.Marker((far, 0.0, 0.1), type="ball"))
    eyes = [
        enter(MobileRobot(world=home, noise=0.02, seed=seed)).sensors["eye"] for seed in (1, 1, 2)
    ]
    near, off = (each for each in eyes[0].get_markers() if each.type == "ball")
    assert off.variance == pytest.approx(0.08**2, rel=0.1)
    assert near.variance < off.variance / 10
    assert math.dist(off.location, (4, 0, 0.1)) < 0.4
    first, same, another = (each.get_markers(frame="world")[0].location for each in eyes)
    assert same != another
    assert first is not None


def test_a_camera_sees_the_world_as_it_stands(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home))
    camera = robot.sensors["camera"]
    before = camera.get_image(width=64, height=48)
    assert before.startswith(b"\x89PNG")
    home.objects.set("ball", rtkit.Marker((1.0, 0.0, 0.2), type="ball", size=0.3))
    assert camera.get_image(width=64, height=48) != before
    with pytest.raises(rtkit.PropertyError, match="no picture"):
        camera.get_image(width=0)


def test_a_robot_that_leaves_is_gone_and_its_thread_ends(home: HomeWorld) -> None:
    robot = MobileRobot(world=home, body="one")
    with robot, MobileRobot(world=home):
        assert len(home.bodies.names()) == 2
        assert len({id(crew) for crew in driving._CREWS.values()}) == 1
    assert not home.bodies.names()
    assert driving._CREWS == {}
    with robot, robot:  # served by two
        assert len(next(iter(driving._CREWS.values())).robots) == 1
    assert (home.bodies.names(), driving._CREWS) == ({}, {})


def test_a_world_that_was_begun_anew_is_entered_anew(home: HomeWorld, enter: Make) -> None:
    robot = enter(DifferentialRobot(world=home, body="one"))
    one_metre(robot)
    go(robot, 1.0)
    at = robot.get_location()
    home.bodies.set("one", None)
    go(robot, 0.05)
    assert home.bodies.get("one").location == at
    go(robot)
    assert state(robot) == "done"


class Silent(HomeWorld):
    is_silent = False

    def set_moves(self, moves: Any) -> None:
        if self.is_silent:
            raise rtkit.PropertyError("no-service", "nobody is there")
        super().set_moves(moves)


def test_a_robot_says_that_its_world_is_gone_and_goes_on_when_it_is_back(enter: Make) -> None:
    home = Silent(pace=0)
    robot = enter(DifferentialRobot(world=home))
    one_metre(robot)
    home.is_silent = True
    go(robot, 0.1)
    assert robot.get_status() == "waiting: nobody is there"
    home.is_silent = False
    go(robot)
    assert robot.get_status() == "ready"
    assert state(robot) == "done"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "home.json: Expecting"),
        ("[]", "home.json: "),
        ('{"wals": []}', "no such key: wals"),
        ('{"walls": [[1, 2]]}', "corners are pairs"),
        ('{"walls": [{"outr": []}]}', "outr"),
        ('{"objects": {"ball": {"color": [1, 0, 0]}}}', "objects.ball: .*location"),
        ('{"objects": {"ball": {"location": [1]}}}', "objects.ball: .*"),
    ],
)
def test_a_home_that_cannot_be_read_is_refused_with_its_place(
    tmp_path: Path, text: str, why: str
) -> None:
    file = tmp_path / "home.json"
    file.write_text(text)
    with pytest.raises(InvalidDocument, match=why), HomeWorld(file=str(file)):
        pass


def test_a_home_has_rooms_that_are_dark_while_no_light_is_on(tmp_path: Path) -> None:
    lamp = {"type": "light", "location": [1, 1, 2], "on": False}
    square = [[0, 0], [2, 0], [2, 2], [0, 2]]
    file = tmp_path / "home.json"
    file.write_text(json.dumps({"rooms": {"hall": square}, "objects": {"lamp": lamp}}))
    with HomeWorld(file=str(file)) as home:
        assert (home.get_room((1, 1)), home.get_room((3, 1))) == ("hall", "")
        dark = home.get_image((0.5, 0.5, 1, 0), 32, 24)
        assert (home.get_light((1, 1)), home.get_light((3, 1))) == (0.25, 1.0)
        home.objects.set("lamp", home.objects.get("lamp").with_(on=True))
        assert home.get_light((1, 1)) == 1.0
        assert home.get_image((0.5, 0.5, 1, 0), 32, 24) != dark


@pytest.mark.parametrize(
    "given",
    [
        {"start": (1, 2)}, {"start": (math.nan, 0, 0)}, {"top_speed": 0}, {"top_speed": math.inf},
        {"top_turning": -1}, {"noise": math.nan},
    ],
)  # fmt: skip
def test_what_no_robot_can_be_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=f"{next(iter(given))} is"):
        DifferentialRobot(**given)


def test_a_robot_that_would_begin_in_a_wall_is_refused(home: HomeWorld) -> None:
    wall(home, (-1, -1), (1, -1), (1, 1), (-1, 1))
    with pytest.raises(Refused, match="in a wall"), DifferentialRobot(world=home):
        pass
    assert driving._CREWS == {}
