"""Six variables of ten points each: a million states, of which a search sees what it needs."""

from __future__ import annotations

from hashlib import md5
from itertools import product
from operator import getitem

from rtkit.planner import Command, Condition, Problem, State

AXES, POINTS = 6, 10
_BLOCKED_OF_100 = 25


class Large:
    """The instance of a seed: where it is blocked, and what steps cost."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._entering: dict[State, int] = {}
        self.start, self.goal = (0,) * AXES, (POINTS - 1,) * AXES
        self.weights = [1 + byte % 5 for byte in md5(f"{seed}:w".encode()).digest()[:AXES]]
        self._left = [[w * (POINTS - 1 - value) for value in range(POINTS)] for w in self.weights]

    def problem(self) -> Problem:
        """Return the way from one corner to the opposite one."""
        variables = {f"v{axis}": range(POINTS) for axis in range(AXES)}
        goal = dict.fromkeys(variables, POINTS - 1)
        axes = product(range(AXES), (1, -1))
        commands = [self._step(axis, by) for axis, by in axes]
        return Problem(variables, self.start, goal, commands, self._cost)

    def heuristic(self, state: State) -> float:
        """Return what is left to be paid at least."""
        return sum(map(getitem, self._left, state))

    def _enter(self, state: State) -> int:
        """Return what entering a state costs more; below 0 if it is blocked."""
        digest = md5(f"{self._seed}:{','.join(map(str, state))}".encode()).digest()
        is_end = state in (self.start, self.goal)
        is_blocked = int.from_bytes(digest[:4], "big") % 100 < _BLOCKED_OF_100
        cost = int.from_bytes(digest[4:8], "big") % 5
        self._entering[state] = -1 if is_blocked and not is_end else cost
        return self._entering[state]

    def _step(self, axis: int, by: int) -> Command:
        def after(state: State) -> State:
            return (*state[:axis], state[axis] + by, *state[axis + 1 :])

        def is_free(state: State) -> bool:
            if not 0 <= state[axis] + by < POINTS:
                return False
            there = after(state)
            known = self._entering.get(there)
            return (self._enter(there) if known is None else known) >= 0

        free = Condition("there is a state, and it is not blocked", is_free)
        return Command(f"{'+' if by > 0 else '-'}v{axis}", after, (free,), (axis,))

    def _cost(self, command: Command, _before: State, after: State) -> float:
        return self.weights[command.parameters[0]] + self._entering[after]
