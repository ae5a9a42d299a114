"""Carries a plan out, an order at a time, and learns from what the jaws feel.

Where the jaws feel nothing between them, the neighbouring spots are searched: first the middle,
then right, up, left, down, then the corners counterclockwise from right-up (`SEARCH`), each a
third of a place away.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from manipulation.knowledge import UNIT, Pose, Site, Thing, cells_of, swept
from manipulation.language import Place
from manipulation.orders import Order, Report
from manipulation.ways import PlanStep

CELL = 0.1
"""From one place to the next [m]."""
QUARTER = math.pi / 2
_THIRD = 1 / 3
SEARCH = tuple(
    (dx * _THIRD, dy * _THIRD)
    for dx, dy in ((0, 0), (1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))
)
"""Where the jaws look for a thing, relative to the middle of its place [places], in this order."""


class Execution:
    """The steps that are left of a plan, and the order that is being done.

    Attributes:
        steps: What is left; the first is being done.
        event: What happened that the plan did not foresee: ``touched``, ``lost``, or nothing.
        unknown: Places in which something was touched that is not known.
        spots: Where a thing that is to be gripped is still looked for [places].
    """

    def __init__(self, site: Site, steps: Iterable[PlanStep], number: int) -> None:
        self._site = site
        self.steps = list(steps)
        self._number = number
        self.order: Order | None = None
        self.event = ""
        self.unknown: Place | None = None
        self.spots: list[tuple[float, float]] = []
        self._is_centring = False
        self._advance()

    def see(self, report: Report) -> bool:
        """Take a report; return whether a step of the plan was completed."""
        if self.order is None or report.number != self.order.number or report.outcome == "busy":
            return False
        order, self.order = self.order, None
        if self.event:  # it was told to go back to where it felt nothing
            return False
        step = self.steps[0]
        if report.outcome in ("touched", "refused"):
            self._touched(step, report)
            return False
        if step.kind == "grip" and not self._is_centring:
            return self._gripping(step, order, report)
        return self._done(step)

    def _advance(self) -> None:
        """Give the order of the next step, if there is one."""
        self.order = None
        if not self.steps:
            return
        step = self.steps[0]
        self._is_centring = False
        if step.kind == "grip":
            self.spots = spots_for(self._site.things[step.name])
            self._look()
        else:
            self._give(step.kind, step.pose)

    def _give(self, kind: str, pose: Pose, off: tuple[float, float] = (0.0, 0.0)) -> None:
        self._number += 1
        x, y, turned = pose
        place = ((x + off[0]) * CELL, (y + off[1]) * CELL)
        self.order = Order(self._number, kind, *place, turned * QUARTER)

    def _look(self) -> None:
        """Go above the next spot where a thing may be."""
        self._give("over", self.steps[0].pose, self.spots[0])

    def _gripping(self, step: PlanStep, order: Order, report: Report) -> bool:
        thing = self._site.things[step.name]
        if order.kind == "over":
            self._give("grip", step.pose, self.spots[0])
            return False
        if not report.is_gripping:
            thing.empty.append(self.spots.pop(0))
            if self.spots:
                self._look()
            else:
                self.event = "lost"
            return False
        thing.found = self.spots[0]
        thing.empty.clear()
        self._site.holding = step.name
        if thing.found == (0.0, 0.0):
            return self._done(step)
        # Lifted, it is brought to the middle of its place: there the plan goes on.
        self._is_centring = True
        self._give("over", step.pose)
        return False

    def _done(self, step: PlanStep) -> bool:
        site = self._site
        site.hand = step.pose
        if site.holding:
            thing = site.things[site.holding]
            thing.pose = (*step.pose[:2], step.pose[2] if thing.is_bar else thing.pose[2])
            thing.found = (0.0, 0.0)
        if step.kind == "release":
            site.holding = ""
        del self.steps[0]
        self._advance()
        return True

    def _touched(self, step: PlanStep, report: Report) -> None:
        site = self._site
        self.event = "touched"
        body = site.things[site.holding] if site.holding else Thing(site.hand)
        at = (*site.hand[:2], body.pose[2])
        shape = body.shape if site.holding else UNIT
        there = (*step.pose[:2], step.pose[2] if body.is_bar else at[2])
        entered = swept(shape, at) if there[2] != at[2] else cells_of(shape, there)
        poses = {name: each.pose for name, each in site.things.items()}
        known = site.blocked(poses) | cells_of(shape, at)
        met = (report.contact_x / CELL, report.contact_y / CELL)
        near = sorted(entered - known, key=lambda place: math.dist(place, met))
        self.unknown = near[0] if near else None
        self._give("travel", site.hand)


def spots_for(thing: Thing) -> list[tuple[float, float]]:
    """Return where a thing is looked for: where it was felt, else where it was not looked yet."""
    if thing.found is not None:
        return [thing.found, *(spot for spot in SEARCH if spot != thing.found)]
    return [spot for spot in SEARCH if spot not in thing.empty] or list(SEARCH)
