"""A spar among walls: a doorway lets it pass only along its own axis.

In `spar` the hand holds it all the time. In `handled` the hand grasps and releases it at any place,
in any orientation of its own and of the spar.
"""

from __future__ import annotations

from collections.abc import Mapping

from rtkit.planner import Command, Condition, CostTable, Problem, State

COLUMNS, ROWS = range(1, 6), range(1, 4)
_TO_ROW_3 = (1, 3)
"""Columns at which the wall between rows 2 and 3 has doorways."""
_TO_COLUMN_3 = (2, 3)
"""Rows at which the wall between columns 2 and 3 has doorways."""
STEPS = {"-x": (-1, 0), "+x": (1, 0), "-y": (0, -1), "+y": (0, 1)}
HANDLING = {
    **{f"move {name}": 1 for name in STEPS},
    **{f"carry {name}": 2 for name in STEPS},
    **{"turn": 1, "rotate": 3, "grasp": 1, "release": 1},
}
"""Costs of an empty hand's moves and turn, of what it does with the spar, of grasp and release."""


def spar(
    start: tuple[int, int, int], goal: tuple[int, int, int], *, move: float, rotate: float
) -> Problem:
    """A spar at a place (x, y), parallel to the x axis (a=0) or to the y axis (a=1)."""
    commands = [_move(name, dx, dy) for name, (dx, dy) in STEPS.items()]
    commands.append(Command("rotate", lambda s: (s[0], s[1], 1 - s[2])))
    variables = {"x": COLUMNS, "y": ROWS, "a": (0, 1)}
    costs = CostTable(dict.fromkeys(STEPS, move) | {"rotate": rotate})
    return Problem(variables, start, dict(zip(variables, goal, strict=True)), commands, costs)


def is_direct(state: State) -> bool:
    """Whether a place is within columns and rows 2 and 3."""
    return state[0] in (2, 3) and state[1] in (2, 3)


def handled(
    start: State, goal: Mapping[str, int], costs: Mapping[str, float] = HANDLING
) -> Problem:
    """A hand at (x, y) in orientation a, closed (h=1) or open, and a spar at (sx, sy) in sa.

    The open hand goes through doorways as it likes. Held, the spar must lie along the way through
    one, and so must the hand: if it holds the spar across, it has to grasp it otherwise before.
    """
    commands = [*map(_walk, STEPS), *map(_carry, STEPS)]
    is_open, is_held = Condition("the hand is open", _is_open), Condition("the spar is held", _held)
    at_spar = Condition("the spar is here", lambda s: s[:2] == s[4:6])
    commands += [
        Command("turn", lambda s: (*s[:2], 1 - s[2], *s[3:]), (is_open,)),
        Command("rotate", lambda s: (*s[:2], 1 - s[2], 1, *s[4:6], 1 - s[6]), (is_held,)),
        Command("grasp", lambda s: (*s[:3], 1, *s[4:]), (is_open, at_spar)),
        Command("release", lambda s: (*s[:3], 0, *s[4:]), (is_held,)),
    ]
    variables = {"x": COLUMNS, "y": ROWS, "a": (0, 1), "h": (0, 1)}
    of_spar = {"sx": COLUMNS, "sy": ROWS, "sa": (0, 1)}
    return Problem(variables | of_spar, start, goal, commands, costs)


def _is_open(state: State) -> bool:
    return state[3] == 0


def _held(state: State) -> bool:
    return state[3] == 1 and state[:2] == state[4:6]


def _walk(name: str) -> Command:
    dx, dy = STEPS[name]

    def can(state: State) -> bool:
        x, y = state[:2]
        return _is_open(state) and any(_passes(x, y, dx, dy, a) for a in (0, 1))

    return Command(
        f"move {name}",
        lambda s: (s[0] + dx, s[1] + dy, *s[2:]),
        (Condition("the open hand is not before a wall", can),),
    )


def _carry(name: str) -> Command:
    dx, dy = STEPS[name]

    def can(state: State) -> bool:
        x, y, a, *_, sa = state
        return _held(state) and all(_passes(x, y, dx, dy, each) for each in (a, sa))

    return Command(
        f"carry {name}",
        lambda s: (s[0] + dx, s[1] + dy, *s[2:4], s[4] + dx, s[5] + dy, s[6]),
        (Condition("no wall, or a doorway that hand and spar pass along their axis", can),),
    )


def _passes(x: int, y: int, dx: int, dy: int, a: int) -> bool:
    """Whether what lies in orientation a passes from one place to the next."""
    if dx and {x, x + dx} == {2, 3}:
        return y in _TO_COLUMN_3 and a == 0
    if dy and {y, y + dy} == {2, 3}:
        return x in _TO_ROW_3 and a == 1
    return True


def _move(name: str, dx: int, dy: int) -> Command:
    def is_inside(state: State) -> bool:
        return state[0] + dx in COLUMNS and state[1] + dy in ROWS

    def fits(state: State) -> bool:
        x, y, a = state
        return _passes(x, y, dx, dy, a)

    return Command(
        name,
        lambda s: (s[0] + dx, s[1] + dy, s[2]),
        (
            Condition("there is a place", is_inside),
            Condition("no wall, or a doorway passed along the axis", fits),
        ),
    )
