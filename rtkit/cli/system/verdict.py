"""Reports the deviations of a live system in forms for people and for build servers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared import json_records
from rtkit.report.finding import ERROR, WARNING, Checked, Finding
from rtkit.report.forms import JSON, report_lines

if TYPE_CHECKING:
    from rtkit.deployment.deviations import Deviation
    from rtkit.deployment.system import WantedSystem

TOOL = "rtcheck"
RULES = {
    "live-component": "A component of the profile is missing, another one, or does not answer",
    "live-connection": "A connection of the profile is missing",
    "live-property": "A connection has another property than the profile says",
    "live-active-set": "Another configuration set is active than the profile says",
    "live-code": "The file of a component's module has changed since it was loaded",
    "live-constraint": "A parameter has another constraint than the profile says",
    "live-create": "A component was made otherwise than the profile says",
    "live-place": "A component is where its requirements are not met",
    "live-policy": "Restarts or rules of health are others than the profile says",
    "live-port": "A component lacks a port that the profile lists",
    "live-rate": "An execution context has another rate than the profile says",
    "live-parameter": "A parameter has another value than the profile says",
    "live-type": "A port has another data type than the profile says",
    "live-state": "A component is in another state than was asked for",
}
_TWO_SIDED = (
    "property", "active-set", "parameter", "constraint", "rate", "policy", "create", "type",
    "state",
)  # fmt: skip
"""Kinds of which both what is wanted and what is found is a text of its own."""


def text_of(each: Deviation) -> str:
    """Return the line about a deviation, with what was wanted beside what was found."""
    if each.kind not in _TWO_SIDED or not each.wanted:
        return each.text
    return f"{each.text.removesuffix('.')}; wanted: {each.wanted}"


def verdict_lines(
    form: str, source: str, system: WantedSystem, found: Sequence[Deviation]
) -> Iterator[str]:
    """Yield the lines of a report on a live system in one of the forms of reports.

    In JSON they are records of deviations; in the others a thing checked is a component, or a
    connection, of the profile in the file `source`.
    """
    if form == JSON:
        yield from json_records.lines("deviation", map(_record, found))
        return
    yield from report_lines(form, _checked(source, system, found), RULES, TOOL)


def _record(each: Deviation) -> dict[str, object]:
    return json_records.picked(each, "kind path text required=is_required item wanted found")


def _checked(source: str, system: WantedSystem, found: Sequence[Deviation]) -> Iterator[Checked]:
    from rtkit.deployment.system import address

    things = {component.path: "component" for component in system.components}
    for connector in system.connectors:
        ends = (address(system, end) for end in connector.profile.ports)
        things[" ".join(ends)] = "connection"
    for name, what in things.items():
        own = (each for each in found if each.path == name)
        yield Checked(name, what, tuple(_finding(each, source) for each in own))


def _finding(each: Deviation, source: str) -> Finding:
    severity = ERROR if each.is_required else WARNING
    return Finding(
        severity,
        f"live-{each.kind}",
        text_of(each),
        source,
        found=each.found or None,
        allowed=each.wanted,
    )
