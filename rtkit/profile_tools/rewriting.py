"""A document written anew, as XML, YAML or JSON, and what is other than it was."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from rtkit.profile.common import Note
from rtkit.profile.examine import examine
from rtkit.profile.forms import form_of
from rtkit.profile.read import read_profile
from rtkit.profile.rtc_model import RTC_VERSION, RtcProfile
from rtkit.profile.rts_model import RTS_VERSION, RtsProfile
from rtkit.profile.write import write_profile
from rtkit.profile_tools.uncarried import uncarried
from rtkit.profile_tools.validation import findings_of
from rtkit.report.finding import ERROR, NOTE, WARNING, Finding

_OLD_VERSIONS = ("0.1", "1.0", "")


class Rewriting(NamedTuple):
    """What came of one document.

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
    brings_up: bool = False,
) -> Rewriting:
    """Write a document anew.

    Args:
        data: The document.
        file: Names it.
        form: ``xml``, ``yaml`` or ``json``; None finds out.
        to: The form to write; None keeps the one that it has.
        brings_up: Give a version whose spelling is gone the number of the present one.
    """
    found = examine(data, file, form=form)
    if found.profile is None:
        return Rewriting(None, tuple(findings_of(ERROR, found.errors, file)))
    form = form or form_of(data, file)
    profile, notes = _brought_up(found.profile) if brings_up else (found.profile, [])
    made = write_profile(profile, to or form)
    lost = _lost(profile, made, to or form)
    if lost:
        return Rewriting(None, tuple(findings_of(ERROR, lost, file)))
    findings = [
        *findings_of(NOTE, (*notes, *found.repairs), file),
        *findings_of(WARNING, uncarried(data, form), file),
    ]
    findings.sort(key=lambda finding: finding.line)
    return Rewriting(made, tuple(findings))


def _brought_up(
    profile: RtcProfile | RtsProfile,
) -> tuple[RtcProfile | RtsProfile, list[Note]]:
    if profile.version not in _OLD_VERSIONS:
        return profile, []
    version = RTS_VERSION if isinstance(profile, RtsProfile) else RTC_VERSION
    text = f"version {profile.version!r} taken as {version!r}: the spelling is now that one's"
    note = Note(1, text, rule="old-version", found=profile.version, allowed=version)
    if isinstance(profile, RtsProfile):
        return replace(profile, version=version), [note]
    return replace(profile, version=version), [note]


def _lost(profile: RtcProfile | RtsProfile, made: bytes, form: str) -> list[Note]:
    """Read what was written and tell what is other than it was; nothing ever should be."""
    again = read_profile(made, form=form).profile
    if again == profile:
        return []
    from rtkit.profile_tools.difference import differences

    told = differences(profile, again, takes_all=True)
    text = f"cannot be carried as {form.upper()}"
    return [Note(1, f"{text}: {each.text}", rule="not-carried") for each in told]
