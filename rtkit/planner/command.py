"""Commands: conditions on states and functions from a state to the next."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from rtkit.fast_dataclass import dataclass

State = tuple[Any, ...]
"""One value for each variable, in the order of the problem's variables; each can be hashed."""


class Condition(NamedTuple):
    """Condition on a state, with its name for messages."""

    name: str
    holds: Callable[[State], bool]


@dataclass(frozen=True, slots=True)
class Command:
    """An action that is possible in some states.

    Attributes:
        name: States what is done; costs and messages refer to it.
        effect: From a state in which all conditions hold to the state after.
        parameters: Arguments of the command, shown behind the name.
    """

    name: str
    effect: Callable[[State], State]
    conditions: tuple[Condition, ...] = ()
    parameters: tuple[Any, ...] = ()

    def __str__(self) -> str:
        return " ".join(map(str, (self.name, *self.parameters)))

    @property
    def identity(self) -> tuple[Any, ...]:
        """Return the name and the parameters, which identify the command."""
        return (self.name, *self.parameters)
