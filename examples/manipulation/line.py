"""Jaws on a line: they open, close, move, carry a block and push it.

A state of `jaws` is the place of the jaws and whether they are closed; of `carrying` also the
place of the block, which in `jaws` lies fixed.
"""

from __future__ import annotations

from rtkit.planner import Command, Condition, CostTable, Problem, Row, State

CLOSED, OPEN = 1, 0
ALL_ONE = CostTable()
OPEN_MOVES_COST_2 = CostTable(
    rows=(Row("Move left", {"h": OPEN}, 2), Row("Move right", {"h": OPEN}, 2))
)
CARRYING_COSTS = CostTable(
    {"Carry left": 2, "Carry right": 2, "Push left": 2, "Push right": 2}, default=1
)
_SIDES = (("left", -1), ("right", 1))


def _set(state: State, h: int) -> State:
    return (state[0], h, *state[2:])


_HANDS = (
    Command(
        "Open", lambda s: _set(s, OPEN), (Condition("jaws are closed", lambda s: s[1] == CLOSED),)
    ),
    Command(
        "Close", lambda s: _set(s, CLOSED), (Condition("jaws are open", lambda s: s[1] == OPEN),)
    ),
)


def jaws(
    start: tuple[int, int], goal: tuple[int, int], costs: CostTable = ALL_ONE, *, block: int = 2
) -> Problem:
    """Jaws over five places; closed they can neither enter nor leave the place of the block."""
    places = range(1, 6)

    def move(name: str, by: int) -> Command:
        def is_free(state: State) -> bool:
            return state[1] == OPEN or block not in (state[0], state[0] + by)

        return Command(
            f"Move {name}",
            lambda s: (s[0] + by, s[1]),
            (
                Condition("there is a place", lambda s: s[0] + by in places),
                Condition("jaws are open, or far from the block", is_free),
            ),
        )

    commands = [*(move(name, by) for name, by in _SIDES), *_HANDS]
    variables = {"x": places, "h": (OPEN, CLOSED)}
    named = dict(zip(variables, goal, strict=True))
    return Problem(variables, start, named, commands, costs)


def carrying(
    start: tuple[int, int, int], goal: dict[str, int], *, may_push: bool = True
) -> Problem:
    """Jaws and a block over five places: closed around the block they carry it, beside it push."""
    places = range(1, 6)

    def commands_to(name: str, by: int) -> list[Command]:
        def goes_on(state: State) -> bool:
            return state[0] + by in places

        def is_held(state: State) -> bool:
            return state[1] == CLOSED and state[0] == state[2]

        def is_pushing(state: State) -> bool:
            return state[1] == CLOSED and state[0] + by == state[2]

        room = Condition("there is a place", goes_on)
        made = [
            Command(
                f"Move {name}",
                lambda s: (s[0] + by, s[1], s[2]),
                (
                    room,
                    Condition("the block is not held", lambda s: not is_held(s)),
                    Condition("the block is not in the way", lambda s: not is_pushing(s)),
                ),
            ),
            Command(
                f"Carry {name}",
                lambda s: (s[0] + by, s[1], s[2] + by),
                (room, Condition("the block is held", is_held)),
            ),
        ]
        if may_push:
            made.append(
                Command(
                    f"Push {name}",
                    lambda s: (s[0] + by, s[1], s[2] + by),
                    (
                        Condition("the block is beside closed jaws", is_pushing),
                        Condition("there is a place for it", lambda s: s[2] + by in places),
                    ),
                )
            )
        return made

    commands = [*(c for name, by in _SIDES for c in commands_to(name, by)), *_HANDS]
    variables = {"x": places, "h": (OPEN, CLOSED), "y": places}
    return Problem(variables, start, goal, commands, CARRYING_COSTS)
