"""Made-up runs for tests of what is written of runs."""

from __future__ import annotations

from itertools import pairwise
from math import atan2, dist

from bug.environments import Environment
from bug.records import Choice, Record, Row

BOX = (((-1.0, -0.5), (2.5, -0.5), (2.5, 1.5), (-1.0, 1.5)),)
WORLD = Environment(
    name="one-box",
    start=(0.0, -4.0),
    goal=(0.0, 5.0),
    obstacles=(BOX,),
    reachable=True,
    note="one <box>",
)
CORNERS = [
    ((0.0, -4.0), "goal"),
    ((0.0, -0.95), "follow"),
    ((-1.3, -0.8), "follow"),
    ((-1.3, 1.8), "follow"),
    ((0.0, 1.8), "goal"),
    ((0.0, 4.8), "goal"),
]


def rows(corners=CORNERS, step: float = 0.2) -> list[Row]:
    """Walk along straight lines, a row every 0.2 m."""
    made, t = [], 0.0
    for (a, mode), (b, _) in pairwise(corners):
        count = max(1, round(dist(a, b) / step))
        theta = atan2(b[1] - a[1], b[0] - a[0])
        for i in range(count):
            x, y = (p + (q - p) * i / count for p, q in zip(a, b, strict=True))
            made.append(Row(t, x, y, theta, mode))
            t += 0.5
    (x, y), mode = corners[-1]
    return [*made, Row(t, x, y, made[-1].theta, mode)]


def record(variant: str = "bug2", sensors: str = "laser", **more: object) -> Record:
    """Return a run round the box."""
    made = Record(
        choice=Choice("one-box", variant, sensors, "left"),
        environment=WORLD,
        status="reached",
        rows=rows(),
        hits=[CORNERS[1][0]],
        leaves=[CORNERS[4][0]],
        reversals=0,
        collisions=0,
        min_clearance=0.3,
        has_line=True,
        shortest=9.28,
        bound=20.0,
    )
    return made._replace(**more)
