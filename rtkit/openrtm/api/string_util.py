"""Functions on texts that components call by name; ``OpenRTM_aist.StringUtil``."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, MutableSequence, Sequence
from functools import wraps
from typing import Any

Convert = Callable[[Any, str], tuple[bool, Any]]
"""Takes a former value and a text; returns whether it could be converted, and the new value."""
_ESCAPES = {"\t": "\\t", "\n": "\\n", "\f": "\\f", "\r": "\\r", "\\": "\\\\"}
_ESCAPED = {"t": "\t", "n": "\n", "f": "\f", "r": "\r"}


def escape(text: str) -> str:
    r"""Return a text with ``\t`` and the like for characters that lines cannot have."""
    return "".join(_ESCAPES.get(each, each) for each in text)


def unescape(text: str) -> str:
    """Return the text that was escaped."""
    return re.sub(r"\\(.)", lambda found: _ESCAPED.get(found[1], found[1]), text)


def isEscaped(text: str, pos: int) -> bool:
    """Return whether an odd number of backslashes stands before a position."""
    before = text[:pos]
    return (len(before) - len(before.rstrip("\\"))) % 2 == 1


def _also_in_place(change: Callable[..., str]) -> Callable[..., str]:
    """Have a function take a list, too, whose first text it changes: so those of 1.x do."""

    @wraps(change)
    def changed(text: Any, *arguments: Any) -> str:
        if not isinstance(text, MutableSequence):
            return change(text, *arguments)
        text[:1] = [change(each, *arguments) for each in text[:1]]
        return text[0] if text else ""

    return changed


@_also_in_place
def eraseBlank(text: str) -> str:
    """Return a text without blanks and tabs."""
    return text.replace(" ", "").replace("\t", "")


@_also_in_place
def eraseHeadBlank(text: str) -> str:
    """Return a text without blanks and tabs before it."""
    return text.lstrip("\t ")


@_also_in_place
def eraseTailBlank(text: str) -> str:
    """Return a text without blanks and tabs behind it."""
    return text.rstrip("\t ")


@_also_in_place
def eraseBothEndsBlank(text: str) -> str:
    """Return a text without blanks and tabs around it."""
    return text.strip("\t ")


@_also_in_place
def normalize(text: str) -> str:
    """Return a text in small letters, without space around it."""
    return text.strip().lower()


@_also_in_place
def replaceString(text: str, old: str, new: str) -> str:
    """Return a text with one part replaced by another."""
    return text.replace(old, new)


def split(text: str, delimiter: str) -> list[str]:
    """Return the parts of a text that are not blank."""
    return [each.strip("\t ") for each in text.split(delimiter) if each not in ("", " ")]


def toBool(text: str, yes: str, no: str, default_value: bool | None = None) -> bool:
    """Return whether a text contains the word for yes, else that for no, else the default."""
    if yes.upper() in text.upper():
        return True
    if no.upper() in text.upper():
        return False
    return True if default_value is None else default_value


def includes(items: Any, value: str, ignore_case: bool = True) -> bool:
    """Return whether a list, or a text of words behind commas, has a word."""
    words = items.split(",") if isinstance(items, str) else items
    if not isinstance(words, list):
        return False
    if ignore_case:
        return value.lower() in [each.lower() for each in words]
    return value in words


def isAbsolutePath(path: str) -> bool:
    """Return whether a path begins at the root."""
    return os.path.isabs(path) or re.match(r"[A-Za-z]:[/\\]|\\\\", path) is not None


def isURL(text: str) -> bool:
    """Return whether a text begins with a scheme."""
    return re.match(r"[^:]+://", text) is not None


def otos(value: Any) -> str:
    """Return a number as text."""
    return str(value)


def stringTo(former: Any, text: str) -> tuple[bool, Any]:
    """Return whether a text is one of the kind of a value, and what it stands for.

    A list changes in place, to the length of the text; new items are of the kind of its first one.
    """
    if not text:
        return False, former
    try:
        if isinstance(former, list):
            return _into_list(former, split(text, ","))
        if isinstance(former, int):
            return True, int(text)
        if isinstance(former, float):
            return True, float(text)
    except (ValueError, IndexError):
        return False, former
    return (True, str(text)) if isinstance(former, str) else (False, former)


def _into_list(items: MutableSequence[Any], texts: Sequence[str]) -> tuple[bool, Any]:
    kinds = [type(each) for each in items]
    kinds += [kinds[0]] * (len(texts) - len(kinds))
    items[:] = [kind(text) for kind, text in zip(kinds, texts, strict=False)]
    return True, items


def stringToStrVec(former: Any, text: str) -> tuple[bool, Any]:
    """Return the words of a text, which stand behind commas, in a list."""
    return True, [each.strip() for each in text.split(",")] if text else []


def unique_sv(texts: Sequence[str]) -> list[str]:
    """Return each text once."""
    return list(dict.fromkeys(texts))


def flatten(texts: Sequence[str], delimiter: str = ", ") -> str:
    """Return texts as one."""
    return delimiter.join(texts)


def toArgv(arguments: Any) -> Any:
    """Return arguments as they are."""
    return arguments


def urlparam2map(text: str) -> dict[str, str]:
    """Return the parameters of a URL by name."""
    pairs = (
        each.partition("=") for each in text.partition("?")[2 if "?" in text else 0].split("&")
    )
    return {name.strip(): value for name, _, value in pairs if name.strip()}


def replaceEnv(text: str) -> str:
    """Return a text with each ``${NAME}`` replaced by that variable of the environment."""
    return re.sub(r"\$\{([^}]*)\}", lambda found: os.environ.get(found[1], ""), text)


def parseArgs(text: str) -> list[str]:
    """Return the arguments of a line of a shell."""
    import shlex

    return shlex.split(text)
