"""A spar among walls: a doorway lets it pass only along its own axis."""

from __future__ import annotations

from rtkit.planner import Command, Condition, CostTable, Problem, State

COLUMNS, ROWS = range(1, 6), range(1, 4)
_TO_ROW_3 = (1, 3)
"""Columns at which the wall between rows 2 and 3 has doorways."""
_TO_COLUMN_3 = (2, 3)
"""Rows at which the wall between columns 2 and 3 has doorways."""


def spar(
    start: tuple[int, int, int], goal: tuple[int, int, int], *, move: float, rotate: float
) -> Problem:
    """A spar at a place (x, y), parallel to the x axis (a=0) or to the y axis (a=1)."""
    steps = {"-x": (-1, 0), "+x": (1, 0), "-y": (0, -1), "+y": (0, 1)}
    commands = [_move(name, dx, dy) for name, (dx, dy) in steps.items()]
    commands.append(Command("rotate", lambda s: (s[0], s[1], 1 - s[2])))
    variables = {"x": COLUMNS, "y": ROWS, "a": (0, 1)}
    costs = CostTable(dict.fromkeys(steps, move) | {"rotate": rotate})
    return Problem(variables, start, dict(zip(variables, goal, strict=True)), commands, costs)


def is_direct(state: State) -> bool:
    """Whether a place is within columns and rows 2 and 3."""
    return state[0] in (2, 3) and state[1] in (2, 3)


def _move(name: str, dx: int, dy: int) -> Command:
    axis = 0 if dx else 1

    def is_inside(state: State) -> bool:
        return state[0] + dx in COLUMNS and state[1] + dy in ROWS

    def fits(state: State) -> bool:
        x, y, a = state
        if dx and {x, x + dx} == {2, 3}:
            return y in _TO_COLUMN_3 and a == axis
        if dy and {y, y + dy} == {2, 3}:
            return x in _TO_ROW_3 and a == axis
        return True

    return Command(
        name,
        lambda s: (s[0] + dx, s[1] + dy, s[2]),
        (
            Condition("there is a place", is_inside),
            Condition("no wall, or a doorway passed along the axis", fits),
        ),
    )
