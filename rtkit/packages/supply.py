"""Chooses the packages of repositories that offer component types of which none is installed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rtkit.errors import RtkitError
from rtkit.modules.package_folders import folders
from rtkit.packages.installed import Digests, install, installed, remove
from rtkit.packages.records import Installed, Offering
from rtkit.packages.repository import Offer, Repositories, newest_first, offers, opened
from rtkit.packages.resolving import fetch, resolve
from rtkit.packages.signing import are_required, check
from rtkit.packages.usage import check_unused
from rtkit.packages.wheel import Wheel
from rtkit.packages.wheel_target import WheelTarget

HostType = tuple[str, str]
"""A host, and the id of a component type that it needs: ``RTC:VENDOR:CATEGORY:TYPE:VERSION``."""


class Supply(NamedTuple):
    """Packages that would make components of types on hosts.

    Attributes:
        found: The chosen offering of each type; its package is not installed yet.
        lacks: Why, by type, none of those that offer it can be installed.
    """

    found: dict[HostType, Offering]
    lacks: dict[HostType, str]


def supply(
    wanted: Iterable[HostType],
    targets: Mapping[str, WheelTarget],
    names: Sequence[str],
    notify: Callable[[list[str]], object],
) -> Supply:
    """Choose the newest package that offers each type and can be installed; nothing is installed.

    Args:
        wanted: The types.
        targets: What packages are chosen for by host; for others they are chosen as for this one.
        names: Repositories.
        notify: Gets what is wrong with some of these.
    """
    chosen = Supply({}, {})
    with opened(names) as repositories, tempfile.TemporaryDirectory(prefix="rtpkg-") as draft:
        there: list[Offer] = []
        for each in offers(repositories):
            if isinstance(each, RtkitError):
                notify([str(each)])
            else:
                there.append(each)
        choosing = _Choosing(newest_first(there), repositories, targets, draft)
        for host_type in dict.fromkeys(wanted):
            choosing.choose(host_type, chosen)
    return chosen


class _Choosing:
    """Asks pip once for each package and kind of host."""

    def __init__(
        self,
        there: list[Offer],
        repositories: Repositories,
        targets: Mapping[str, WheelTarget],
        draft: str,
    ) -> None:
        self._there = there
        self._repositories = repositories
        self._targets = targets
        self._draft = draft
        self._known: list[tuple[_Question, tuple[Digests, Wheel] | RtkitError]] = []

    def choose(self, wanted: HostType, chosen: Supply) -> None:
        host, id = wanted
        for offer in self._candidates(id):
            found = self._resolved(offer, self._targets.get(host))
            digests, wheel = ({}, offer.wheel) if isinstance(found, RtkitError) else found
            offering = _of_type(id, wheel, digests) if wheel is not None else None
            if isinstance(found, RtkitError):
                chosen.lacks.setdefault(wanted, str(found))
                if offering is not None:
                    chosen.found.setdefault(wanted, offering)
            elif offering is not None:
                chosen.found[wanted] = offering
                chosen.lacks.pop(wanted, None)
                return

    def _candidates(self, id: str) -> Iterator[Offer]:
        """Yield packages that offer a type, and those of an index that are called as it is."""
        usual = canonicalize_name(f"rtc-{id.split(':')[3]}")
        for each in self._there:
            if each.wheel is None:
                if each.name == usual:
                    yield each
            elif id in [type.id for type in each.wheel.types]:
                yield each

    def _resolved(
        self, offer: Offer, target: WheelTarget | None
    ) -> tuple[Digests, Wheel] | RtkitError:
        asked = _Question(offer.name, offer.version, target)
        for known, found in self._known:
            if known == asked:
                return found
        answer: tuple[Digests, Wheel] | RtkitError
        try:
            answer = self._resolve(asked)
        except RtkitError as error:
            answer = error
        self._known.append((asked, answer))
        return answer

    def _resolve(self, asked: _Question) -> tuple[Digests, Wheel]:
        """Return the wheels of a package with all that it needs, and its own.

        Raises:
            RtkitError: It cannot be had; or a wheel is not signed where that is required.
        """
        wanted = Requirement(f"{asked.name}=={asked.version}")
        wheels = resolve(wanted, self._repositories, asked.target)
        is_signed = are_required() and not self._repositories.are_bundles()
        known = {(w.file, w.sha256): w for each in self._there if (w := each.wheel) is not None}
        read = [
            known.get((each.file, each.sha256)) or fetch(each, self._draft, asked.target)
            for each in (wheels if is_signed else wheels[:1])
        ]
        check(read if is_signed else ())
        return {each.file: each.sha256 for each in wheels}, read[0]


class _Question(NamedTuple):
    name: str
    version: str
    target: WheelTarget | None


def _of_type(id: str, wheel: Wheel, digests: Digests) -> Offering | None:
    """Return how a wheel offers a type when it is installed with others."""
    types = tuple(each.id for each in wheel.types)
    package = Installed(wheel.name, wheel.version, "", types, wheel.requires, digests)
    for type in (each for each in wheel.types if each.id == id):
        named = [each for each in wheel.entries if type.type_name in _names(each)]
        for name, _, init in (named or wheel.entries)[:1]:
            return Offering(package, type, f"{name}=={wheel.version}:{init}")
    return None


def _names(entry: tuple[str, str, str]) -> tuple[str, str]:
    return entry[0], entry[1].rpartition(".")[2]


def here(packages: Sequence[str]) -> frozenset[str]:
    """Return which of these packages, ``NAME==VERSION``, are installed on this host."""
    there = {f"{each.name}=={each.version}" for each in folders()} if packages else set()
    return frozenset(there.intersection(packages))


class LocalInstaller(NamedTuple):
    """Installs on this host what a plan says, from the repositories in which it was chosen."""

    repositories: Sequence[str]
    digests: Mapping[str, Mapping[str, str]]
    timeout_s: float
    system: str

    def install(self, package: str) -> None:
        """Install a package, ``HOST/NAME==VERSION``, with the very bytes that were looked at.

        Raises:
            RtkitError: See `rtkit.packages.installed.install`.
        """
        wanted = Requirement(package.partition("/")[2])
        with opened(self.repositories) as there:
            install(wanted, there, self.digests.get(package), system=self.system)

    def uninstall(self, package: str) -> None:
        """Remove a package, ``HOST/NAME==VERSION``.

        Raises:
            Refused: A manager uses it.
        """
        text = package.partition("/")[2]
        for each in installed():
            if each.text == text:
                check_unused(each, self.timeout_s)
                remove(each)
