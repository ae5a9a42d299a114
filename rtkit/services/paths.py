"""Path rules of stored files: names of properties as parts of a path, and back; touches no file.

Dots of a file's name part segments: the file ``image.jpg`` of the directory ``my pictures`` is the
property ``my%20pictures.image.jpg``. Where that is another file's name already, or no name at all
(``a..b``, ``notes.meta``), its dots are escaped: ``notes%2Emeta``; those of directories always are.

Source: `property-service` reference, section 11.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Container
from functools import lru_cache
from urllib.parse import quote, unquote

from rtkit import PropertyError

Path = tuple[str, ...]
"""Directories below the root, and the name in the last one; none is followed upwards."""

LONGEST = 255
DEEPEST = 32
TEMPORARY = ".rtkit-upload-"
"""Beginning of the names of files that are not whole yet."""

RESERVED = frozenset({"properties", "parameters", "gui", "listen", "meta", "history"})
"""Parts of names behind which there is no further one, but what is told of a property."""
_DRIVE = re.compile(r"[A-Za-z]:")


def is_allowed(part: str, *, hidden: bool = False) -> bool:
    """Return whether a directory or file may have a name.

    Args:
        part: The name, without escapes.
        hidden: Names that begin with a dot may be seen.
    """
    if part in ("", ".", "..") or part.startswith(TEMPORARY) or _DRIVE.match(part):
        return False
    if part.isascii() and part.isprintable():
        is_text = "/" not in part and "\\" not in part
    else:
        is_text = not any(c in "/\\" or unicodedata.category(c) in ("Cc", "Cs") for c in part)
    if not is_text or len(part.encode()) > LONGEST:
        return False
    return hidden or not part.startswith(".")


def path_of(name: str, directories: Container[Path], *, hidden: bool = False) -> Path:
    """Return where a file is stored whose name is not there yet: in the deepest of its directories.

    Args:
        name: Of a property.
        directories: Those that there are.
        hidden: See `is_allowed`.

    Raises:
        PropertyError: ``denied``: no file may be called that.
    """
    segments = [unquote(each, errors="strict") for each in name.split(".")]
    parents: Path = ()
    while len(segments) > 1 and (*parents, segments[0]) in directories:
        parents = (*parents, segments.pop(0))
    # Each by itself, too: what is joined of parts that are none would be one.
    if not all(each and is_allowed(f"_{each}") for each in segments):
        raise PropertyError("denied", f"no file may be called {name[:80]}")
    path = (*parents, ".".join(segments))
    if not all(is_allowed(each, hidden=hidden) for each in path):
        raise PropertyError("denied", f"no file may be called {name[:80]}")
    return path


@lru_cache(1 << 16)
def names_of(path: Path) -> tuple[str, ...]:
    """Return the names that a file or directory may have as a property, the usual one first."""
    last = path[-1]
    above = "".join(f"{_escaped(each)}." for each in path[:-1])
    return tuple(
        name
        for name in (above + quote(last, safe="+"), above + _escaped(last))
        if len(name) <= LONGEST and _is_name(name.split("."))
    )


def _is_name(segments: list[str]) -> bool:
    is_known = "" not in segments and len(segments) <= DEEPEST
    return is_known and RESERVED.isdisjoint(segments)


def _escaped(text: str) -> str:
    return quote(text, safe="+").replace(".", "%2E")
