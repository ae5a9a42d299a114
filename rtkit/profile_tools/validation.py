"""Validates a document: the verdict, with every finding."""

from __future__ import annotations

from collections.abc import Container, Iterable

from rtkit.profile.common import Note
from rtkit.profile.examine import examine, objections
from rtkit.report.finding import ERROR, NOTE, Checked, Finding

RULES: dict[str, str] = {
    "comment-dropped": "A comment or processing instruction is no part of a profile",
    "not-carried": "A form cannot hold what the document says",
    "unreadable": "A file or folder cannot be read",
}
"""Description of each rule beside those of `rtkit.profile.rules`, by its id."""


_NAMES = {"rts": "RTS profile", "rtc": "RTC profile", "": ""}
_MARKS = (b"openrtp.org/namespaces/rt", b"rtsProfile", b"rtcProfile")


def validated(
    data: bytes,
    file: str,
    *,
    form: str | None = None,
    strict: bool = False,
    ignored: Container[str] = (),
    is_explaining: bool = False,
) -> Checked:
    """Return the verdict on a profile of either kind; `file` names it.

    Args:
        data: The document.
        file: As the user typed it.
        form: ``xml``, ``yaml`` or ``json``; None finds out.
        strict: Take every repair for an error.
        ignored: Rules of which only is told what nothing forgives.
        is_explaining: Have the schema tell what it has against the document as it stands; slow.
    """
    found = examine(data, file, form=form)
    of_schema = objections(data, file, form=form) if is_explaining else ()
    repairs = [note for note in found.repairs if note.rule not in ignored]
    notes = [note for note in (*found.remarks, *of_schema) if note.rule not in ignored]
    findings = [
        *findings_of(ERROR, found.errors, file),
        *findings_of(ERROR if strict else NOTE, repairs, file),
        *findings_of(NOTE, notes, file),
    ]
    findings.sort(key=lambda finding: finding.line)
    return Checked(file, _NAMES[found.kind], tuple(findings))


def unreadable(file: str, why: str) -> Checked:
    """Return the verdict on a document that cannot be read."""
    finding = Finding(ERROR, "unreadable", f"cannot be read: {why}", file)
    return Checked(file, "", (finding,), is_read=False)


def may_be_profile(data: bytes) -> bool:
    """Return whether a document may be a profile; for folders that hold other files too."""
    bare = data.replace(b"\0", b"")
    return any(mark in bare for mark in _MARKS)


def findings_of(severity: str, notes: Iterable[Note], file: str) -> list[Finding]:
    """Return notes of a profile as findings of one severity."""
    return [
        Finding(
            severity, note.rule, note.text, file, note.line, note.path, note.found, note.allowed
        )
        for note in notes
    ]
