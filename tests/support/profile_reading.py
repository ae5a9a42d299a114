"""What tests ask of documents beside their profiles: kind, and all that a schema objects to."""

from __future__ import annotations

from rtkit.profile.common import Note
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.normalise import normalise
from rtkit.profile.read import STDIN, as_it_stands
from rtkit.profile.validate import explained_violations


def profile_kind(data: bytes | str, source: str = STDIN, *, form: str | None = None) -> str:
    """Tell whether a document is an ``rts`` or an ``rtc`` profile, by its root."""
    return as_it_stands(data, source, form, None)[2].kind


def explain(
    data: bytes | str, source: str = STDIN, *, form: str | None = None, kind: str | None = None
) -> tuple[Note, ...]:
    """Tell what is wrong with a profile once it is repaired, with element paths and reasons."""
    try:
        root, found, grammar = as_it_stands(data, source, form, kind)
        normalise(root, grammar.spec, found)
        grammar.check(root, found)
    except InvalidProfile as error:
        return error.problems
    return tuple(sorted(found.errors + explained_violations(root, grammar.schema)))
