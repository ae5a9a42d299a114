"""The generic Bug algorithm as a component: variant by configuration, sensors by connection."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rtkit.component import (
    Component,
    Manager,
    OutPort,
    Parameter,
    Point2D,
    ServicePort,
    TimedVelocity2D,
    Velocity2D,
)

from .algorithm import Navigator
from .assembly import assembly_of
from .messages import Distance, Localisation, Navigation, time_of
from .rules import constraint_of_variants


class RemoteSenses:
    """Hardware abstractions over two services; each is asked at most once in a control step."""

    def __init__(self, distance: Distance, localisation: Localisation) -> None:
        self._distance = distance
        self._localisation = localisation
        self._answers: dict[tuple[Any, ...], Any] = {}

    def next_step(self) -> None:
        """Forget what was answered in the last step."""
        self._answers.clear()

    def _ask(self, ask: Callable[..., Any], *arguments: float) -> Any:
        key = (ask.__name__, *arguments)
        if key not in self._answers:
            self._answers[key] = ask(*arguments)
        return self._answers[key]

    def position(self) -> tuple[float, float]:
        """Return the place [m]."""
        place = self._ask(self._localisation.position)
        return place.x, place.y

    def heading(self) -> float:
        """Return the heading [rad]."""
        return float(self._ask(self._localisation.heading))

    def safe_distance(self) -> float:
        """Return how far a followed wall is kept [m]."""
        return float(self._ask(self._distance.safe_distance))

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether the way ahead is blocked within the stop distance."""
        return bool(self._ask(self._distance.obstacle_in_front_of_the_robot))

    def obstacle_on_the_left(self) -> bool:
        """Return whether something is on the left."""
        return bool(self._ask(self._distance.obstacle_on_the_left))

    def obstacle_on_the_right(self) -> bool:
        """Return whether something is on the right."""
        return bool(self._ask(self._distance.obstacle_on_the_right))

    def left_distance(self) -> float:
        """Return how far it is on the left [m]."""
        return float(self._ask(self._distance.left_distance))

    def right_distance(self) -> float:
        """Return how far it is on the right [m]."""
        return float(self._ask(self._distance.right_distance))

    def free_distance(self, bearing: float) -> float | None:
        """Return how far it is along a bearing [m]; None where nothing looks."""
        found = self._ask(self._distance.free_distance, bearing)
        return float(found[0]) if found else None

    def scan(self) -> list[tuple[float, float]]:
        """Return all beams: bearing [rad] and range [m]."""
        beams = self._ask(self._distance.scan)
        return list(zip(beams.bearings, beams.ranges, strict=True))


class BugNavigator(Component):
    """Lead a robot to a goal among obstacles that it does not know, or find that there is no way.

    A run begins when it is activated.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    execution_type = "ExtTrigExecutionContext"

    distance = ServicePort.required(Distance, timeout_s=5.0, doc="What is round the robot")
    localisation = ServicePort.required(Localisation, timeout_s=5.0, doc="Where it is")
    cmd = OutPort(TimedVelocity2D, doc="How to move until the next step")
    navigation = OutPort(Navigation, doc="What it does, and whether it has ended")
    run = Parameter("run", doc="Name of the run; another one begins anew")
    variant = Parameter(
        "bug2",
        constraint=constraint_of_variants(),
        doc="Algorithm: a name, or an assembly of operations as JSON",
    )
    goal = Parameter((0.0, 5.0), unit="m", doc="Where to go")
    direction = Parameter("left", constraint="(left,right)", doc="Which way to turn at a wall")
    goal_margin = Parameter(0.3, unit="m", constraint="x>0", doc="How near to the goal is there")
    step = Parameter(0.2, unit="m", constraint="0<x<=0.2", doc="How far at most in a step")
    period = Parameter(0.5, unit="s", constraint="0.5<=x<=0.5", doc="Of a step")

    def on_activated(self, context: str) -> None:
        """Begin at the start."""
        goal_x, goal_y = self.goal
        self._navigator = Navigator(
            assembly_of(self.variant),
            (goal_x, goal_y),
            direction=self.direction,
            goal_margin=self.goal_margin,
            step=self.step,
        )
        self._senses = RemoteSenses(self.distance.client, self.localisation.client)
        self._steps = 0

    def on_execute(self, context: str) -> None:
        """Do a control step."""
        navigator, senses = self._navigator, self._senses
        senses.next_step()
        t = self._steps * self.period
        self._steps += 1
        v, omega = navigator.control(senses, t)
        tm = time_of(t)
        self.cmd.write(TimedVelocity2D(tm, Velocity2D(v, 0.0, omega)))
        (x, y), theta = senses.position(), senses.heading()
        self.navigation.write(
            Navigation(
                tm,
                navigator.mode,
                navigator.status,
                navigator.state,
                tuple(Point2D(*place) for place in navigator.hits),
                tuple(Point2D(*place) for place in navigator.leaves),
                navigator.reversals,
                x,
                y,
                theta,
                v,
                omega,
            )
        )


def BugNavigatorInit(manager: Manager) -> None:  # noqa: N802 - the name that loaders look for
    """Register the component type of this module."""
    manager.register_factory(BugNavigator)
