"""Parses ``rtc.conf`` to properties, and lists the places to look for it. It opens no file."""

from __future__ import annotations

import os.path
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from rtkit.errors import Malformed, RtkitError
from rtkit.settings import properties

VARIABLE = "RTC_MANAGER_CONFIG"
SYSTEM_FILES = (
    "/etc/rtkit/rtc.conf",
    "/etc/rtc.conf",
    "/etc/rtc/rtc.conf",
    "/usr/local/etc/rtc.conf",
    "/usr/local/etc/rtc/rtc.conf",
)
_MAX_BYTES = 1 << 20


class RtcConfEntry(NamedTuple):
    """One property as the file has it."""

    key: str
    value: str
    line: int


def candidates(environment: Mapping[str, str], folder: str) -> Iterator[tuple[str, bool]]:
    """Yield where to look, best first, and whether somebody named the file so that it must exist.

    The first that exists is taken; further ones are not read.
    """
    named = environment.get(VARIABLE, "")
    if named:
        yield os.path.join(folder, named), True
        return
    yield os.path.join(folder, "rtc.conf"), False
    for path in SYSTEM_FILES:
        yield path, False


def parse(data: bytes, file: str) -> list[RtcConfEntry]:
    """Read the text of a configuration file.

    Raises:
        Malformed: A line cannot be read; names file and line.
    """
    if len(data) > _MAX_BYTES:
        raise Malformed(f"{file}:1: larger than {_MAX_BYTES} bytes")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise Malformed(f"{file}:{line}: not UTF-8 text") from error
    entries = []
    for number, whole in _logical_lines(text):
        try:
            entries.append(_entry(whole, number))
        except RtkitError as error:
            raise type(error)(f"{file}:{number}: {error}") from None
    return entries


def _entry(whole: str, number: int) -> RtcConfEntry:
    key, colon, value = whole.partition(":")
    key = key.strip()
    if not colon:
        raise Malformed(f"not KEY: VALUE: {whole.strip()}")
    if not key or any(c.isspace() or not c.isprintable() for c in key):
        raise Malformed(f"not a property key: {key!r}")
    return RtcConfEntry(key, properties.check(key, value), number)


def parse_override(text: str) -> RtcConfEntry:
    """Read ``key:value`` of the command line.

    Raises:
        Malformed: It has no colon, no key, or a value that is not of the key's kind.
    """
    key, colon, value = text.partition(":")
    if not colon or not key.strip():
        raise Malformed(f"not KEY:VALUE: {text}")
    return RtcConfEntry(key.strip(), properties.check(key.strip(), value), 0)


def warnings(entries: Iterable[RtcConfEntry], file: str) -> list[str]:
    """Return findings about keys that are not known, given twice, or without effect."""
    findings = []
    seen: dict[str, int] = {}
    for key, value, line in entries:
        place = f"{file}:{line}: " if line else ""
        name = properties.canonical(key)
        if properties.find(key) is None:
            findings.append(place + properties.unknown(key))
        elif name in seen and line:
            findings.append(f"{place}{key} was given in line {seen[name]} already; this one counts")
        elif properties.vain(key, value):
            findings.append(place + properties.vain(key, value))
        seen[name] = line
    return findings


def _logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """Yield the lines with content, continued ones joined, with the number of the first."""
    joined, began = "", 0
    for number, line in enumerate(text.split("\n"), 1):
        if line.lstrip().startswith("#"):
            continue
        began = began or number
        line = line.rstrip()
        joined += (line.lstrip() if joined else line).removesuffix("\\")
        if line.endswith("\\"):
            continue
        if joined.strip():
            yield began, joined
        joined, began = "", 0
    if joined.strip():
        yield began, joined
