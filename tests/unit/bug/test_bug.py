"""Bug navigation in its own worlds: lengths of ideal walkers, right answers, no collision."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, radians
from pathlib import Path

import pytest

pytest.importorskip("numpy")
EXAMPLES = Path(__file__).parents[3] / "examples"
sys.path.insert(0, str(EXAMPLES))

from bug.algorithm import Navigator  # noqa: E402
from bug.assembly import read_assembly, variants  # noqa: E402
from bug.environments import read_environments, shipped, shortest  # noqa: E402
from bug.senses import Located, Scan  # noqa: E402
from bug.simulation import Simulation, simulate  # noqa: E402

from rtkit.errors import InvalidDocument  # noqa: E402

Place = tuple[float, float]
SIX = ("bug1", "bug2", "alg1", "alg2", "rev1", "distbug")
IDEAL = {
    "closed": [(25.1, 25.1)] * 6,
    "one-box": [(25.0, 25.0), (11.6, 14.6), (11.6, 14.6), (10.6, 12.9), (11.6, 14.6), (10.6, 12.9)],
    "visited": [(90.5, 90.5), (68.9, 29.2), (56.6, 29.2), (53.1, 27.3), (14.6, 29.2), (72.7, 26.8)],
    "spiral": [
        (122.7, 124.9),
        (33.6, 140.6),
        (33.6, 104.6),
        (32.1, 92.6),
        (33.6, 65.4),
        (32.1, 249.0),
    ],
    "comb": [(96.8, 96.8), (35.6, 21.2), (35.6, 21.2), (17.9, 19.7), (98.6, 21.2), (17.9, 19.7)],
}
"""Lengths of the path of a point that keeps 0.3 m off the walls, left and right first [m]."""
SHORTEST = {"closed": None, "one-box": 9.280, "visited": 10.261, "spiral": 26.191, "comb": 14.876}


@pytest.mark.parametrize("direction", ["left", "right"])
@pytest.mark.parametrize("variant", SIX)
def test_box_is_passed_on_the_way_of_an_ideal_walker(variant: str, direction: str) -> None:
    environment = shipped()["one-box"]

    run = simulate(environment, variants()[variant], "laser", direction)

    ideal = IDEAL["one-box"][SIX.index(variant)][direction == "right"]
    assert run.status == "reached"
    assert run.collisions == 0
    assert 0.85 <= run.path_length / ideal <= 1.25
    assert len(run.hits) == len(run.leaves) == 1


@pytest.mark.parametrize(
    ("world", "sensors"),
    [("closed", "ir"), ("closed", "laser+ir"), ("one-box", "ir"), ("one-box", "bumper")],
)
def test_other_sensors_tell_the_same(world: str, sensors: str) -> None:
    run = simulate(shipped()[world], variants()["bug2"], sensors)

    ideal = IDEAL[world][1][0]
    assert run.status == ("unreachable" if world == "closed" else "reached")
    assert run.collisions == 0
    assert len(run.hits) == 1
    assert 0.85 <= run.path_length / ideal <= {"ir": 1.4, "laser+ir": 1.25, "bumper": 1.7}[sensors]


@pytest.mark.parametrize(
    ("variant", "direction", "reversals"),
    [("alg1", "left", 1), ("alg2", "left", 1), ("bug2", "left", 0), ("rev1", "left", 0)],
)
def test_earlier_hit_point_turns_it_round_once(
    variant: str, direction: str, reversals: int
) -> None:
    run = simulate(shipped()["visited"], variants()[variant], "ir", direction)

    ideal = IDEAL["visited"][SIX.index(variant)][direction == "right"]
    assert run.status == "reached"
    assert run.reversals == reversals
    assert 0.85 <= run.path_length / ideal <= 1.4


THIN_WALL = [[-2, 3], [2, 3], [2, 3.05], [-2, 3.05]]
DEAD_END = [
    [-3.3, -0.75],
    [3, -0.75],
    [3, -0.45],
    [-3, -0.45],
    [-3, 0.45],
    [3, 0.45],
    [3, 0.75],
    [-3.3, 0.75],
]


@pytest.mark.parametrize("variant", ["bug1", "bug2"])
@pytest.mark.parametrize(
    ("outer", "sensors"), [(THIN_WALL, "bumper"), (DEAD_END, "laser"), (DEAD_END, "ir")]
)
def test_other_side_of_a_hit_point_is_not_the_hit_point(
    outer: list[list[float]], sensors: str, variant: str
) -> None:
    world = {"start": [0, 0], "goal": [0.5, 6], "obstacles": [{"outer": outer}]}
    environment = read_environments({"narrow": world}, "worlds")["narrow"]

    run = simulate(environment, variants()[variant], sensors)

    assert run.status == "reached"
    assert len(run.hits) == len(run.leaves) == 1


def test_circuit_ends_where_the_robot_switched_far_from_the_wall() -> None:
    ring, hole = ([[-r, -r], [r, -r], [r, r], [-r, r]] for r in (4.3, 4.0))
    box = [[-0.5, -1], [0.6, -1], [0.6, 1.3], [-0.5, 1.3]]
    obstacles = [{"outer": ring, "holes": [hole]}, {"outer": box}]
    world = {"start": [-2, 0], "goal": [8, 0.2], "obstacles": obstacles}
    environment = read_environments({"room": world}, "worlds")["room"]

    run = simulate(environment, variants()["tangentbug"], step_limit=1000)

    assert run.status == "unreachable"


@pytest.mark.parametrize(
    ("start", "goal", "corners", "sensors"),
    [
        ((-2.72, 1.34), (8, 2.86), ((-2.04, 1.70), (-1.54, 3.05)), "ir"),
        ((0.97, -0.58), (8, -2.42), ((2.14, -0.80), (3.14, -0.21)), "bumper"),
    ],
)
@pytest.mark.parametrize("variant", ["bug2", "alg1"])
def test_leave_point_next_to_the_hit_point_is_found_before_the_circuit_ends(
    start: Place, goal: Place, corners: tuple[Place, Place], sensors: str, variant: str
) -> None:
    (left, low), (right, high) = corners
    box = [(left, low), (right, low), (right, high), (left, high)]
    world = {"start": start, "goal": goal, "obstacles": [{"outer": box}]}
    environment = read_environments({"corner": world}, "worlds")["corner"]

    run = simulate(environment, variants()[variant], sensors, step_limit=1000)

    assert run.status == "reached"
    assert len(run.hits) == len(run.leaves) == 1


def test_wall_is_found_again_where_it_turned_round_out_of_touch() -> None:
    run = simulate(shipped()["one-box"], variants()["rev2"], "bumper", step_limit=500)

    assert run.status == "reached"
    assert run.reversals == 1


@pytest.mark.parametrize(("variant", "half"), [("distbug", 0.7), ("bug1", 0.75)])
def test_looking_for_the_goal_in_a_corner_of_a_small_room_ends(variant: str, half: float) -> None:
    ring, hole = ([[-r, -r], [r, -r], [r, r], [-r, r]] for r in (half + 0.3, half))
    world = {"start": [0, 0], "goal": [0, 11], "obstacles": [{"outer": ring, "holes": [hole]}]}
    environment = read_environments({"room": world}, "worlds")["room"]

    run = simulate(environment, variants()[variant], "ir", step_limit=1000)

    assert run.status == "unreachable"


@pytest.mark.parametrize("y", [-1.19, -1.2])
def test_infra_red_passes_a_corner_at_the_edge_of_its_range_ahead(y: float) -> None:
    box = [[-0.153, -1.275], [2.004, -1.275], [2.004, -0.791], [-0.153, -0.791]]
    world = {"start": [-2.1, y], "goal": [8, -2.09], "obstacles": [{"outer": box}]}
    environment = read_environments({"corner": world}, "worlds")["corner"]

    run = simulate(environment, variants()["bug1"], "ir", step_limit=1000)

    assert run.status == "reached"
    assert run.collisions == 0


@pytest.mark.parametrize("at", [(5, 1), (3.5, 1), (1.5, 1.5)])
def test_hole_that_is_not_inside_its_obstacle_is_refused_with_its_place(at: Place) -> None:
    outer, inner, hole = (
        [(x, y), (x + d, y), (x + d, y + d), (x, y + d)]
        for (x, y), d in (((0, 0), 4), ((1, 1), 1), (at, 1))
    )
    world = {"start": [-1, 0], "goal": [9, 0], "obstacles": [{"outer": outer, "holes": [inner]}]}
    read_environments({"w": world}, "f.json")
    world["obstacles"][0]["holes"].append(hole)

    with pytest.raises(InvalidDocument, match=r"f\.json: w\.obstacles\[0\]\.holes\[1\]: a hole is"):
        read_environments({"w": world}, "f.json")


@pytest.mark.campaign
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("direction", ["left", "right"])
@pytest.mark.parametrize("sensors", ["laser", "ir", "laser+ir", "bumper"])
@pytest.mark.parametrize("world", IDEAL)
@pytest.mark.parametrize("variant", SIX)
def test_each_run_is_that_of_an_ideal_walker(
    variant: str, world: str, sensors: str, direction: str
) -> None:
    run = simulate(shipped()[world], variants()[variant], sensors, direction)

    ideal = IDEAL[world][SIX.index(variant)][direction == "right"]
    assert run.status == ("unreachable" if world == "closed" else "reached")
    assert run.collisions == 0
    if (world, variant) not in {("visited", "distbug"), ("spiral", "distbug")}:  # by the stand-off
        most = {"ir": 1.4, "bumper": 1.75}.get(sensors, 1.25)
        assert 0.85 <= run.path_length / ideal <= most


def test_eighth_variant_is_ten_lines_of_data() -> None:
    careful = read_assembly(
        {
            "motion": "m-line",
            "leave": "m-line",
            "nearer_than": "hit point",
            "direction": "alternate",
            "memory": "turn round",
            "source": "bug2 that turns round, and alternates",
        },
        "careful",
    )

    run = simulate(shipped()["visited"], careful)

    assert run.status == "reached"
    assert run.path_length < 20


@dataclass(frozen=True, slots=True)
class SonarSenses(Located):
    """Made of the ranges of eight sonars, from the left to the right, 20 degrees wide, to 3 m."""

    ranges: Sequence[float]

    def scan(self) -> Scan:
        return tuple((pi / 2 - k * pi / 7, r) for k, r in enumerate(self.ranges))

    def free_distance(self, bearing: float) -> float | None:
        for middle, found in self.scan():
            if abs(bearing - middle) <= radians(10):
                return found
        return None

    def left_distance(self) -> float:
        return self.ranges[0]

    def right_distance(self) -> float:
        return self.ranges[-1]

    def obstacle_on_the_left(self) -> bool:
        return self.ranges[0] < 0.6

    def obstacle_on_the_right(self) -> bool:
        return self.ranges[-1] < 0.6

    def obstacle_in_front_of_the_robot(self) -> bool:
        return min(self.ranges[3:5]) < 0.47


@pytest.mark.parametrize("world", ["closed", "one-box"])
def test_new_sensor_takes_an_adaptor_of_forty_lines(world: str) -> None:
    assert len(inspect.getsource(SonarSenses).splitlines()) <= 40
    environment = shipped()[world]
    simulation = Simulation(environment)
    navigator = Navigator(variants()["bug2"], environment.goal)
    middles = [pi / 2 - k * pi / 7 for k in range(8)]

    while not navigator.status and simulation.t < 600:
        pose = simulation.pose
        cones = [pose.theta + b for b in middles]
        ranges = environment.scene.cones(pose[:2], cones, radians(20), 3.0)
        simulation.step(*navigator.control(SonarSenses(pose, tuple(ranges)), simulation.t))

    assert navigator.status == ("unreachable" if world == "closed" else "reached")
    assert simulation.collisions == 0


def test_same_seed_gives_the_same_rows() -> None:
    environment = shipped()["one-box"]

    first, second = (
        simulate(environment, variants()["bug2"], seed=7, noise=0.01) for _ in range(2)
    )

    assert first.rows == second.rows


@pytest.mark.parametrize(("name", "length"), SHORTEST.items())
def test_shortest_path_is_that_of_the_visibility_graph(name: str, length: float | None) -> None:
    assert shortest(shipped()[name]) == (length and pytest.approx(length, abs=5e-4))


@pytest.mark.parametrize(("goal", "length"), [([0, 0], 0.0), ([3, 0], 3.0)])
def test_goal_may_be_the_start_or_a_corner(goal: list[float], length: float) -> None:
    world = {"start": [0, 0], "goal": goal, "obstacles": [{"outer": [[3, 0], [4, 1], [4, -1]]}]}

    assert shortest(read_environments({"here": world}, "worlds")["here"]) == length


def test_no_name_of_a_variant_occurs_in_code() -> None:
    for path in (EXAMPLES / "bug").glob("*.py"):
        words = set(path.read_text("utf-8").lower().replace("_", " ").split())
        assert not words & {f'"{name}"' for name in variants()}, path
