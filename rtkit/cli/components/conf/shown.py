"""Renders configuration sets and values for ``rtconf``: as lines, or as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from rtkit.cli.components.conf import ConfRequest, Sets
from rtkit.cli.shared import json_records, terminal
from rtkit.errors import NotFound

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts

DESCRIPTION = "description"
"""The parameter of a set that tells what the set is for."""


def show_sets(facts: ComponentFacts, sets: Sets, asked: ConfRequest) -> None:
    """List sets of a component, with their parameters if that was asked for."""
    if asked.is_json:
        terminal.write([json_records.line("configuration", record_of(facts, sets))])
        return
    lines = []
    for name in sorted(sets):
        is_active = name == facts.active_set
        style = terminal.STYLES["active-set" if is_active else "name"]
        line = ("-" if asked.is_long else "+") + terminal.styled(name, style)
        line += "*" if is_active else "" if asked.is_long else " "
        told = sets[name].get(DESCRIPTION, "")
        lines.append(f"{line} ({terminal.printable(told)})" if told else line)
        if asked.is_long:
            lines += terminal.pairs(sorted(sets[name].items()))
    terminal.write(lines)


def no_parameter(name: str, known: Iterable[str]) -> NotFound:
    """Return the error that there is no such parameter, with similar names."""
    from rtkit.rtc.nearest import did_you_mean

    return NotFound(f"No such configuration parameter: {name}{did_you_mean(name, known)}")


def no_set(set_id: str, known: Iterable[str]) -> NotFound:
    """Return the error that there is no such set, with similar names."""
    from rtkit.rtc.nearest import did_you_mean

    return NotFound(f"No such configuration set: {set_id}{did_you_mean(set_id, known)}")


def show_value(name: str, values: Mapping[str, str], asked: ConfRequest) -> None:
    """Print one value.

    Raises:
        NotFound: There is none of that name.
    """
    if name not in values:
        raise no_parameter(name, values)
    if asked.is_json:
        terminal.write([json_records.line("parameter", {"name": name, "value": values[name]})])
        return
    lines = values[name].split("\n")
    terminal.write(map(terminal.printable, lines) if terminal.is_terminal() else lines)


def record_of(facts: ComponentFacts, sets: Sets) -> dict[str, object]:
    """Return sets of a component for JSON, as a file has them too."""
    return {
        "component": facts.instance,
        "type": facts.type.full_id,
        "active": facts.active_set,
        "sets": {name: dict(values) for name, values in sets.items()},
    }
