"""Tasks that were given and questions that are open, as plain data."""

from __future__ import annotations

from dataclasses import dataclass, field

from manipulation.language import PickUp
from manipulation.ways import Goal


@dataclass
class Asked:
    """A question to the operator.

    Attributes:
        kind: ``choice`` of an alternative, ``clear`` (into which region), ``name`` of a thing, or
            ``lost`` (a thing was not found).
        choices: The only answers; any name where there are none.
        about: The number of the task, or the thing.
        details: What the choices mean, a line each.
    """

    id: str
    kind: str
    text: str
    choices: tuple[str, ...]
    about: int | str
    details: tuple[str, ...] = ()


@dataclass
class Job:
    """A task that was given.

    Attributes:
        goals: What it comes to; targets may be fuzzy.
        chosen: Concrete goals, with the number of the goal that each serves.
        done: How many of `chosen` are done.
        is_ready: A way is chosen.
        waits_for: A thing that stopped it and has no name yet.
        spent: What it has cost up to now.
        evaluations: Evaluations that it took.
    """

    number: int
    text: str
    goals: list[Goal]
    chosen: list[tuple[Goal, int]] = field(default_factory=list)
    done: int = 0
    is_ready: bool = False
    waits_for: str = ""
    spent: float = 0.0
    evaluations: int = 0

    @property
    def names(self) -> set[str]:
        """Return the names in what is to be done."""
        goals = [*self.goals, *(goal for goal, _ in self.chosen)]
        own = {getattr(goal, key, "") for goal in goals for key in ("name", "into")}
        return own | {goal.target.name for goal in goals if not isinstance(goal, PickUp)}

    @property
    def left(self) -> list[Goal]:
        """Return the goals that are not done yet."""
        return self.goals[self.chosen[self.done][1] if self.done < len(self.chosen) else 0 :]
