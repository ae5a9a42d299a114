"""Bug algorithms as behaviours of a mobile robot: ``behaviors=bug2=bug.behavior:bug2``.

Each variant of `variants.json` is a class here, by its name, dashes as underscores. A robot needs
nothing but its laser, and knows where it is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.errors import Refused

from .algorithm import PERIOD, REACHED, Navigator
from .assembly import Assembly, variants
from .senses import LASER_REACH, LaserSenses

if TYPE_CHECKING:
    from rtkit.services.chassis import Chassis
    from rtkit.services.running import Goal, Twist

_LONGEST_S = 4 * PERIOD
"""How long a robot may take for what is meant for one control step."""


class BugBehavior:
    """Leads a robot from goal to goal among obstacles that it does not know.

    Attributes:
        assembly: The variant.
        remaining: What is left of the route.
    """

    assembly: Assembly

    def __init__(self, chassis: Chassis, route: Sequence[Goal]) -> None:
        self.remaining = list(route)
        self._chassis = chassis
        self._begin()

    def _begin(self) -> None:
        goal = self.remaining[0]
        reach = min(0.2, self._chassis.tops[0] * PERIOD)
        self._navigator = Navigator(self.assembly, (goal.x, goal.y), step=reach)
        self._command = (0.0, 0.0)
        self._left, self._spent = 0.0, 0.0

    def step(self, seconds: float) -> Twist | None:
        """Return how to move next; a control step lasts until the robot has done what it said."""
        v, omega = self._command
        ahead, _, turning = self._chassis.velocity
        self._spent += seconds
        self._left -= (ahead / v if v else turning / omega if omega else 1.0) * seconds
        if self._left < seconds / 10 or self._spent > _LONGEST_S:
            if not self._decide():
                return None
            v, omega = self._command
        share = max(0.0, min(1.0, self._left / seconds))
        return v * share, 0.0, omega * share

    def _decide(self) -> bool:
        """Do a control step of the algorithm; tell whether there is more to do."""
        senses = LaserSenses(self._chassis.pose, self._chassis.ranges(LASER_REACH))
        self._command = self._navigator.control(senses, 0.0)
        self._left, self._spent = PERIOD, 0.0
        status = self._navigator.status
        if status and status != REACHED:
            raise Refused(f"the goal is {status}")
        if status:
            del self.remaining[0]
            if self.remaining:
                self._begin()
        return bool(self.remaining)


def __getattr__(name: str) -> type[BugBehavior]:
    known = {each.replace("-", "_"): assembly for each, assembly in variants().items()}
    if name not in known:
        raise AttributeError(f"there is no variant {name}; there are {', '.join(sorted(known))}")
    return type(name, (BugBehavior,), {"assembly": known[name]})
