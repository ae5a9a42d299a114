"""Finds the component types that documents use: RTC profiles of granted folders, and known ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtkit.api.component_profiles import profiles
from rtkit.api.live_records import Record
from rtkit.errors import NotFound
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.read import read_rtc
from rtkit.profile.rtc_model import RtcProfile
from rtkit.static_check.catalogue import Catalogue
from rtkit.static_check.stock import CandidateDocument, stocked


class TypeStock:
    """RTC profiles; a file that is as it was before is not read again."""

    def __init__(self, folders: Sequence[str]) -> None:
        """Know none yet.

        Args:
            folders: Those granted; what is in them comes first.
        """
        self._folders = folders
        self._read: dict[str, tuple[bytes, RtcProfile | None]] = {}

    def records(self) -> list[Record]:
        """Return the types that a component can be made of."""
        return [
            {
                "file": file,
                "id": profile.id,
                "name": info.name,
                "category": info.category,
                "vendor": info.vendor,
                "version": info.version,
                "description": info.description,
                "ports": len(profile.data_ports) + len(profile.service_ports),
            }
            for file, profile in self._profiles()
            if (info := profile.basic_info) is not None
        ]

    def profile(self, file: str) -> RtcProfile:
        """Return the profile of a type.

        Raises:
            NotFound: No type comes from that file.
        """
        known = self._read.get(file) or dict(self._documents()).get(file)
        profile = known[1] if known is not None else None
        if profile is None or profile.basic_info is None:
            raise NotFound(f"No such component type: {file}")
        return profile

    def catalogue(self, types: set[str], system: str) -> Catalogue:
        """Return what is known of some types, as ``rtprofile check`` finds it.

        Args:
            types: Their names.
            system: The file of the system.
        """
        documents = (CandidateDocument(*each) for each in self._candidates(system))
        return stocked(documents, types)[0]

    def _candidates(self, system: str = "") -> Iterator[tuple[str, bytes]]:
        return profiles(self._folders, lambda _: None, systems=(system,) if system else ())

    def _documents(self) -> Iterator[tuple[str, tuple[bytes, RtcProfile | None]]]:
        for file, data in self._candidates():
            known = self._read.get(file)
            if known is None or known[0] != data:
                known = self._read[file] = (data, _read(file, data))
            yield file, known

    def _profiles(self) -> Iterator[tuple[str, RtcProfile]]:
        for file, (_, profile) in self._documents():
            if profile is not None:
                yield file, profile


def _read(file: str, data: bytes) -> RtcProfile | None:
    """Return a profile; None for a file that is none, as there are beside profiles."""
    try:
        return read_rtc(data, file).profile
    except InvalidProfile:
        return None
