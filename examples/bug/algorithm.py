"""Generic Bug algorithm, written once; what an assembly chooses is called by its word.

One control step is `Navigator.control`. Its words are those of Kchir, Ziadi, Ziane and Stinckwich,
"A top-down approach to managing variability in robotics algorithms".
"""

from __future__ import annotations

from math import atan2, cos, dist, hypot, inf, remainder, sin, tau
from typing import TYPE_CHECKING

from rtkit.errors import Malformed

from . import operations
from .assembly import CIRCUIT, LINE, TURN_ROUND, Assembly
from .surroundings import Surroundings
from .touching import follow_by_touch, way_free_by_trial

if TYPE_CHECKING:
    from .senses import Senses

Command = tuple[float, float]
Point = tuple[float, float]

PERIOD = 0.5
"""Time of one control step [s]."""
FASTEST, FASTEST_TURN = 0.4, 1.5
"""Bounds of the command [m/s], [rad/s]."""
REACHED, UNREACHABLE, GAVE_UP = "reached", "unreachable", "gave-up"
LEFT, RIGHT = "left", "right"
GOAL, FOLLOW = "goal", "follow"
SEARCHING, RETURNING, GOING_BACK = "searching", "returning to the hit point", "going to leave point"
NEAR = 0.40
"""How near a point of the boundary is met again [m]."""
ON_LINE = 0.10
"""How near the m-line a place is on it [m]."""
_STILL = (0.0, 0.0)
_FACING = 0.05
_ARC = 0.37
_INTO_WALL = sin(0.1)
_STOP = 0.45
_MET = 0.65
"""How far from the boundary a hit point may be to be met again along it [m]."""
_NARROW = 0.28
"""How far a way is free at least where another obstacle is next to the one that is followed [m]."""
_BODY = 0.2
_TURN_OFF = 0.45
"""By how much it turns from a wall that may be anywhere in what one range covers [rad]."""
_TOUCHED = 0.125
"""How far from the centre a place is at most that is felt now [m]."""


class Navigator:
    """Leads a robot to a goal, and asks nothing but the hardware abstractions.

    Args:
        assembly: The variant.
        goal: Where to go [m].
        direction: ``left`` turns left at a hit point, the wall on its right hand; or ``right``.
        goal_margin: How near is there [m].
        step: How far it goes in one control step at most [m].

    Attributes:
        status: Empty while it runs, then ``reached``, ``unreachable`` or ``gave-up``.
        hits: Places at which it began to follow an obstacle [m].
        leaves: Places at which it left one [m].
        reversals: How often it turned round at an earlier point.
        leave_point: The leave point that is known of this obstacle [m]; None before.
        following: Whether it follows an obstacle.

    Raises:
        Malformed: There is no such direction, or a number is not above 0.
    """

    def __init__(
        self,
        assembly: Assembly,
        goal: Point,
        direction: str = LEFT,
        goal_margin: float = 0.30,
        step: float = 0.2,
    ) -> None:
        if direction not in (LEFT, RIGHT):
            raise Malformed(f"a direction is left or right, not {direction!r}")
        if not (goal_margin > 0 and 0 < step <= FASTEST * PERIOD):
            raise Malformed("goal_margin is above 0 m, step from 0 to 0.2 m")
        self.assembly = assembly
        self.goal = goal
        self.goal_margin = goal_margin
        self.step = step
        self.configured = direction
        self.direction = direction
        self.status = ""
        self.following = False
        self.hits: list[Point] = []
        self.leaves: list[Point] = []
        self.ways: list[str] = []
        self.reversals = 0
        self.leave_point: Point | None = None
        self.task = SEARCHING
        self.aimed_at: Point | None = None
        self.slid = direction
        self.stale = 0
        self.least = operations.Least()
        self.around: Surroundings | None = None
        self.trial: Point | None = None
        self.turned_at: tuple[Point, float] | None = None
        self.went_from: Point | None = None
        self.looks_from: Point | None = None
        self.seeks: Point | None = None
        self.narrow: tuple[float, Point, float] | None = None
        self.narrowest = inf
        self._start: Point | None = None
        self.decided_at: Point | None = None

    @property
    def mode(self) -> str:
        """``follow`` from a hit point until the leave point, else ``goal``."""
        return FOLLOW if self.following else GOAL

    @property
    def side(self) -> float:
        """1 with the followed wall on the right, -1 on the left."""
        return 1.0 if self.direction == LEFT else -1.0

    @property
    def state(self) -> str:
        """What it is doing, in words."""
        return self.status or (self.task if self.following else "going to the goal")

    # The generic algorithm

    def control(self, senses: Senses, t: float) -> Command:
        """Return speed [m/s] and turning [rad/s] of the control step that begins at `t` [s]."""
        del t  # nothing is decided by a clock
        if self.status:
            return _STILL
        self._sense(senses)
        if self.goal_reached():
            return self.stop(REACHED)
        aim = None if self.following else operations.MOTIONS[self.assembly.motion](self)
        if aim is not None:
            return self.motion_to_goal(aim)
        if not self.following:
            return self.start_following()
        command = self.identify_leave_point()
        if self.is_leave_point_found() and self.research_complete():
            return self.go_to_leave_point(command)
        if self.complete_cycle_around_obstacle() and not self.is_leave_point_found():
            return self.try_narrow_place(command)
        return command

    def goal_reached(self) -> bool:
        """Return whether it is there."""
        return self.to_goal <= self.goal_margin

    def motion_to_goal(self, aim: float) -> Command:
        """Return the command towards a bearing [rad]."""
        return self.go_ahead(aim) if self.is_facing(aim) else self.face(aim)

    def face_goal(self) -> Command:
        """Return the command that turns to the goal on the spot."""
        return self.face(self.bearing)

    def face(self, bearing: float) -> Command:
        """Return the command that turns to a bearing on the spot [rad]."""
        return 0.0, max(-FASTEST_TURN, min(FASTEST_TURN, bearing / PERIOD))

    def is_facing(self, bearing: float) -> bool:
        """Return whether a bearing is ahead [rad]."""
        return abs(bearing) <= _FACING

    def go_ahead(self, aim: float = 0.0) -> Command:
        """Return the command that goes ahead, to the stop distance at most."""
        room = self.around.free(0.0, _BODY) - _STOP if self.around.has_ranges else self.step
        length = min(self.step, max(room, 0.03), max(self.to_goal - self.goal_margin / 2, 0.03))
        return self.arc(aim, length)

    def arc(self, bearing: float, length: float) -> Command:
        """Return the command to a place at a bearing [rad] and a distance [m]: arc or turn."""
        if abs(bearing) > _ARC:
            return self.face(bearing)
        way = length * (bearing / sin(bearing) if bearing else 1.0)
        return min(way / PERIOD, FASTEST), 2 * bearing / PERIOD

    def obstacle_in_front_of_the_robot(self) -> bool:
        """Return whether it must not go on ahead."""
        return self.senses.obstacle_in_front_of_the_robot()

    def start_following(self) -> Command:
        """Record the hit point, choose the direction and forget the last obstacle."""
        self.direction = operations.DIRECTIONS[self.assembly.direction](self)
        self.earlier = [*self.hits, *self.leaves]
        if not self.assembly.is_complete and self._goes_in_circles():
            return self.stop(GAVE_UP)
        self.hits.append(self.here)
        self.narrow = None
        self.ways.append(self.direction)
        self.following, self.task, self.leave_point = True, SEARCHING, None
        self.has_turned = False
        self.around.find_contact(self.bearing if self.around.has_ranges else None)
        self.circuit = operations.Circuit(self.here)
        self.has_met = self.is_at_boundary()
        self.was_off = self.off_line(self.here)
        self.least.hit(self.to_goal, self.assembly.leave == LINE)
        self.aimed_at = self.decided_at = self.trial = self.seeks = None
        if self.around.is_coarse:  # the wall may be on either side of what it sees: it turns off
            return self.face(self.side * _TURN_OFF)
        return self.wall_following()

    def identify_leave_point(self) -> Command:
        """Return the command along the obstacle, having looked for a leave point meanwhile."""
        self.compute_data()
        command = self.wall_following()
        if self.task == SEARCHING and self.assembly.memory == TURN_ROUND:
            self.on_visited_point()
        if self.task == RETURNING and self.circuit.has_returned(self.here):
            self.task, self.circuit = SEARCHING, operations.Circuit(self.hits[-1])
        if self.task == SEARCHING:
            command = self.find_leave_point() or command
        return command

    def compute_data(self) -> None:
        """Measure the way along the boundary, from where it is met if the hit point is far."""
        if not self.has_met:
            self.has_met = self.is_at_boundary()
            self.circuit = operations.Circuit(self.here)
        self.circuit.add(self.here, self.to_goal)

    def is_at_boundary(self) -> bool:
        """Return whether the way along the boundary leads by this place."""
        contact = self.around.contact
        return contact is None or dist(contact, self.here) <= _MET

    def wall_following(self) -> Command:
        """Return the command along the wall, which is on the right in direction left."""
        side = self.side
        if not self.around.has_ranges:
            return follow_by_touch(self, side)
        self.around.find_contact()
        step = min(self.step, 0.15) if self.around.is_coarse else self.step
        turn = self.around.roll(side, step)
        v, omega = self._coarse_arc(turn, step) if self.around.is_coarse else self.arc(turn, step)
        return self._to_line(v, omega) if v and self.assembly.leave == LINE else (v, omega)

    def _coarse_arc(self, turn: float, step: float) -> Command:
        """Return the command to a bearing that is not known well [rad], without turning to and fro.

        Each turn on the spot shows other places, so it may seem right to turn back at once.
        """
        if self.around.beside < 0.7 * self.around.safe:
            turn = self.side * max(turn * self.side, 0.2)
        if abs(turn) <= 0.25:
            self.turned_at = None
            return step / PERIOD, turn / PERIOD
        if self.turned_at is not None and self.turned_at[0] == self.here:
            if turn * self.turned_at[1] < 0 and self.around.free(0.0, 0.12) > 0.25:
                self.turned_at = None
                return 0.5 * step / PERIOD, 0.0
            if turn * self.turned_at[1] < 0:
                turn = self.side * 0.7
        self.turned_at = (self.here, turn)
        return self.face(turn)

    def on_visited_point(self) -> None:
        """Turn round, once for each hit, at a hit or leave point of earlier."""
        if self.has_turned or self.circuit.farthest <= 0.6:
            return
        if any(hypot(x - self.x, y - self.y) <= NEAR for x, y in self.earlier):
            self.has_turned, self.task = True, RETURNING
            self.reversals += 1
            self.turn_round()

    def turn_round(self) -> None:
        """Follow the boundary the other way from here."""
        self.direction = RIGHT if self.direction == LEFT else LEFT
        self.seeks = None if self.around.has_ranges else self.around.contact

    def find_leave_point(self) -> Command | None:
        """Look whether this is a leave point; return a command if that needs a motion."""
        return operations.LEAVES[self.assembly.leave](self)

    def is_leave_point_found(self) -> bool:
        """Return whether a leave point of this obstacle is known."""
        return self.leave_point is not None

    def research_complete(self) -> bool:
        """Return whether enough of the boundary is known to leave."""
        return self.assembly.research != CIRCUIT or self.circuit.is_complete or self.is_going_back

    @property
    def is_going_back(self) -> bool:
        """Whether it is on its way to a leave point known before."""
        return self.task == GOING_BACK

    def complete_cycle_around_obstacle(self) -> bool:
        """Return whether it has been round, back at the hit point."""
        return self.task == SEARCHING and self.circuit.is_complete

    def go_to_leave_point(self, command: Command) -> Command:
        """Return the command to the leave point, or away from the obstacle where it is there."""
        if not self.is_going_back and self.assembly.research != CIRCUIT:
            return self.leave()
        if not self.is_going_back:
            self.go_back()
        if not self.circuit.is_at_nearest(self.here):
            return command
        found = self.way_to_goal_is_free(_NARROW)
        if isinstance(found, tuple):
            return found
        if found:
            return self.leave()
        return self.stop(UNREACHABLE) if self.circuit.has_passed(self.here) else command

    def go_back(self) -> None:
        """Begin the shorter way along the boundary to the leave point."""
        self.task = GOING_BACK
        if self.circuit.is_shorter_back():
            self.turn_round()
        self.circuit.go_to_nearest()

    def try_narrow_place(self, command: Command) -> Command:
        """Go back where something stood so near that it did not leave, or report unreachable."""
        if self.narrow is None or self.narrow[0] > self.narrowest - 0.05:
            return self.stop(UNREACHABLE)
        self.circuit.nearest = self.narrow
        self.narrowest, self.leave_point = self.narrow[0], self.narrow[1]
        self.go_back()
        return command

    def note_narrow_place(self) -> None:
        """Remember the place nearest to the goal at which the way is free for a little only."""
        if self.following and (self.narrow is None or self.to_goal < self.narrow[0]):
            self.narrow = (self.to_goal, self.here, self.circuit.length)

    def leave(self) -> Command:
        """Leave the obstacle here and face the goal."""
        self.leaves.append(self.here)
        self.following = False
        self.stale = 0
        self.least.leave(self.to_goal)
        return self.face_goal()

    def stop(self, status: str) -> Command:
        """End with a status."""
        self.status = status
        return _STILL

    # What operations ask

    def way_to_goal_is_free(self, least: float = _STOP + 0.02) -> bool | Command | None:
        """Return whether the way to the goal is free so far [m]; a command to look there.

        It looks once at each place: None where it has just looked from next to here.
        """
        contact = self.around.contact
        if contact is not None:
            dx, dy = contact[0] - self.x, contact[1] - self.y
            far = hypot(dx, dy) or 1.0
            into = (dx * (self.goal[0] - self.x) + dy * (self.goal[1] - self.y)) / far
            limit = _INTO_WALL if self.around.has_ranges else 0.25
            if self.around.has_ranges and far < 0.8 * self.around.safe:
                limit = -0.25  # too near to go along it
            if far < self.around.safe + 0.1 and into > limit * self.to_goal:
                if self.assembly.leave == LINE and not self.around.has_ranges and far > _TOUCHED:
                    return None  # a wall not felt now may be passed before it is off the line
                if self.looks_from == self.here:  # turned here, it finds the wall in the way
                    self.decided_at = self.here
                return False
        if not self.around.has_ranges:
            return way_free_by_trial(self)
        if not self.around.sees(self.bearing):
            return self._look()
        self.decided_at = self.here
        free = self.around.free(self.bearing, 0.22)
        if free > _NARROW:
            self.note_narrow_place()
        return free > min(least, self.to_goal)

    def free_range(self) -> float:
        """Return the range towards the goal [m], which is in the field of view."""
        return self.around.free(self.bearing, _BODY)

    def _look(self) -> Command | None:
        """Turn to the goal, once at each place."""
        if self.was_decided():
            return None
        self.looks_from = self.here
        return self.face_goal()

    def was_decided(self) -> bool:
        """Return whether it has just looked from here, in vain."""
        return self.decided_at is not None and dist(self.decided_at, self.here) < 0.1

    def _to_line(self, v: float, omega: float) -> Command:
        """Shorten a step that would lead across the m-line."""
        now = self.off_line(self.here)
        angle = self.theta + omega * PERIOD / 2
        length = v * PERIOD
        then = self.off_line((self.x + length * cos(angle), self.y + length * sin(angle)))
        if now * then >= 0 or abs(now) < 0.03:
            return v, omega
        part = max(abs(now) / (abs(now) + abs(then)), 0.15)
        return v * part, omega * part

    def off_line(self, point: Point) -> float:
        """Return how far a point is to the left of the m-line [m]."""
        (sx, sy), (gx, gy) = self.start, self.goal
        return ((gx - sx) * (point[1] - sy) - (gy - sy) * (point[0] - sx)) / (
            hypot(gx - sx, gy - sy) or 1.0
        )

    def along_line(self, point: Point) -> float:
        """Return how far along the m-line a point is, from the start [m]."""
        (sx, sy), (gx, gy) = self.start, self.goal
        return ((gx - sx) * (point[0] - sx) + (gy - sy) * (point[1] - sy)) / (
            hypot(gx - sx, gy - sy) or 1.0
        )

    @property
    def start(self) -> Point:
        """Where it was first [m]."""
        return self._start or self.here

    def _goes_in_circles(self) -> bool:
        pairs = zip(self.hits, self.ways, strict=True)
        same = [
            p
            for p, way in pairs
            if way == self.direction and hypot(p[0] - self.x, p[1] - self.y) < NEAR
        ]
        return len(same) >= 2

    def _sense(self, senses: Senses) -> None:
        self.senses = senses
        if self.around is None:
            self.around = Surroundings(senses.safe_distance())
        self.here = self.x, self.y = senses.position()
        self.theta = senses.heading()
        self._start = self._start or self.here
        dx, dy = self.goal[0] - self.x, self.goal[1] - self.y
        self.to_goal = hypot(dx, dy)
        self.bearing = remainder(atan2(dy, dx) - self.theta, tau)
        side = self.side if self.following else 0.0
        self.around.update((self.x, self.y, self.theta), senses.scan(), side)
