"""Regions of user code in generated files: writes them and splits files at them.

A region lies between ``# <user code NAME>`` and ``# </user code NAME>``. A stamp near the top of
the file holds the fingerprint of the generated part, so that changes to that part are noticed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import NamedTuple

from rtkit.errors import Malformed

_MARK = re.compile(r"\s*# <(/?)user code ([^>]*)>\s*")
_STAMP = re.compile(r"(Made by rtbuild\b.*?\[)([0-9a-f]{12})(\])")
_UNSTAMPED = "0" * 12
CODE_STAMP = (
    f'# Made by rtbuild: code between "user code" marks is yours and is kept [{_UNSTAMPED}].'
)
FILE_STAMP = f"# Made by rtbuild; changed by you, the file is yours and is kept [{_UNSTAMPED}]."
XML_STAMP = (
    f"<!-- Made by rtbuild; changed by you, the file is yours and is kept [{_UNSTAMPED}]. -->"
)
MARKDOWN_STAMP = XML_STAMP
_PLACEHOLDERS = (
    "",
    "pass",
    "raise NotImplementedError",
    "return None",
    "return super().on_event(event, value)",
)


class Split(NamedTuple):
    """A file in two parts.

    Attributes:
        generated: Its lines without those of users, marks included.
        regions: The lines of each region.
        numbers: Where each generated line stands in the file, from 1.
    """

    generated: list[str]
    regions: Mapping[str, list[str]]
    numbers: list[int]


def region(name: str, indent: str, content: Sequence[str] = ()) -> list[str]:
    """Return the lines of a region with its initial content."""
    return [f"{indent}# <user code {name}>", *content, f"{indent}# </user code {name}>"]


def split(text: str) -> Split:
    """Split a file into generated lines and those of users.

    Raises:
        Malformed: A mark is missing, or is there twice; names the line.
    """
    generated: list[str] = []
    numbers: list[int] = []
    regions: dict[str, list[str]] = {}
    open_region = ""
    for number, line in enumerate(text.split("\n"), 1):
        mark = _MARK.fullmatch(line)
        if mark is None and open_region:
            regions[open_region].append(line)
            continue
        if mark is not None:
            _check(mark, open_region, regions, number)
            if not mark[1]:
                regions[mark[2]] = []
            open_region = "" if mark[1] else mark[2]
        generated.append(line)
        numbers.append(number)
    if open_region:
        raise Malformed(f"{number}: the mark </user code {open_region}> is missing")
    return Split(generated, regions, numbers)


def _check(
    mark: re.Match[str], open_region: str, regions: Mapping[str, list[str]], number: int
) -> None:
    name = mark[2]
    if mark[1] and name != open_region:
        raise Malformed(f"{number}: the mark <user code {name}> is missing before this line")
    if not mark[1] and open_region:
        raise Malformed(f"{number}: the mark </user code {open_region}> is missing before it")
    if not mark[1] and name in regions:
        raise Malformed(f"{number}: the mark <user code {name}> is there twice")


def joined(parts: Split, regions: Mapping[str, list[str]]) -> str:
    """Return the generated lines with these regions in place of their own."""
    lines: list[str] = []
    for line in parts.generated:
        lines.append(line)
        mark = _MARK.fullmatch(line)
        if mark is not None and not mark[1]:
            lines += regions.get(mark[2], parts.regions[mark[2]])
    return "\n".join(lines)


def is_placeholder(lines: Sequence[str]) -> bool:
    """Return whether a region holds nothing that a user wrote."""
    return all(line.strip() in _PLACEHOLDERS for line in lines)


def stamped(text: str, *, has_regions: bool) -> str:
    """Return the text with its stamp filled in.

    Raises:
        Malformed: Its marks do not fit.
    """
    stamp = fingerprint(text, has_regions=has_regions)
    return _STAMP.sub(lambda found: f"{found[1]}{stamp}{found[3]}", text, count=1)


def stamp_of(text: str) -> str:
    """Return the stamp of a file; empty when it has none."""
    found = _STAMP.search(text)
    return found[2] if found else ""


def fingerprint(text: str, *, has_regions: bool) -> str:
    """Return the stamp of an unchanged file.

    Raises:
        Malformed: Its marks do not fit.
    """
    plain = _STAMP.sub(lambda found: f"{found[1]}{_UNSTAMPED}{found[3]}", text, count=1)
    if has_regions:
        plain = "\n".join(split(plain).generated)
    return sha256(plain.encode()).hexdigest()[:12]
