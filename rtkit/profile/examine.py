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
    """Findings on one document.

    Attributes:
        kind: ``rts`` or ``rtc``; empty where the document is neither.
        profile: None where there are errors.
        errors: Faults that no mode forgives.
        repairs: Repaired deviations; errors where the strict form is asked for.
        remarks: Allowed content that is worth knowing of.
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
    """Examine a profile of either kind in any form; takes the arguments of `read_profile`.

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
    """Return the schema's violations of a document as it stands, before any repair; slow.

    Raises:
        Malformed: There is no such form.
    """
    from rtkit.profile.validate import explained_violations

    try:
        root, _, grammar = as_it_stands(data, source, form, kind)
    except InvalidProfile:
        # `examine` has reported a document that cannot be opened.
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
