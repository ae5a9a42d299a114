"""A hand that finds out by touch: an unknown object is felt, recorded, and planned around."""

from __future__ import annotations

from collections.abc import Collection, Hashable

from rtkit.planner import Command, Condition, Observation, Problem, State, Step

WIDTH, HEIGHT = 9, 5
WALLS = frozenset((x, y) for x in range(3, 8) for y in (1, 3))
START, GOAL = (1, 2), (9, 2)
_STEPS = {"left": (-1, 0), "right": (1, 0), "down": (0, -1), "up": (0, 1)}


def route(state: State, objects: Collection[Hashable]) -> Problem:
    """The way to the goal from a state, around the walls and the objects that are known."""

    def move(word: str, dx: int, dy: int) -> Command:
        def is_free(state: State) -> bool:
            x, y = state[0] + dx, state[1] + dy
            is_inside = 1 <= x <= WIDTH and 1 <= y <= HEIGHT
            return is_inside and (x, y) not in WALLS and (x, y) not in objects

        return Command(
            word,
            lambda s: (s[0] + dx, s[1] + dy),
            (Condition("the place is free as far as is known", is_free),),
        )

    commands = [move(word, dx, dy) for word, (dx, dy) in _STEPS.items()]
    variables = {"x": range(1, WIDTH + 1), "y": range(1, HEIGHT + 1)}
    return Problem(variables, state, {"x": GOAL[0], "y": GOAL[1]}, commands)


class TouchWorld:
    """A world with objects that nobody told of; the hand feels one when it would run into it."""

    def __init__(self, objects: Collection[State]) -> None:
        self._objects = objects
        self._state: State = START

    def look(self) -> Observation:
        """Return where the hand is."""
        return Observation(self._state)

    def perform(self, step: Step) -> Observation:
        """Move the hand, or feel what is in its way."""
        if step.after in self._objects:
            return Observation(self._state, frozenset([step.after]))
        self._state = step.after
        return Observation(self._state)
