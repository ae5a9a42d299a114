"""Templates of the names under which components are registered (``naming.formats``).

``%n`` instance, ``%t`` and ``%m`` type, ``%v`` version, ``%V`` vendor, ``%c`` category, ``%h``
host, ``%M`` manager, ``%p`` pid of its process, ``%%`` a per cent sign.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from rtkit.errors import Malformed
from rtkit.rtc.names import LOCAL
from rtkit.rtc.profiles import TypeProfile

DEFAULT = "%n.rtc"
_LETTER = re.compile(r"%(.?)", re.DOTALL)
_LETTERS = "ntmvVchMp%"
_OF_MANAGERS = "nhMp%"
_EARLY = "nhM%"
"""Names known before a component is made."""


def check(text: str) -> tuple[str, ...]:
    """Return the templates of a comma list.

    Raises:
        Malformed: One of them cannot be read; gives the reason.
    """
    templates = tuple(item for item in map(str.strip, text.split(",")) if item)
    for template in templates:
        letters = _LETTER.findall(template)
        bad = sorted(set(letters) - set(_LETTERS))
        if bad:
            known = " ".join(f"%{letter}" for letter in _LETTERS)
            raise Malformed(f"unknown %{bad[0]} in name template {template} (known: {known})")
        if any(part in ("", ".", "..") for part in template.split("/")):
            raise Malformed(f"name template has an empty or dotted element: {template}")
        if any(part.startswith("*") for part in template.split("/")):
            raise Malformed(f"name template has an element that begins with *: {template}")
        if ":" in template or not template.isprintable():
            raise Malformed(f"name template has a character that no name may have: {template}")
    return templates


def check_early(text: str) -> tuple[str, ...]:
    """Return the templates of a comma list, in which nothing stands for a component.

    Raises:
        Malformed: One of them cannot be read; gives the reason.
    """
    templates = check(text)
    for template in templates:
        bad = [letter for letter in _LETTER.findall(template) if letter not in _OF_MANAGERS]
        if bad:
            known = " ".join(f"%{letter}" for letter in _OF_MANAGERS)
            raise Malformed(f"%{bad[0]} means no manager in name template {template} ({known} do)")
    return templates


def is_early(template: str) -> bool:
    """Return whether the name is known before the component is made."""
    return set(_LETTER.findall(template)) <= set(_EARLY)


def expand(
    templates: Iterable[str],
    *,
    instance: str,
    host: str,
    manager: str,
    type: TypeProfile | None = None,
    pid: int = 0,
) -> tuple[str, ...]:
    """Return the full names, each once.

    Raises:
        Malformed: A template gives a name with an empty element.
    """
    made = type or TypeProfile("")
    fields = {
        "n": instance,
        "t": made.type_name,
        "m": made.type_name,
        "v": made.version,
        "V": made.vendor,
        "c": made.category,
        "h": host,
        "M": manager,
        "p": str(pid),
        "%": "%",
    }
    clean = {letter: text.replace("/", "_").replace(":", "_") for letter, text in fields.items()}
    return tuple(dict.fromkeys(f"{LOCAL}/{_expand(each, clean)}" for each in templates))


def _expand(template: str, fields: dict[str, str]) -> str:
    name = _LETTER.sub(lambda found: fields[found[1]], template)
    if any(part in ("", ".", "..") for part in name.split("/")):
        raise Malformed(f"name template {template} gives a name with an empty element: {name}")
    return name
