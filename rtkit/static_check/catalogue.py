"""Catalogue of the component types that RTC profiles describe, by the identity of a component."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from rtkit.deployment.described import type_of
from rtkit.profile.rtc_model import RtcProfile
from rtkit.rtc.profiles import TypeProfile
from rtkit.static_check.blueprint import Blueprint, blueprint

_Key = tuple[str, str, str]


class Match(NamedTuple):
    """Match of an identity in a catalogue.

    Attributes:
        is_other_version: The profile is of another version than the component.
        others: Files that describe the same version of the type differently.
    """

    blueprint: Blueprint
    is_other_version: bool
    others: tuple[str, ...]


class Catalogue:
    """Component types; of several profiles of one type and version the first one counts."""

    def __init__(self, profiles: Iterable[tuple[RtcProfile, str]] = ()) -> None:
        self._types: dict[_Key, list[Blueprint]] = {}
        self._by_name: dict[str, list[Blueprint]] = {}
        self._found: dict[str, Match | None] = {}
        for profile, source in profiles:
            self.add(profile, source)

    def add(self, profile: RtcProfile, source: str) -> None:
        """Take a profile in; a fragment, which has no identity, is passed over."""
        self._found.clear()
        for type in _identities(profile):
            made = blueprint(profile, type, source)
            self._types.setdefault(_key(type), []).append(made)
            self._by_name.setdefault(type.type_name, []).append(made)

    def find(self, id: str) -> Match | None:
        """Return the type of that identity, of another version where there is no other way."""
        if id not in self._found:
            self._found[id] = self._find(type_of(id))
        return self._found[id]

    def namesakes(self, id: str) -> list[str]:
        """Return the identities of types with the same name, of other vendors or categories."""
        name = type_of(id).type_name
        return sorted({each.type.id for each in self._by_name.get(name, ())})

    def _find(self, wanted: TypeProfile) -> Match | None:
        known = self._types.get(_key(wanted), [])
        if not known:
            return None
        same = [each for each in known if each.type.version == wanted.version]
        if not same:
            newest = max(_rank(each.type.version) for each in known)
            same = [each for each in known if _rank(each.type.version) == newest]
        chosen = same[0]
        others = tuple(each.source for each in same[1:] if not each.is_same(chosen))
        return Match(chosen, chosen.type.version != wanted.version, others)


def _key(type: TypeProfile) -> _Key:
    return (type.vendor, type.category, type.type_name)


def _rank(version: str) -> tuple[tuple[int, str], ...]:
    """Return what orders versions: numbers by value, before words."""
    parts = re.findall(r"[0-9]{1,18}|[^0-9.]+", version)
    return tuple((int(part), "") if part[0] in "0123456789" else (-1, part) for part in parts)


def _identities(profile: RtcProfile) -> list[TypeProfile]:
    """Return the identity that BasicInfo states, and that of the id where it is another."""
    found = []
    info = profile.basic_info
    if info is not None:
        found.append(TypeProfile(info.name, info.vendor, info.category, info.version))
    if profile.id.startswith("RTC:"):
        found.append(type_of(profile.id))
    return list(dict.fromkeys(found))
