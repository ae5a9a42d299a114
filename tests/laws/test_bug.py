"""Laws of Bug navigation: runs in random worlds end with the right answer, and touch nothing."""

from __future__ import annotations

import sys
from collections import deque
from dataclasses import replace
from itertools import product
from math import cos, dist, pi, sin
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

pytest.importorskip("numpy")
sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))

from bug.assembly import WORDS, Assembly, read_assembly, variants
from bug.environments import Environment, bound, read_environments, shipped
from bug.simulation import Run, simulate

from rtkit.errors import Refused

PITCH = 3.2
"""Between the middles of obstacles [m]: none is wider than 2.56, so gaps are above 0.6."""
STOPS = settings(
    deadline=None,
    suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
)


@st.composite
def rings(draw: st.DrawFn, x: float, y: float) -> list[tuple[float, float]]:
    """Return a simply connected obstacle round a place, at most 1.28 m from it."""
    width, height, turn = (draw(st.floats(*each)) for each in ((0.2, 1.0), (0.2, 0.8), (0, 2 * pi)))
    t = 0.15
    corners = draw(
        st.sampled_from(
            [
                [(-width, -height), (width, -height), (width, height), (-width, height)],
                [
                    (-1, -0.8),
                    (1, -0.8),
                    (1, -0.8 + t),
                    (-1 + t, -0.8 + t),
                    (-1 + t, 0.8),
                    (-1, 0.8),
                ],
                [
                    (-1, -height),
                    (1, -height),
                    (1, height),
                    (1 - t, height),
                    (1 - t, t - height),
                    (t - 1, t - height),
                    (t - 1, height),
                    (-1, height),
                ],
                [(width, 0), (0.2 * cos(2), 0.2 * sin(2)), (0.9 * cos(4), height * sin(4))],
            ]
        )
    )
    return [
        (x + a * cos(turn) - b * sin(turn), y + a * sin(turn) + b * cos(turn)) for a, b in corners
    ]


def room(x: float, y: float, half: float) -> dict[str, object]:
    """Return walls 0.3 m thick round a square room."""

    def square(h: float) -> list[tuple[float, float]]:
        return [(x - h, y - h), (x + h, y - h), (x + h, y + h), (x - h, y + h)]

    return {"outer": square(half + 0.3), "holes": [square(half)]}


@st.composite
def worlds(draw: st.DrawFn) -> Environment:
    """Return a world of obstacles on a loose grid; start or goal may be in a closed room."""
    start = (draw(st.floats(-1.0, 7.0)), -2.4)
    goal = (draw(st.floats(-1.0, 7.0)), 2 * PITCH + 2.4)
    cells = draw(st.sets(st.sampled_from(list(product(range(3), range(3)))), max_size=6))
    closed = draw(st.sampled_from([None, None, start, goal]))
    obstacles: list[dict[str, object]] = [
        {"outer": draw(rings(i * PITCH, j * PITCH))}
        for i, j in sorted(cells)
        if closed is None or dist((i * PITCH, j * PITCH), closed) > 3.8
    ]
    if closed is not None:
        obstacles.append(room(*closed, draw(st.floats(0.7, 1.3))))
    world = {"start": start, "goal": goal, "obstacles": obstacles}
    return read_environments({"random": world}, "test")["random"]


def is_reachable(environment: Environment, clearance: float) -> bool:
    """Flood a grid of 0.2 m: an answer that owes nothing to the navigator."""
    (sx, sy), (gx, gy) = environment.start, environment.goal
    target = (round((gx - sx) * 5), round((gy - sy) * 5))
    seen, queue = {(0, 0)}, deque([(0, 0)])
    while queue:
        i, j = queue.popleft()
        if (i, j) == target:
            return True
        for near in ((i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)):
            x, y = sx + near[0] / 5, sy + near[1] / 5
            if near in seen or not (-5 < x < 12 and -5 < y < 12):
                continue
            seen.add(near)
            if environment.scene.distance((x, y)) > clearance:
                queue.append(near)
    return False


def check(environment: Environment, assembly: Assembly, sensors: str, direction: str) -> Run:
    """Run, and hold the run against all laws."""
    run = simulate(environment, assembly, sensors, direction, step_limit=6000)

    right = "reached" if is_reachable(environment, 0.12) else "unreachable"
    assert run.status == right or (run.status == "gave-up" and not assembly.is_complete)
    assert run.collisions == 0
    assert run.min_clearance >= environment.body_radius - 1e-6
    assert all(b.t > a.t for a, b in zip(run.rows, run.rows[1:], strict=False))
    changes = [(a.mode, b.mode) for a, b in zip(run.rows, run.rows[1:], strict=False)]
    assert changes.count(("goal", "follow")) == len(run.hits)
    assert changes.count(("follow", "goal")) == len(run.leaves)
    if assembly.bound is not None and sensors != "bumper":
        assert run.path_length <= _bound_of_a_real_robot(environment, assembly, sensors)
    return run


def _bound_of_a_real_robot(environment: Environment, assembly: Assembly, sensors: str) -> float:
    """Return the bound of a point robot for one that stands off, and turns in steps [m].

    A wall next to the m-line, or to the disc, stops it as if it were crossed, or met.
    """
    start, goal = environment.start, environment.goal
    far = dist(start, goal)
    wider = [g + (s - g) * (1 + 0.6 / far) for s, g in zip(start, goal, strict=True)]
    limit = bound(replace(environment, start=(wider[0], wider[1])), assembly)
    assert limit is not None
    walls = [
        (max(sum(dist(a, b) for a, b in zip(r, r[1:] + r[:1], strict=True)) for r in rings), rings)
        for rings in environment.obstacles
    ]
    if not walls:
        return far + 1
    stretch = max((p + pi) / p for p, _ in walls)  # 0.5 m off the walls
    factor = 1.15 if "laser" in sensors else 1.30
    line = [[s + (g - s) * k / 100 for s, g in zip(start, goal, strict=True)] for k in range(101)]
    near = sum(
        p
        for p, rings in walls
        if min(Environment("", start, goal, (rings,)).scene.gap(at) for at in line) < 0.6
    )
    boundary = limit - far + (near if assembly.bound.over == "m-line" else 0)
    return far + boundary * stretch * factor + 2 * len(walls) + 1


COMPLETE = sorted(name for name, each in variants().items() if each.is_complete)


@settings(STOPS, max_examples=6)
@given(worlds(), st.sampled_from(COMPLETE), st.sampled_from(["laser", "ir"]), st.booleans())
def test_runs_in_random_worlds_end_with_the_right_answer(
    environment: Environment, variant: str, sensors: str, is_left: bool
) -> None:
    check(environment, variants()[variant], sensors, "left" if is_left else "right")


@pytest.mark.campaign
@pytest.mark.timeout(3600)
@settings(STOPS, max_examples=600)
@given(
    worlds(),
    st.sampled_from(sorted(variants())),
    st.sampled_from(["laser", "ir", "laser+ir", "bumper"]),
    st.booleans(),
)
def test_runs_in_many_random_worlds_end_with_the_right_answer(
    environment: Environment, variant: str, sensors: str, is_left: bool
) -> None:
    check(environment, variants()[variant], sensors, "left" if is_left else "right")


operations = st.fixed_dictionaries(
    {key: st.sampled_from(list(choices)) for key, choices in WORDS.items()}
    | {"gain": st.sampled_from([0, 0.2, 0.5])}
)


def valid(value: dict[str, object]) -> Assembly | None:
    try:
        return read_assembly(value)
    except Refused as error:
        message = str(error)
        assert message.startswith("assembly: ")
        assert "\n" not in message
        return None


VALID = [
    {**dict(zip(WORDS, words, strict=True)), "gain": gain}
    for words in product(*WORDS.values())
    for gain in (0, 0.2)
    if valid({**dict(zip(WORDS, words, strict=True)), "gain": gain})
]
"""All valid assemblies, but for their gain."""


@given(operations)
def test_assembly_is_one_that_works_or_is_refused_with_one_sentence(
    value: dict[str, object],
) -> None:
    valid(value)


@settings(STOPS, max_examples=4)
@given(st.sampled_from(VALID), st.sampled_from(["closed", "one-box"]), st.booleans())
def test_random_valid_assemblies_keep_the_laws(
    value: dict[str, object], world: str, is_left: bool
) -> None:
    check(shipped()[world], read_assembly(value), "laser", "left" if is_left else "right")


@pytest.mark.campaign
@pytest.mark.timeout(3600)
@settings(STOPS, max_examples=300)
@given(worlds(), st.sampled_from(VALID), st.sampled_from(["laser", "ir"]), st.booleans())
def test_random_valid_assemblies_keep_the_laws_in_random_worlds(
    environment: Environment, value: dict[str, object], sensors: str, is_left: bool
) -> None:
    assume(read_assembly(value).is_complete)
    check(environment, read_assembly(value), sensors, "left" if is_left else "right")
