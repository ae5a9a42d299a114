"""Stock of documents: makes a catalogue from files of which only some are RTC profiles."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import NamedTuple

from rtkit.profile.findings import InvalidProfile
from rtkit.profile.forms import may_be_component
from rtkit.profile.read import read_rtc
from rtkit.report.finding import WARNING, Checked, Finding
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.verdict import USUAL, Options

_HEAD = 8192
_ESCAPES = (b"&", b"\\", b"\0")


class CandidateDocument(NamedTuple):
    """A file that may be an RTC profile; `name` as the user knows it."""

    name: str
    data: bytes


def stocked(
    documents: Iterable[CandidateDocument], types: Collection[str], options: Options = USUAL
) -> tuple[Catalogue, list[Checked]]:
    """Return the catalogue of these component types, and verdicts on profiles that are unreadable.

    Args:
        documents: Of any kind; all but RTC profiles are passed over.
        types: Names of the types that are wanted; profiles of others are not even read.
        options: How severe the verdicts are.
    """
    catalogue = Catalogue()
    troubles: list[Checked] = []
    for document in documents:
        if not _may_be_of(document.data, types):
            continue
        try:
            profile = read_rtc(document.data, document.name).profile
        except InvalidProfile as error:
            findings = options.chosen([_unread(document, error)])
            troubles += [Checked(document.name, "RTC profile", findings)] if findings else []
        else:
            catalogue.add(profile, document.name)
    return catalogue, troubles


def _may_be_of(data: bytes, types: Collection[str]) -> bool:
    """Return whether it may be a profile of one of these types, without parsing."""
    if not may_be_component(data[:_HEAD]):
        return False
    is_plain = data.isascii() and not any(mark in data for mark in _ESCAPES)
    return not is_plain or any(name.encode() in data for name in types)


def _unread(document: CandidateDocument, error: InvalidProfile) -> Finding:
    first = error.problems[0]
    text = f"this RTC profile cannot be read: {first.text}"
    rule = "unreadable-profile"
    return Finding(WARNING, rule, text, document.name, first.line, first.path, first.found)
