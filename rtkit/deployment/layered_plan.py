"""A layered plan: checks and actions, layer by layer, as data to be shown or carried out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rtkit.deployment.actions import Action, Create, SetParameters
from rtkit.fast_dataclass import dataclass, replace
from rtkit.rtc.create import parse_create


@dataclass(frozen=True, slots=True)
class Check:
    """A fact that must hold before anything is changed.

    Attributes:
        text: Text of the check, for a dry run.
        failure: Why it does not hold; empty when it does.
    """

    text: str
    failure: str = ""
    is_required: bool = True


@dataclass(frozen=True, slots=True)
class PlannedAction:
    """One action of a plan, with its words.

    Attributes:
        text: Text of the step, for a dry run; empty for steps that are not worth a line.
        action: None when it cannot be done (see `blocked`), or need not be (see `holds`).
        blocked: Why it cannot be done, known beforehand.
        holds: The goal of the step is reached already.
        where: Path of the component, or paths of the ports, for messages.
    """

    text: str
    action: Action | None
    is_required: bool = False
    blocked: str = ""
    holds: bool = False
    where: str = ""

    def failure_text(self, why: str) -> str:
        """Return why it failed, with where it was unless that is stated already."""
        return why if not self.where or self.where in why else f"{self.where}: {why}"

    @property
    def line(self) -> str:
        """The step as a line of a dry run."""
        return self.text + (" (Required)" if self.is_required else "")


@dataclass(frozen=True, slots=True)
class Layer:
    """Steps that need nothing of each other.

    Attributes:
        name: Work of the layer, for progress.
        is_ordered: They are carried out one after the other all the same.
    """

    name: str
    steps: tuple[PlannedAction, ...]
    is_ordered: bool = False


@dataclass(frozen=True, slots=True)
class LayeredPlan:
    """Checks, then layers, each of which is begun when the one before is done."""

    checks: tuple[Check, ...] = ()
    layers: tuple[Layer, ...] = ()

    @property
    def steps(self) -> tuple[PlannedAction, ...]:
        """Every step, in order."""
        return tuple(step for layer in self.layers for step in layer.steps)

    @property
    def is_done(self) -> bool:
        """Return whether nothing is left to be done."""
        return all(step.action is None for step in self.steps)

    @property
    def made(self) -> frozenset[str]:
        """Instance names of the components that the plan creates."""
        creates = (step.action for step in self.steps if isinstance(step.action, Create))
        return frozenset(parse_create(action.create).instance_name for action in creates)

    def lines(self) -> Iterator[str]:
        """Yield the plan as a dry run shows it."""
        for check in self.checks:
            yield check.text + (" (Required)" if check.is_required else "")
        for step in self.steps:
            if step.text:
                yield step.line


def layer(name: str, steps: Iterable[PlannedAction], **how: bool) -> tuple[Layer, ...]:
    """Return one layer of these steps, or none when there are none."""
    made = tuple(steps)
    return (Layer(name, made, **how),) if made else ()


def merged(steps: Iterable[PlannedAction]) -> list[tuple[Action, list[PlannedAction]]]:
    """Return the actions to be sent, each with the steps that it carries out.

    Parameters of one configuration set are written at once.
    """
    found: list[tuple[Action, list[PlannedAction]]] = []
    places: dict[tuple[str, str], int] = {}
    for step in steps:
        action = step.action
        if isinstance(action, SetParameters):
            key = (action.instance, action.set_id)
            if key in places:
                known, together = found[places[key]]
                assert isinstance(known, SetParameters)
                values = {**known.values, **action.values}
                found[places[key]] = (replace(known, values=values), [*together, step])
                continue
            places[key] = len(found)
        if action is not None:
            found.append((action, [step]))
    return found
