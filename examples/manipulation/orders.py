"""Data types of the ports between supervisor and manipulator: one order, one report."""

from __future__ import annotations

from dataclasses import dataclass

from rtkit.component import Double, Long


@dataclass(frozen=True)
class Order:
    """One command for the manipulator.

    Attributes:
        number: Grows with each order; one that came before is not done again.
        kind: ``travel``, ``over`` (above things), ``turn``, ``grip`` or ``release``.
        x: Where to [m].
        y: Where to [m].
        theta: Direction of the jaws there [rad].
    """

    number: Long = 0
    kind: str = ""
    x: Double = 0.0
    y: Double = 0.0
    theta: Double = 0.0


@dataclass(frozen=True)
class Report:
    """What the sensors of the manipulator tell.

    Attributes:
        number: Of the last order.
        outcome: What became of it: ``idle`` (none yet), ``busy``, ``done``, ``touched`` (something
            is in the way), ``empty`` (the jaws felt nothing between them), ``refused``.
        x: Where the jaws are [m].
        y: Where the jaws are [m].
        theta: Their direction [rad].
        is_closed: The jaws are closed.
        is_gripping: Something is between them.
        contact: Side that was touched, seen from the jaws: ahead, left, behind or right.
        contact_x: Where [m].
        contact_y: Where [m].
    """

    number: Long = 0
    outcome: str = "idle"
    x: Double = 0.0
    y: Double = 0.0
    theta: Double = 0.0
    is_closed: bool = False
    is_gripping: bool = False
    contact: str = ""
    contact_x: Double = 0.0
    contact_y: Double = 0.0
