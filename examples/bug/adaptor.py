"""Base of sensor adaptors: they alone know a sensor; it offers what they see over a service."""

from __future__ import annotations

from typing import TypeVar

from rtkit.component import Component, InPort, ServicePort
from rtkit.errors import Refused

from .messages import Beams, Distance
from .senses import Senses

T = TypeVar("T")
NOWHERE = (0.0, 0.0, 0.0)
"""Place of senses that are asked for distances only."""


class _Service:
    """Answers for what an adaptor sees now."""

    def __init__(self, adaptor: DistanceAdaptor) -> None:
        self._adaptor = adaptor

    @property
    def _seen(self) -> Senses:
        if self._adaptor.seen is None:
            raise Refused(f"{self._adaptor.instance} has seen nothing yet")
        return self._adaptor.seen

    def safe_distance(self) -> float:
        """Return how far a followed wall is kept [m]."""
        return float(self._seen.safe_distance())

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether the way ahead is blocked within the stop distance."""
        return bool(self._seen.obstacle_in_front_of_the_robot())

    def obstacle_on_the_left(self) -> bool:
        """Return whether something is on the left."""
        return bool(self._seen.obstacle_on_the_left())

    def obstacle_on_the_right(self) -> bool:
        """Return whether something is on the right."""
        return bool(self._seen.obstacle_on_the_right())

    def left_distance(self) -> float:
        """Return how far it is on the left [m]."""
        return float(self._seen.left_distance())

    def right_distance(self) -> float:
        """Return how far it is on the right [m]."""
        return float(self._seen.right_distance())

    def free_distance(self, bearing: float) -> tuple[float, ...]:
        """Return how far it is along a bearing: one number [m], none out of sight."""
        free = self._seen.free_distance(bearing)
        return () if free is None else (float(free),)

    def scan(self) -> Beams:
        """Return all beams, from right to left."""
        beams = list(self._seen.scan())
        return Beams(tuple(b for b, _ in beams), tuple(r for _, r in beams))


class DistanceAdaptor(Component):
    """Offer the hardware abstractions of distances.

    One who knows a sensor has an in port for it, and sets `seen` in each cycle.

    Attributes:
        seen: What is round the robot in this step; None before the first one.
    """

    vendor = "rtkit"
    category = "example"
    version = "1.0"
    execution_type = "ExtTrigExecutionContext"

    distance = ServicePort.provided(
        Distance, "distance0", implementation=_Service, doc="What is round the robot"
    )
    seen: Senses | None = None

    def on_activated(self, context: str) -> None:
        """Forget what an earlier run has left."""
        self.seen = None
        for port in self.ports.values():
            if isinstance(port, InPort):
                port.read_all()

    def next_of(self, port: InPort[T]) -> T:
        """Return the value of this step.

        Raises:
            Refused: None has come.
        """
        value = port.read()
        if value is None:
            raise Refused(f"nothing came at {self.instance}.{port.name} in this step")
        return value
