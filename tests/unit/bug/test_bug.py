"""Bug navigation in its own worlds: lengths of ideal walkers, right answers, no collision."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("numpy")
EXAMPLES = Path(__file__).parents[3] / "examples"
sys.path.insert(0, str(EXAMPLES))

from bug.assembly import variants  # noqa: E402
from bug.environments import shipped, shortest  # noqa: E402
from bug.simulation import simulate  # noqa: E402

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


def test_same_seed_gives_the_same_rows() -> None:
    environment = shipped()["one-box"]

    first, second = (
        simulate(environment, variants()["bug2"], seed=7, noise=0.01) for _ in range(2)
    )

    assert first.rows == second.rows


@pytest.mark.parametrize(("name", "length"), SHORTEST.items())
def test_shortest_path_is_that_of_the_visibility_graph(name: str, length: float | None) -> None:
    assert shortest(shipped()[name]) == (length and pytest.approx(length, abs=5e-4))


def test_no_name_of_a_variant_occurs_in_code() -> None:
    for path in (EXAMPLES / "bug").glob("*.py"):
        words = set(path.read_text("utf-8").lower().replace("_", " ").split())
        assert not words & {f'"{name}"' for name in variants()}, path
