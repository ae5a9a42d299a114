"""Merges newly generated files with existing ones, so that code of users stays."""

from __future__ import annotations

from enum import Enum
from typing import NamedTuple

from rtkit.builder.regions import fingerprint, is_placeholder, joined, split, stamp_of, stamped
from rtkit.errors import Malformed

_EVENT, _FORMER, _STATES = "on_event", ["return None"], "(rt.State):"
"""A region, its first content before states had classes, and the pattern that tells them."""


class MergeOutcome(Enum):
    """Action that a merge decides on for one file."""

    WRITE = "written"
    SAME = "unchanged"
    KEEP = "kept"
    CONFLICT = "conflict"


class Merged(NamedTuple):
    """The result of merging one file.

    Attributes:
        text: Its new content; of a file that is kept, the content it would get.
        why: For a conflict, and for one that is kept: why.
        line: Of the file as it is, where that has one; from 1.

    A conflict has the text that can be written all the same, if what was there is kept aside.
    """

    assignment: MergeOutcome
    text: str
    why: str = ""
    line: int = 0


def merge(old: str | None, new: str, *, has_regions: bool) -> Merged:
    """Return the merged file of the existing text and the generated one.

    Code of users stays. A file with regions whose generated part was changed is a conflict;
    one without regions that was changed is the user's and is kept.
    """
    text = stamped(new, has_regions=has_regions)
    if old is None:
        return Merged(MergeOutcome.WRITE, text)
    if old == text:
        return Merged(MergeOutcome.SAME, text)
    try:
        return _with_regions(old, text) if has_regions else _whole(old, text)
    except Malformed as error:
        number, _, why = str(error).partition(": ")
        return Merged(MergeOutcome.CONFLICT, text, why, int(number))


def _whole(old: str, text: str) -> Merged:
    stamp = stamp_of(old)
    if stamp and stamp == fingerprint(old, has_regions=False):
        return Merged(MergeOutcome.WRITE, text)
    return Merged(
        MergeOutcome.KEEP, text, "it was changed" if stamp else "it was not made by rtbuild"
    )


def _with_regions(old: str, text: str) -> Merged:
    before, after = split(old), split(text)
    stamp = stamp_of(old)
    if not stamp:
        return Merged(MergeOutcome.CONFLICT, text, "it was not made by rtbuild", 1)
    if stamp != fingerprint(old, has_regions=True):
        line = _first_difference(before.generated, after.generated)
        where = before.numbers[min(line, len(before.numbers) - 1)]
        why = "the generated part was changed"
        return Merged(MergeOutcome.CONFLICT, joined(after, before.regions), why, where)
    for name, lines in before.regions.items():
        if name not in after.regions and not is_placeholder(lines):
            why = f"there is no place any more for your code {name}"
            return Merged(
                MergeOutcome.CONFLICT, joined(after, before.regions), why, _place(old, name)
            )
    regions = dict(before.regions)
    if _STATES not in old and [line.strip() for line in regions.get(_EVENT, ())] == _FORMER:
        del regions[_EVENT]  # else classes of states would never be asked
    merged = joined(after, regions)
    return Merged(MergeOutcome.SAME if merged == old else MergeOutcome.WRITE, merged)


def _first_difference(old: list[str], new: list[str]) -> int:
    for index, (one, other) in enumerate(zip(old, new, strict=False)):
        if one != other and not stamp_of(one):
            return index
    return min(len(old), len(new))


def _place(text: str, name: str) -> int:
    marked = (n for n, line in enumerate(text.split("\n"), 1) if f"<user code {name}>" in line)
    return next(marked, 1)
