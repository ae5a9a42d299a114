"""Examines a document: its kind of profile, and every finding on the way.

For programs that report on profiles. Programs that use one call `rtkit.profile.read`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.fast_dataclass import dataclass, field
from rtkit.profile.common import Note
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import XML, form_of
from rtkit.profile.positions import Positions
from rtkit.profile.read import STDIN, as_it_stands, outcome

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile.rts_model import RtsProfile


@dataclass(frozen=True, slots=True)
class Examination:
    """What was found in one document.

    Attributes:
        kind: ``rts`` or ``rtc``; empty where the document is neither.
        profile: None where there are errors.
        errors: What no mode forgives.
        repairs: What was put right; errors to who asks for the strict form.
        remarks: What is allowed but worth knowing.
        positions: Where the parts of `profile` stand; None where it is None.
    """

    kind: str
    profile: RtcProfile | RtsProfile | None
    errors: tuple[Note, ...] = ()
    repairs: tuple[Note, ...] = ()
    remarks: tuple[Note, ...] = ()
    positions: Positions | None = field(default=None, compare=False, repr=False)


def examine(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, kind: str | None = None
) -> Examination:
    """Look through a profile of either kind in any form; takes what `read_profile` takes.

    Raises:
        Malformed: There is no such form.
    """
    try:
        seen = outcome(data, source, form, kind)
    except InvalidProfile as error:
        return Examination("", None, error.problems)
    return Examination(
        seen.kind,
        seen.profile,
        _sorted(seen.errors, data, source, form),
        _sorted(seen.repairs, data, source, form),
        _sorted(seen.remarks, data, source, form),
        None if seen.profile is None else Positions(seen.root, seen.spec, seen.found),
    )


def objections(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, kind: str | None = None
) -> tuple[Note, ...]:
    """Return what the schema has against a document as it stands, before any repair; slow.

    Raises:
        Malformed: There is no such form.
    """
    from rtkit.profile.validate import explained_violations

    try:
        root, _, grammar = as_it_stands(data, source, form, kind)
    except InvalidProfile:
        # What cannot be opened has been told of by who examined it.
        return ()
    return _sorted(explained_violations(root, grammar.schema), data, source, form)


def _sorted(
    notes: Sequence[Note], data: bytes | str, source: str, form: str | None
) -> tuple[Note, ...]:
    """Return notes by line; those on XML by the lines at which people look."""
    raw = data.encode("utf-8", "surrogatepass") if isinstance(data, str) else data
    if not notes or (form or form_of(raw, source)) != XML:
        return tuple(sorted(notes))
    from rtkit.profile.source_lines import at_their_lines

    return tuple(sorted(at_their_lines(notes, raw)))
