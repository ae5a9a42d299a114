"""Verdict on a system: all findings, each with its location and its rule."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import TYPE_CHECKING, NamedTuple

from rtkit.deployment.described import type_of
from rtkit.deployment.limits import Capacity
from rtkit.profile.common import Note
from rtkit.profile.examine import Positions, examine
from rtkit.profile.rts_model import RtsProfile
from rtkit.report.finding import ERROR, WARNING, Checked, Finding, counted
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.check import findings
from rtkit.static_check.finding import StaticFinding

if TYPE_CHECKING:
    from rtkit.profile.parameters.reading import SystemReading


class Options(NamedTuple):
    """Options of a check: strictness, ignored rules, capacity of the host.

    Attributes:
        strict: Warnings are errors, and so is what had to be repaired.
        ignored: Ids of rules whose findings are left out.
        capacity: Returns what the host has on which the system is to run.
    """

    strict: bool = False
    ignored: Collection[str] = ()
    capacity: Callable[[], Capacity] = Capacity

    def chosen(self, findings: Iterable[Finding]) -> tuple[Finding, ...]:
        """Return those that are to be shown, by line."""
        shown = (each for each in findings if each.rule not in self.ignored)
        if self.strict:
            shown = (
                each._replace(severity=ERROR) if each.severity == WARNING else each
                for each in shown
            )
        return tuple(sorted(shown, key=lambda finding: finding.line))


USUAL = Options()


class Opened(NamedTuple):
    """A system profile that is to be checked.

    Attributes:
        file: As the user typed it.
        profile: None where the document is no sound system profile.
        errors: Why it is none.
    """

    file: str
    profile: RtsProfile | None
    positions: Positions | SystemReading | None
    errors: tuple[Note, ...] = ()

    @property
    def types(self) -> set[str]:
        """Names of the component types that it speaks of."""
        components = self.profile.components if self.profile is not None else ()
        return {type_of(component.id).type_name for component in components}


def opened(data: bytes, file: str, *, form: str | None = None, strict: bool = False) -> Opened:
    """Look into a system profile, in any form.

    Args:
        data: The document.
        file: Names it.
        form: ``xml``, ``yaml`` or ``json``; None finds out.
        strict: Take every repair for an error.

    Raises:
        Malformed: There is no such form.
    """
    found = examine(data, file, form=form, kind="rts")
    errors = found.errors + (found.repairs if strict else ())
    if errors or not isinstance(found.profile, RtsProfile):
        return Opened(file, None, None, tuple(sorted(errors)))
    return Opened(file, found.profile, found.positions)


def verdict(system: Opened, catalogue: Catalogue, options: Options = USUAL) -> Checked:
    """Return the verdict on a system, as far as the component types in `catalogue` are known."""
    if system.profile is None or system.positions is None:
        errors = (
            Finding(ERROR, n.rule, n.text, system.file, n.line, n.path, n.found, n.allowed)
            for n in system.errors
        )
        return Checked(system.file, "", tuple(errors))
    positions = system.positions
    static_findings = findings(system.profile, catalogue, options.capacity)
    found = (_finding(each, system.file, positions) for each in static_findings)
    return Checked(system.file, _what(system.profile, catalogue), options.chosen(found))


def _finding(each: StaticFinding, file: str, positions: Positions | SystemReading) -> Finding:
    steps, field = each.place
    if isinstance(positions, Positions):
        line, path = positions.position(steps, field)
    else:
        file, line, path = positions.position(steps, field)  # perhaps the file of an include
    return Finding(each.severity, each.rule, each.text, file, line, path, each.found, each.allowed)


def _what(profile: RtsProfile, catalogue: Catalogue) -> str:
    known = sum(
        bool(component.participants) or catalogue.find(component.id) is not None
        for component in profile.components
    )
    of_them = f", {known} of known type" if profile.components else ""
    return f"system of {counted(len(profile.components), 'component')}{of_them}"
