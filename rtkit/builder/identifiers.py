"""Makes Python identifiers of any names: keywords, blanks, other scripts, empty texts."""

from __future__ import annotations

import builtins
import keyword
import re
import sys
import unicodedata
from collections.abc import Iterable

from rtkit.builder.source_text import width

_HUMP = re.compile(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z0-9])(?=[A-Z][a-z])")
_WIDEST = 40
_NEARLY = _WIDEST - 4
_FUNCTIONS = frozenset(name for name in dir(builtins) if name.islower())
_RESERVED = "/:?&=,@%"
_ANNOTATIONS = ("bool", "bytes", "float", "int", "list", "object", "str", "tuple", "type")
_OURS = ("pytest", "rtkit")


def identifier(text: str, fallback: str) -> str:
    """Return an identifier as near to `text` as there is one; `fallback` begins those without."""
    plain = unicodedata.normalize("NFKC", text)
    kept = "".join(c if f"a{c}".isidentifier() else "_" for c in plain)
    name = re.sub("__+", "_", kept).strip("_")[:_WIDEST]
    while width(name) > _WIDEST:
        name = name[:-1]
    name = name.rstrip("_")
    if not name:
        return fallback
    return name if name.isidentifier() else f"{fallback}_{name}"


def cut(what: str, text: str, name: str) -> list[str]:
    """Return a note about an identifier that leaves out the end of its name; empty for others."""
    is_whole = len(re.sub(r"\W|_", "", text)) <= len(name.replace("_", ""))
    if is_whole or width(name) < _NEARLY:
        return []
    return [f"{what} {text} is called {name} in the code, where names are cut"]


def attribute_name(text: str, fallback: str) -> str:
    """Return an identifier in lower case that hides no function of Python."""
    name = snake_case(text, fallback)
    return f"{name}_" if name in _FUNCTIONS else name


def snake_case(text: str, fallback: str) -> str:
    """Return an identifier in lower case, words joined by underscores."""
    return identifier(_HUMP.sub("_", identifier(text, fallback)).lower(), fallback)


def class_name(text: str) -> str:
    """Return an identifier in capitalised words."""
    words = identifier(text, "").split("_")
    name = "".join(word[0].upper() + word[1:] for word in words if word)
    if not name[:1].isupper() or keyword.iskeyword(name):
        name = f"Rtc{name}"
    return name if name.isidentifier() else "Rtc"


def module_name(text: str) -> str:
    """Return the name of a file that no other module's name hides."""
    name = identifier(text, "Rtc")
    hidden = name in sys.stdlib_module_names or name in _OURS or keyword.iskeyword(name)
    return f"{name}_rtc" if hidden else name


def type_name(text: str, fallback: str) -> str:
    """Return a name that create strings and instance names can hold, as near as there is one."""
    plain = "".join(c if c.isprintable() and c not in _RESERVED else "_" for c in text).strip()
    if plain.startswith("*"):  # the mark of zombies, which no instance may bear
        plain = f"_{plain[1:]}"
    return plain[: _WIDEST * 2].strip() or fallback


def in_words(name: str) -> str:
    """Return an identifier as a phrase: ``getEchoHistory`` is ``get echo history``."""
    return _HUMP.sub("_", name).replace("_", " ").strip().lower() or name


class Taken:
    """The names of one scope; gives each newcomer one of its own.

    Underscores are added behind until a name is free, as is usual for keywords; `rtkit.component`
    takes the names of ports and parameters without them.
    """

    def __init__(self, names: Iterable[str] = ()) -> None:
        self._names = {*names, *_ANNOTATIONS}

    def __contains__(self, name: object) -> bool:
        return name in self._names

    @property
    def all(self) -> frozenset[str]:
        """Every name that is taken."""
        return frozenset(self._names)

    def add(self, name: str) -> str:
        """Return a free name like this one, and take it."""
        while name in self._names or keyword.iskeyword(name) or name in ("None", "self"):
            name += "_"
        self._names.add(name)
        return name
