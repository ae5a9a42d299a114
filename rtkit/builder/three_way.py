"""Merges two changes of one text, line by line, where they do not touch each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

from rtkit.builder.regions import is_placeholder, joined, split, stamp_of
from rtkit.errors import Malformed


def merged_file(base: str, mine: str, new: str, *, has_regions: bool) -> str:
    """Return a file of users with what is new in the generated one; "" where they meet.

    Args:
        base: What was generated when the file was written.
        mine: The file as it is.
        new: What is generated now.
        has_regions: Whether code between marks is that of users, which stays.

    All have their stamps; the result has that of `new`, so that it can be merged again.
    """
    if not stamp_of(mine) or stamp_of(mine) != stamp_of(base):
        return ""
    # The line of the stamp is no change of its own, which might touch another one.
    base, mine = (each.replace(stamp_of(each), stamp_of(new), 1) for each in (base, mine))
    if has_regions:
        try:
            before, own, after = split(base), split(mine), split(new)
        except Malformed:
            return ""
        lost = own.regions.keys() - after.regions.keys()
        if any(not is_placeholder(own.regions[name]) for name in lost):
            return ""
        base, new = joined(before, own.regions), joined(after, own.regions)
    lines = merged_lines(base.split("\n"), mine.split("\n"), new.split("\n"))
    return "" if lines is None else "\n".join(lines)


def merged_lines(base: Sequence[str], one: Sequence[str], other: Sequence[str]) -> list[str] | None:
    """Return `base` with the changes of both; None where both changed the same lines differently.

    >>> merged_lines(["a", "b", "c", "d"], ["A", "b", "c", "d"], ["a", "b", "c", "D"])
    ['A', 'b', 'c', 'D']
    """
    found: list[str] = []
    at = Place(0, 0, 0)
    for common in (*_common(base, one, other), Common(len(base), len(one), len(other), 0)):
        parts = (
            base[at.base : common.base], one[at.one : common.one], other[at.other : common.other],
        )  # fmt: skip
        before, mine, theirs = map(list, parts)
        if before not in (mine, theirs) and mine != theirs:
            return None
        found += theirs if mine == before else mine
        found += base[common.base : common.base + common.size]
        at = Place(*(start + common.size for start in common[:3]))
    return found


class Place(NamedTuple):
    """A line of each of the three texts, from 0."""

    base: int
    one: int
    other: int


class Common(NamedTuple):
    """Lines that stand in all three texts: where they begin in each, and their number."""

    base: int
    one: int
    other: int
    size: int


def _common(base: Sequence[str], one: Sequence[str], other: Sequence[str]) -> Iterator[Common]:
    """Yield the lines that both changes left as they were, in order."""
    ours, theirs = (
        SequenceMatcher(None, base, each, autojunk=False).get_matching_blocks()
        for each in (one, other)
    )
    i = j = 0
    while i < len(ours) and j < len(theirs):
        start = max(ours[i].a, theirs[j].a)
        ends = ours[i].a + ours[i].size, theirs[j].a + theirs[j].size
        if start < min(ends):
            yield Common(
                start,
                ours[i].b + start - ours[i].a,
                theirs[j].b + start - theirs[j].a,
                min(ends) - start,
            )
        if ends[0] <= ends[1]:
            i += 1
        else:
            j += 1
