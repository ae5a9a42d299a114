"""Serializes the states of a system as text for its manager, which reads no profiles."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rtkit.errors import Malformed
from rtkit.rtc.serde import decode, encode

if TYPE_CHECKING:
    from rtkit.deployment.states.states import States


def spec_to_text(states: States, about: Sequence[str], *, rolls_back: bool = False) -> str:
    """Return all that is needed to follow a system, as text: facts, and no profile.

    Args:
        states: Of the system.
        about: The file of the profile, and what distinguishes its content from any other.
        rolls_back: When a step fails, go back to what was before.
    """
    base, machine = states.base, states.machine
    return json.dumps(
        {
            "system": states.name,
            "about": list(about),
            "rolls_back": rolls_back,
            "wanted": encode(base.system),
            "ranks": dict(base.ranks),
            "costs": [dict(base.costs.values), dict(base.costs.origins)],
            "replaces": base.replaces,
            "is_strict": base.is_strict,
            "table": {name: dict(leading) for name, leading in machine.table.items()},
            "wishes": {name: list(map(list, each)) for name, each in machine.wishes.items()},
            "conditions": {
                event: [each.component, each.name, each.compare, each.value]
                for event, each in machine.conditions.items()
            },
        },
        separators=(",", ":"),
    )


def spec_from_text(text: str) -> tuple[States, bool]:
    """Rebuild the states of a system, and whether what fails goes back.

    Raises:
        Malformed: It is no such text.
    """
    try:
        return _spec(json.loads(text))
    except (ValueError, TypeError, LookupError, AttributeError, RecursionError) as error:
        raise Malformed(f"not what a system is followed by: {error}") from error


def _spec(record: dict[str, Any]) -> tuple[States, bool]:
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.planning.step_costs import Costs
    from rtkit.deployment.states.events import EventCondition
    from rtkit.deployment.states.machine import SystemStates
    from rtkit.deployment.states.states import States
    from rtkit.deployment.states.variants import StateDifference
    from rtkit.deployment.system import WantedSystem

    table: dict[str, dict[str, str]] = record["table"]
    if not table:
        raise Malformed("it has no state")
    for leading in table.values():
        for target in leading.values():
            table[target]  # every event leads to a state
    machine = SystemStates(
        table,
        {
            name: tuple(StateDifference(*map(str, each)) for each in record["wishes"][name])
            for name in table
        },
        {event: EventCondition(*map(str, each)) for event, each in record["conditions"].items()},
    )
    system = decode(WantedSystem, record["wanted"])
    values, origins = record["costs"]
    goal = DeploymentGoal(
        system,
        ranks={str(name): int(rank) for name, rank in record["ranks"].items()},
        costs=Costs({str(k): float(v) for k, v in values.items()}, dict(origins)),
        replaces=bool(record["replaces"]),
        is_strict=bool(record["is_strict"]),
    )
    return States(str(record["system"]), machine, goal), bool(record["rolls_back"])
