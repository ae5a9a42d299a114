"""Shows a robot as live properties, and keeps the record of its run."""

from __future__ import annotations

import rtkit
from rtkit.component import Component, InPort, Manager, Parameter, Point2D, ServicePort
from rtkit.errors import Refused

from .messages import ONE_EACH_TICK, Body, Navigation, Outcome, PathRow, Record, seconds
from .records import GAVE_UP, GOAL


class Shown:
    """Shows a robot: each attribute is a live property.

    Attributes:
        run: Name of the run.
        status: Empty while under way; ``reached``, ``unreachable`` or ``gave-up`` at the end.
        state: What the navigator does, in a few words.
        mode: ``goal`` or ``follow``.
        time: Simulated time [s].
        pose: Where the robot is [m, m, rad].
        velocity: Its speed ahead and turning in the last step [m/s, rad/s].
        goal: Where it goes [m].
        hits: Places where following began [m].
        leaves: Places where it ended [m].
        reversals: How often it turned round at an earlier point.
    """

    def __init__(self, rows: list[PathRow]) -> None:
        self.run = ""
        self.status = ""
        self.state = ""
        self.mode = ""
        self.time = 0.0
        self.pose = (0.0, 0.0, 0.0)
        self.velocity = (0.0, 0.0)
        self.goal = (0.0, 0.0)
        self.hits: tuple[tuple[float, float], ...] = ()
        self.leaves: tuple[tuple[float, float], ...] = ()
        self.reversals = 0
        self._rows = rows

    def get_path(self) -> list[tuple[float, float]]:
        """Return the places so far [m], one for each control step."""
        return [(row.x, row.y) for row in list(self._rows)]


class _Kept:
    """Answers for the record of a run."""

    def __init__(self, component: MobileRobotProperty) -> None:
        self._component = component

    def outcome(self) -> Outcome:
        """Return how the run is so far."""
        return self._component.outcome

    def rows(self, first: int, count: int) -> tuple[PathRow, ...]:
        """Return rows from the first one asked for on."""
        return tuple(self._component.kept[max(first, 0) : max(first, 0) + max(count, 0)])


class MobileRobotProperty(Component):
    """Show a robot as live properties of a service with the name of the instance.

    There is a slash in the name of the service where the instance has a dot.

    It keeps each row of the run, too.

    Attributes:
        kept: The rows of the run so far.
        outcome: How the run is so far.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    execution_type = "ExtTrigExecutionContext"

    body = InPort(Body, properties=ONE_EACH_TICK, doc="Where the robot is, from the simulator")
    navigation = InPort(Navigation, properties=ONE_EACH_TICK, doc="What the navigator does")
    record = ServicePort.provided(Record, "record0", implementation=_Kept, doc="Rows of the run")
    run = Parameter("run", doc="Name of the run")
    goal = Parameter((0.0, 5.0), unit="m", doc="Where the robot goes")

    def on_initialize(self) -> None:
        """Open the service."""
        self.kept: list[PathRow] = []
        self.outcome = Outcome()
        self._shown = Shown(self.kept)
        self._served = rtkit.serve(self._shown, self.instance.replace(".", "/"))

    def on_finalize(self) -> None:
        """Close the service."""
        self._served.close()

    def on_activated(self, context: str) -> None:
        """Begin a record."""
        self.kept = []
        self.outcome = Outcome(run=self.run)
        fresh = Shown(self.kept)
        fresh.run, fresh.goal = self.run, tuple(self.goal)
        vars(self._shown).update(vars(fresh))
        for port in (self.body, self.navigation):
            port.read_all()

    def on_execute(self, context: str) -> None:
        """Note what this step brought."""
        body, navigation = self.body.read(), self.navigation.read()
        if body is None or navigation is None:
            raise Refused(f"nothing came at {self.instance} in this step")
        self._note(body, navigation)
        status = navigation.status or (GAVE_UP if body.is_last else "")
        self.outcome = Outcome(
            self.run,
            status,
            navigation.state,
            len(self.kept),
            navigation.hits,
            navigation.leaves,
            navigation.reversals,
            body.collisions,
            body.min_clearance,
        )
        self._show(body, navigation, status)

    def _note(self, body: Body, navigation: Navigation) -> None:
        odometry = (navigation.x, navigation.y, navigation.theta)
        mode = navigation.mode if self.kept else GOAL  # a hit at the start shows from the next step
        self.kept.append(PathRow(seconds(body.tm), body.x, body.y, body.theta, mode, *odometry))

    def _show(self, body: Body, navigation: Navigation, status: str) -> None:
        shown = self._shown
        shown.state, shown.mode, shown.time = navigation.state, navigation.mode, seconds(body.tm)
        shown.pose = (body.x, body.y, body.theta)
        shown.velocity = (navigation.v, navigation.omega)
        shown.hits, shown.leaves = _places(navigation.hits), _places(navigation.leaves)
        shown.reversals = navigation.reversals
        shown.status = status  # the last one: who waits for it finds all the others


def _places(points: tuple[Point2D, ...]) -> tuple[tuple[float, float], ...]:
    return tuple((point.x, point.y) for point in points)


def MobileRobotPropertyInit(manager: Manager) -> None:  # noqa: N802 - loaders look for it
    """Register the component type of this module."""
    manager.register_factory(MobileRobotProperty)
