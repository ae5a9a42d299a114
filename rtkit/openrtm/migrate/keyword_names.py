"""Names that are keywords since Python 3.7: ``async`` and ``await`` get others."""

from __future__ import annotations

import re
from typing import NamedTuple

from rtkit.openrtm.migrate.python2 import KEYWORD_AS_NAME, TOKEN
from rtkit.openrtm.migrate.source_edits import Remark

_PART = re.compile(
    f"(?P<token>{TOKEN.pattern})|(?P<name>{KEYWORD_AS_NAME})", re.DOTALL | re.MULTILINE
)
_OF_OTHERS = re.compile(r"(?<!self)\.[ \t]*$")
_ARGUMENT = re.compile(r"[(,]\s*$")
_IS_NAMED = re.compile(r"[ \t]*=(?!=)")


class FreedNames(NamedTuple):
    """A source in which names that are keywords have others.

    Attributes:
        lines: Where they are.
        remarks: Those that other files may know, too.
    """

    text: str
    lines: tuple[int, ...] = ()
    remarks: tuple[Remark, ...] = ()


def with_free_names(text: str) -> FreedNames:
    """Return a source that has ``async_`` for ``async``."""
    lines, remarks = [], []

    def freed(match: re.Match[str]) -> str:
        if match["token"] is not None:
            return match[0]
        name, before = match[0], text[: match.start()]
        lines.append(before.count("\n") + 1)
        is_argument = _ARGUMENT.search(before) and _IS_NAMED.match(text, match.end())
        if is_argument or _OF_OTHERS.search(before):
            why = f"{name} has become {name}_, in other files, too?"
            remarks.append(Remark(lines[-1], why))
        return f"{name}_"

    made = _PART.sub(freed, text)
    return FreedNames(made, tuple(lines), tuple(remarks))
