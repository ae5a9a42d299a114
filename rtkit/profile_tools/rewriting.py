"""Rewrites a document as XML, YAML or JSON, and reports the differences from the original."""

from __future__ import annotations

from typing import NamedTuple

from rtkit.profile.common import Note
from rtkit.profile.examine import examine
from rtkit.profile.forms import form_of
from rtkit.profile.read import read_profile
from rtkit.profile.rtc_model import RtcProfile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_profile
from rtkit.profile_tools.uncarried import uncarried
from rtkit.profile_tools.validation import findings_of
from rtkit.report.finding import ERROR, NOTE, WARNING, Finding


class Rewriting(NamedTuple):
    """Result of rewriting one document.

    Attributes:
        data: The document as it is to be written; None where there are errors.
        findings: Each repair and what is lost; or the errors.
    """

    data: bytes | None
    findings: tuple[Finding, ...]


def rewritten(
    data: bytes,
    file: str,
    *,
    form: str | None = None,
    to: str | None = None,
    is_strict: bool = False,
) -> Rewriting:
    """Write a document anew.

    Args:
        data: The document.
        file: Names it.
        form: ``xml``, ``yaml`` or ``json``; None finds out.
        to: The form to write; None keeps the one that it has.
        is_strict: Take for an error what cannot be brought to the strict form: a fragment.
    """
    found = examine(data, file, form=form)
    if found.profile is None:
        return Rewriting(None, tuple(findings_of(ERROR, found.errors, file)))
    form = form or form_of(data, file)
    made = write_profile(found.profile, to or form)
    lost = _lost(found.profile, made, to or form)
    if lost:
        return Rewriting(None, tuple(findings_of(ERROR, lost, file)))
    left = examine(made, file, form=to or form).repairs if is_strict else ()
    if left:
        return Rewriting(None, tuple(findings_of(ERROR, left, file)))
    findings = [
        *findings_of(NOTE, found.repairs, file),
        *findings_of(WARNING, uncarried(data, form), file),
    ]
    findings.sort(key=lambda finding: finding.line)
    return Rewriting(made, tuple(findings))


def _lost(profile: RtcProfile | RtsProfile, made: bytes, form: str) -> list[Note]:
    """Read the written document back and return its differences; there should be none."""
    again = read_profile(made, form=form).profile
    if again == profile:
        return []
    from rtkit.profile_tools.difference import differences

    lost = differences(profile, again, takes_all=True)
    text = f"cannot be carried as {form.upper()}"
    return [Note(1, f"{text}: {each.text}", rule="not-carried") for each in lost]
