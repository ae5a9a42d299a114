"""Names of keys in YAML and JSON profiles, derived from the tables of the XML form.

A key is the name of an element or attribute beginning with a small letter. Where its namespace is
not that of the element it is in, the usual prefix stands before it: ``rtcExt::comment``.
Repeated elements are lists, dates are tables of year to second, and a target's preconditions
stand under ``condition``. Content of other namespaces is under ``foreign::attributes`` and
``foreign::elements``, with names as in ``{namespace}local``.
"""

from __future__ import annotations

import re

from rtkit.profile.xmlnames import NAMESPACES, short, split

ROOTS = {"rtc": "rtcProfile", "rts": "rtsProfile"}
SCHEMA_KEY = "$schema"
"""A key beside the root's that editors look for; readers do not."""

FOREIGN_ATTRIBUTES, FOREIGN_ELEMENTS = "foreign::attributes", "foreign::elements"
OWN_KEYS = "rtkit::"
"""Keys that begin so are attributes of rtkit's own namespace, which the tables do not have."""

FOREIGN_PARTS = ("name", "attributes", "text", "tail", "children")
CONDITION, WAITS = "condition", ("wait_time", "preceding")
DATE_PARTS = (
    "year", "month", "day", "hour", "minute", "second", "timezone", "fractionalSecond",
    "millisecond",
)  # fmt: skip
_CLOCK = 6
"""So many of these are whole numbers from year to second."""

_OWN_WORDS = {"occerrence": "occurrence"}
"""Names that the trees of the existing tools spell in another way than their XML."""

OTHER_WORDS = {"occurrence": ("occerrence",)}
"""Keys that are as good as the one that is written: the tools have both."""

_DATE = re.compile(
    r"(\d{4})-(\d{2})-(\d{2})T(\d{2}):(\d{2}):(\d{2})(?:\.(\d{1,12}))?(?:(Z)|([+-])(\d{2}):(\d{2}))?",
    re.ASCII,
)


def key_of(name: str, parent: str) -> str:
    """Return the key of ``{namespace}local`` inside an element of that name.

    >>> from rtkit.profile.xmlnames import clark
    >>> key_of(clark("rts:DataPorts"), clark("rts:Components"))
    'dataPorts'
    >>> key_of(clark("rtsExt:Location"), clark("rts:Components"))
    'rtsExt::location'
    """
    namespace, local = split(name)
    key = local[:1].lower() + local[1:]
    key = _OWN_WORDS.get(key, key)
    if namespace == split(parent)[0]:
        return key
    return f"{short(name).partition(':')[0]}::{key}"


def name_of(key: str, parent: str) -> str | None:
    """Return ``{namespace}local`` for a key that no table knows; None if it cannot be one."""
    prefix, _, local = key.rpartition("::")
    if not re.fullmatch(r"[^\W\d][\w.-]*", local):
        return None
    namespace = NAMESPACES.get(prefix) if prefix else split(parent)[0]
    return f"{{{namespace}}}{local}" if namespace and prefix != "xsi" else None


def date_table(text: str) -> dict[str, int | float] | None:
    """Return a date as the table of its parts; None where the table would lose something.

    >>> date_table("2008-04-18T14:00:05+09:00")["timezone"]
    540
    """
    found = _DATE.fullmatch(text)
    if found is None:
        return None
    made: dict[str, int | float] = dict(
        zip(DATE_PARTS, map(int, found.groups()[:_CLOCK]), strict=False)
    )
    if found[8]:
        made["timezone"] = 0
    elif found[9]:
        minutes = int(found[10]) * 60 + int(found[11])
        made["timezone"] = -minutes if found[9] == "-" else minutes
    if found[7]:
        made["fractionalSecond"] = float(f"0.{found[7]}")
    again = date_text({part: repr(value) for part, value in made.items()})
    return made if again == text else None


def date_text(parts: dict[str, str]) -> str | None:
    """Return the date of a table of parts, given as texts; None if it is no such table.

    >>> date_text({"year": "2020", "month": "1", "day": "2", "timezone": "-90"})
    '2020-01-02T00:00:00-01:30'
    """
    whole = [parts.get(part, "0").strip() for part in DATE_PARTS[:_CLOCK]]
    if not all(re.fullmatch("[0-9]{1,4}", part) for part in whole):
        return None
    year, month, day, hour, minute, second = map(int, whole)
    fraction = _fraction(parts)
    zone = _zone(parts.get("timezone"))
    if fraction is None or zone is None:
        return None
    return f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{fraction}{zone}"


def _fraction(parts: dict[str, str]) -> str | None:
    text = parts.get("fractionalSecond")
    if text is None:
        text = parts.get("millisecond", "0").strip()
        text = f"0.{text:>03}"
    found = re.fullmatch(r"0?\.([0-9]{1,12})|0", text.strip())
    if found is None:
        return None
    digits = found[1] or ""
    return f".{digits}" if digits.strip("0") else ""


def _zone(text: str | None) -> str | None:
    if text is None:
        return ""
    found = re.fullmatch("([+-]?)([0-9]{1,4})", text.strip())
    if found is None:
        return None
    hours, minutes = divmod(int(found[2]), 60)
    if not hours and not minutes:
        return "Z"
    return f"{'-' if found[1] == '-' else '+'}{hours:02}:{minutes:02}"
