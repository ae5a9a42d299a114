"""Mobile robots as served: one client drives unlike ones in a world that they share."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from importlib.metadata import entry_points
from typing import Any

import pytest

import rtkit
from rtkit.services.chassis import Chassis
from rtkit.services.frames import ORIGIN, compose, inverse, transform
from rtkit.services.group import Group
from rtkit.services.legged import LeggedRobot
from rtkit.services.mobilerobot import DifferentialRobot, MobileRobot
from rtkit.services.resource import Resource
from rtkit.services.sensor import PropertySensor
from rtkit.services.world import HomeWorld

_BOUND_S = 20.0
_PACE = 6.0
START = {"r1": (0.0, 1.0, 0.5), "r2": (0.0, -1.0, -0.5)}


@pytest.fixture
def client(place: str) -> Iterator[rtkit.Client]:
    with rtkit.Client(timeout_s=_BOUND_S) as client:
        yield client


@pytest.fixture
def home(place: str, ends: ExitStack) -> Any:
    """A served world with a wheeled and a legged robot, which know it by its name only."""
    home = HomeWorld(pace=_PACE)
    served = ends.enter_context(rtkit.serve(home, "home", is_on_zenoh=False))
    for name, kind in (("r1", DifferentialRobot), ("r2", LeggedRobot)):
        robot = kind(world="home", body=name, start=START[name], behaviors="")
        ends.enter_context(rtkit.serve(robot, f"robots/{name}", is_on_zenoh=False))
    return served


def until(is_so: Callable[[], Any]) -> Any:
    """Wait until something is so; return it."""
    end = time.monotonic() + _BOUND_S
    while not (found := is_so()):
        assert time.monotonic() < end
        time.sleep(0.01)
    return found


def one_metre(client: rtkit.Client, robot: str) -> None:
    """The client program: it knows no robot."""
    client.set(f"{robot}.behaviors.moveto", rtkit.Marker((1.0, 0.0)))


def has_ended(client: rtkit.Client, robot: str, state: str = "done") -> bool:
    behavior = client.get(f"{robot}.behaviors.moveto")
    return bool(behavior.attributes["state"] == state)


def test_one_client_moves_two_unlike_robots_a_metre_forward(
    home: Any, client: rtkit.Client
) -> None:
    robots = [f"robots/{name}" for name in START]
    for robot in robots:
        assert "mobilerobot" in client.get(f"{robot}.type")
        one_metre(client, robot)
    for robot, (x, y, heading) in zip(robots, START.values(), strict=True):
        until(lambda robot=robot: has_ended(client, robot))
        wanted = (x + math.cos(heading), y + math.sin(heading))
        assert client.get(f"{robot}.location")[:2] == pytest.approx(wanted, abs=0.02)
        told = client.get(f"home.bodies.{robot[-2:]}.location")
        assert told == client.get(f"{robot}.location")
    one_in_other = client.get("robots/r1.location", frame="robots/r2")
    other_in_one = client.get("robots/r2.location", frame="robots/r1")
    assert math.hypot(*one_in_other[:2]) == pytest.approx(math.hypot(*other_in_one[:2]))
    with pytest.raises(rtkit.PropertyError, match="no frame: cellar") as refused:
        client.get("robots/r1.location", frame="cellar")
    assert refused.value.code == "bad-parameter"


def test_velocity_ends_by_itself_after_its_time_out(
    home: Any, client: rtkit.Client, ends: ExitStack
) -> None:
    seen: list[Any] = []
    ends.enter_context(
        client.listen("robots/r1.velocity", lambda each: seen.append(each.value), queue=100)
    )
    assert client.get("robots/r1.velocity.timeout") == 0.5
    client.set("robots/r1.velocity.timeout", 0.2)
    client.set("robots/r1.velocity", (0.3, 0, 0, 0, 0, 0))
    assert client.get("robots/r1.velocity")[0] == 0.3  # at once, and so each part
    client.set("robots/r1.velocity.c", 0.1)
    assert client.get("robots/r1.velocity") == (0.3, 0, 0, 0, 0, 0.1)
    until(lambda: any(each[0] > 0.2 for each in seen))
    until(lambda: client.get("robots/r1.velocity") == (0,) * 6)
    until(lambda: client.get("robots/r1.motion") == (0,) * 6)
    assert client.get("robots/r1.status") == "ready"
    assert 0.1 < math.dist(client.get("robots/r1.location")[:2], START["r1"][:2]) < 4.0


def test_who_listens_to_the_state_of_a_behaviour_is_told_of_its_end(
    home: Any, client: rtkit.Client, ends: ExitStack
) -> None:
    states: list[str] = []
    ends.enter_context(
        client.listen("robots/r1.behaviors.moveto.state", lambda each: states.append(each.value))
    )
    until(lambda: states == ["idle"])
    one_metre(client, "robots/r1")
    until(lambda: "done" in states)
    assert states == ["idle", "running", "done"]
    assert client.get("robots/r1.behaviors.moveto.state") == "done"
    assert client.get("robots/r1.behaviors.moveto.target.location.0") == 1.0


def test_a_call_of_a_behaviour_ends_with_it_of_one_robot_and_of_many(
    home: Any, client: rtkit.Client, ends: ExitStack
) -> None:
    ends.enter_context(rtkit.serve(Group(robots="robots/r1 robots/r2"), "swarm"))
    for robot in ("robots/r1", "robots/r2", "swarm"):
        ended = client.call(f"{robot}.behaviors.moveto", rtkit.Marker((0.3, 0.0)))
        assert ended.attributes["state"] == "done"
    client.set("home.bodies.block", rtkit.Marker((1.0, 1.3, 0.0), radius=0.3, height=1.0))
    with pytest.raises(rtkit.PropertyError, match="something is in the way"):
        client.call("robots/r1.behaviors.moveto", rtkit.Marker((2.0, 1.7), frame="world"))
    with pytest.raises(rtkit.PropertyError, match="it runs still") as late:
        client.call("robots/r2.behaviors.moveto", rtkit.Marker((90.0, 0.0)), timeout_s=0.2)
    assert late.value.code == "timeout"
    assert client.get("robots/r2.behaviors.moveto.state") == "running"


def test_an_expired_velocity_stops_no_behaviour_that_began_meanwhile(
    home: Any, client: rtkit.Client
) -> None:
    client.set("robots/r1.velocity.timeout", 0.1)
    client.set("robots/r1.velocity", (0.1, 0, 0, 0, 0, 0))
    one_metre(client, "robots/r1")
    until(lambda: has_ended(client, "robots/r1"))


class Arm:
    """What is plugged into a robot that runs."""

    def __init__(self) -> None:
        self.angle: float = 0.5


def test_what_is_plugged_in_appears_with_an_event(
    home: Any, client: rtkit.Client, ends: ExitStack
) -> None:
    ends.enter_context(rtkit.serve(Arm(), "arms/left", is_on_zenoh=False))
    changes: list[str] = []
    came = threading.Event()

    def heard(change: Any) -> None:
        changes.append(str(change.value))
        if "arm" in str(change.value):
            came.set()

    ends.enter_context(client.listen("robots/r2.actuators.properties", heard))
    client.call("robots/r2.plug", "actuators", "arm", "arms/left")
    assert came.wait(_BOUND_S), changes
    assert "arm" in client.get("robots/r2.actuators")
    client.set("robots/r2.actuators.arm.angle", 0.75)
    assert client.get("arms/left.angle") == 0.75
    with pytest.raises(rtkit.PropertyError, match='"arms" is no choice'):
        client.call("robots/r2.plug", "arms", "arm", "arms/left")
    with pytest.raises(rtkit.PropertyError, match="one already"):
        client.call("robots/r2.plug", "actuators", "arm", "arms/left")
    client.call("robots/r2.unplug", "actuators", "arm")
    until(lambda: "arm" not in client.get("robots/r2.actuators"))
    with pytest.raises(rtkit.PropertyError, match="none: sensors"):
        client.call("robots/r2.unplug", "sensors", "arm")


@pytest.mark.parametrize(
    ("name", "target", "code"),
    [
        ("arm", "arms/nowhere", "no-service"),
        ("arm", "robots/r1.arms", "unknown"),
        ("", "robots/r1", "bad-value"),
        ("a.b", "robots/r1", "bad-value"),
        ("properties", "robots/r1", "bad-value"),
    ],
)
def test_what_cannot_be_plugged_in_is_refused(
    home: Any, client: rtkit.Client, name: str, target: str, code: str
) -> None:
    before = client.get("robots/r2.actuators")
    with pytest.raises(rtkit.PropertyError) as refused:
        client.call("robots/r2.plug", "actuators", name, target)
    assert refused.value.code == code
    assert client.get("robots/r2.actuators") == before


def test_frames_of_robots_that_ask_each_other_of_parts_and_of_the_resource_agree(
    home: Any, client: rtkit.Client, ends: ExitStack
) -> None:
    hall = (5.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    sensor = PropertySensor("home.pace", (0.5, 0, 0, 0, 0, 0), base="robots/r1")
    ends.enter_context(rtkit.serve(Resource(frames=("hall 5 0 0 0 0 1",)), "resource"))
    ends.enter_context(rtkit.serve(sensor, "robots/r1/pace", is_on_zenoh=False))
    ends.enter_context(rtkit.serve(PropertySensor("home.pace"), "lone", is_on_zenoh=False))
    poses = {name: client.get(f"robots/{name}.location") for name in START}
    assert client.get("robots/r1.location", frame="robots/r1") == ORIGIN  # it asks itself

    def ask(name: str, other: str) -> None:
        wanted = pytest.approx(compose(inverse(poses[other]), poses[name]))
        with rtkit.Client(timeout_s=_BOUND_S) as own:
            for _ in range(20):
                assert own.get(f"robots/{name}.location", frame=f"robots/{other}") == wanted

    with ThreadPoolExecutor(2) as pool:  # neither waits for the other to be answered
        for done in [pool.submit(ask, "r1", "r2"), pool.submit(ask, "r2", "r1")]:
            done.result(_BOUND_S)
    place = compose(poses["r1"], (0.5, 0, 0, 0, 0, 0))
    frames = {"hall": hall, "robots/r1/pace": place, "home.bodies.r2": poses["r2"],
              "robots/r1.sensors.eye": compose(poses["r1"], (0.1, 0, 0.3, 0, 0, 0))}  # fmt: skip
    for frame, pose in frames.items():
        for target, there in (("robots/r2", poses["r2"]), ("robots/r1/pace", place)):
            wanted = pytest.approx(compose(inverse(pose), there), abs=1e-8)
            assert client.get(f"{target}.location", frame=frame) == wanted
    lamp = type("Lamp", (), {"location": "hall", "level": 0.5})()
    ends.enter_context(rtkit.serve(lamp, "lamp", is_on_zenoh=False))
    for frame in ("lone", "cellar", "no frame", "lamp"):  # a sensor without a base is nowhere
        with pytest.raises(rtkit.PropertyError, match="no frame") as refused:
            client.get("robots/r2.location", frame=frame)
        assert refused.value.code == "bad-parameter"


def test_sensors_are_asked_of_the_world_as_it_stands(home: Any, client: rtkit.Client) -> None:
    ball = rtkit.Marker((1.0, 1.6, 0.2), type="ball", size=0.3, color=(0.9, 0.1, 0.1))
    before = client.get_bytes("robots/r1.sensors.camera.image?width=64&height=48")
    client.set("home.objects.ball", ball)
    assert client.get_bytes("robots/r1.sensors.camera.image?width=64&height=48") != before
    (seen,) = client.get("robots/r1.sensors.eye.markers", frame="world")
    assert (seen.id, seen.frame) == ("ball", "world")
    assert seen.location == pytest.approx(ball.location)
    (of_other,) = client.get("robots/r1.sensors.eye.markers", frame="robots/r2")
    assert of_other.frame == "robots/r2"
    there = transform(client.get("robots/r2.location"), of_other.location)
    assert there == pytest.approx(ball.location)
    (own,) = client.get("robots/r1.sensors.eye.markers")
    assert transform(client.get("robots/r1.location"), own.location) == pytest.approx(there)
    assert len(client.get("robots/r2.sensors.laser.ranges")) == 181
    for name in client.get("robots/r2.sensors"):
        assert client.get(f"robots/r2.sensors.{name}.type") == (name, "sensor")
        assert client.get(f"robots/r2.sensors.{name}.type.meta.type") == "list<word>"
    feet = client.get("robots/r2.actuators.left_front.foot", frame="world")
    assert feet[2] == 0.0
    assert -2.5 < client.get("robots/r2.actuators.left_front.tibia") < 0
    pytest.importorskip("cv2")
    jpeg = client.get_bytes("robots/r1.sensors.camera.image?format=jpeg")
    assert jpeg.startswith(b"\xff\xd8")


def test_clients_that_put_and_take_at_once_are_all_served(
    place: str, client: rtkit.Client, ends: ExitStack
) -> None:
    ends.enter_context(rtkit.serve(HomeWorld(), "home", is_on_zenoh=False))
    ready = threading.Barrier(4)

    def work(worker: int) -> None:
        with rtkit.Client(timeout_s=_BOUND_S) as own:
            ready.wait(_BOUND_S)
            for at in range(20):
                marker = rtkit.Marker((float(at), float(worker), 0.0))
                own.set(f"home.objects.ball{worker}x{at}", marker)
                own.set(f"home.bodies.body{worker}", marker)
                if at % 2:
                    own.set(f"home.objects.ball{worker}x{at}", None)

    with ThreadPoolExecutor(4) as pool:
        for done in [pool.submit(work, worker) for worker in range(4)]:
            done.result(_BOUND_S)
    balls = {f"ball{worker}x{at}" for worker in range(4) for at in range(0, 20, 2)}
    assert {*client.get("home.objects")} == balls
    assert client.get("home.objects.ball3x4.location") == (4.0, 3.0, 0.0)
    assert {*client.get("home.bodies")} == {f"body{worker}" for worker in range(4)}
    assert client.get("home.bodies.body2.location")[:2] == (19.0, 2.0)


def test_parts_of_objects_and_bodies_are_set(home: Any, client: rtkit.Client) -> None:
    client.set("home.objects.lamp", rtkit.Marker((1.0, 1.0, 2.0), type="light", on=False))
    client.set("home.objects.lamp.on", True)
    client.set("home.objects.lamp.location", (2.0, 1.0, 2.0))
    lamp = client.get("home.objects.lamp")
    assert (lamp.features["on"], lamp.location, lamp.id) == (True, (2.0, 1.0, 2.0), "lamp")
    client.set("home.bodies.r2.location", (5.0, 5.0, 0.0, 0.0, 0.0, 0.0))
    body = client.get("home.bodies.r2")
    assert (body.location[:2], body.features["radius"]) == ((5.0, 5.0), 0.2)
    with pytest.raises(rtkit.PropertyError) as refused:
        client.set("home.objects.none.on", True)
    assert refused.value.code == "unknown"
    for target in ("home.objects.lamp", "home.objects.lamp.location"):
        with pytest.raises(rtkit.PropertyError) as refused:
            client.set(target, "red")
        assert refused.value.code == "bad-value"
    assert client.get("home.objects.lamp") == lamp


def test_a_world_that_comes_later_is_entered_then(
    place: str, client: rtkit.Client, ends: ExitStack
) -> None:
    robot = DifferentialRobot(world="home", body="early")
    ends.enter_context(rtkit.serve(robot, "robots/early", is_on_zenoh=False))
    one_metre(client, "robots/early")
    assert until(lambda: client.get("robots/early.status")).startswith("waiting: home")
    ends.enter_context(rtkit.serve(HomeWorld(pace=_PACE), "home", is_on_zenoh=False))
    until(lambda: has_ended(client, "robots/early"))
    assert client.get("home.bodies.early.location.x") == pytest.approx(1.0, abs=0.02)


def test_a_robot_that_stands_is_hardly_asked_and_starts_at_once(
    place: str, ends: ExitStack
) -> None:
    home = HomeWorld()
    looks: queue.Queue[int] = queue.Queue()
    asked = 0

    class Counted(Chassis):
        def wanted(self, seconds: float) -> Any:
            nonlocal asked
            asked += 1
            return super().wanted(seconds)

        def moved(self, row: Any, seconds: float) -> None:
            super().moved(row, seconds)
            looks.put(asked)

    robot = type("Robot", (MobileRobot,), {"chassis_type": Counted})(world=home, body="one")
    ends.enter_context(robot)
    first, second = looks.get(timeout=_BOUND_S), looks.get(timeout=_BOUND_S)
    assert second - first <= 3  # in a second: twenty, if it moved
    home.bodies.set("one", None)
    until(lambda: home.bodies.names())  # it looks where it is
    before = time.monotonic()
    robot.set_velocity((0.3, 0, 0, 0, 0, 0))
    until(lambda: robot.get_status() == "moving")
    assert time.monotonic() - before < 0.8


def test_a_hundred_robots_of_one_process_share_a_thread_and_a_request(
    place: str, client: rtkit.Client, ends: ExitStack
) -> None:
    home = HomeWorld(pace=_PACE)
    ends.enter_context(rtkit.serve(home, "home", is_on_zenoh=False))
    kinds = (DifferentialRobot, LeggedRobot)
    robots = {f"r{n}": kinds[n % 2](world="home", start=(float(n), 0.0, 1.0)) for n in range(100)}
    before = threading.active_count()
    for robot in robots.values():
        ends.enter_context(robot)
    # Who moves them, the client that they share, and the worker that attends to it.
    assert threading.active_count() <= before + 4
    for robot in robots.values():
        robot.behaviors.set_moveto(rtkit.Marker((0.5, 0.0)))
    running = [robot._chassis.running for robot in robots.values()]
    until(lambda: all(each.state == "done" for each in running))


@pytest.mark.parametrize("kind", ["DifferentialRobot", "LeggedRobot", "HomeWorld"])
def test_robots_and_their_home_are_components(kind: str) -> None:
    entry = next(each for each in entry_points(group="rtkit.components") if each.name == kind)
    made: list[Any] = []
    manager = type("Manager", (), {"register_factory": lambda self, each: made.append(each)})()
    entry.load()(manager)
    assert (made[0].__name__, made[0].vendor, made[0].category) == (kind, "rtkit", "service")
    assert {"world", "body", "start"} <= made[0].arguments.keys() or kind == "HomeWorld"
