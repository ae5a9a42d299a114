"""Chooses the packages of repositories that offer component types of which none is installed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rtkit.errors import RtkitError
from rtkit.modules.package_folders import folders
from rtkit.packages.installed import Digests, Installed, install, installed, remove
from rtkit.packages.offering import Offering
from rtkit.packages.repository import Offer, Repositories, newest_first, offers, opened
from rtkit.packages.resolving import fetch, resolve
from rtkit.packages.signing import check
from rtkit.packages.usage import check_unused
from rtkit.packages.wheel import Wheel


class Supply(NamedTuple):
    """Packages that would make components of types, by the ids of these.

    Attributes:
        found: The chosen offering of each type; its package is not installed yet.
        lacks: Why, by type, none of those that offer it can be installed.
    """

    found: dict[str, Offering]
    lacks: dict[str, str]


def supply(
    ids: Sequence[str], names: Sequence[str], notify: Callable[[list[str]], object]
) -> Supply:
    """Choose the newest package that offers each type and can be installed; nothing is installed.

    Args:
        ids: Ids of component types, ``RTC:VENDOR:CATEGORY:TYPE:VERSION``.
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
        choosing = _Choosing(newest_first(there), repositories, draft)
        for id in dict.fromkeys(ids):
            choosing.choose(id, chosen)
    return chosen


class _Choosing:
    """Asks pip once for each package."""

    def __init__(self, there: list[Offer], repositories: Repositories, draft: str) -> None:
        self._there = there
        self._repositories = repositories
        self._draft = draft
        self._known: dict[tuple[str, str], tuple[Digests, Wheel] | RtkitError] = {}

    def choose(self, id: str, chosen: Supply) -> None:
        for offer in self._candidates(id):
            found = self._resolved(offer)
            digests, wheel = ({}, offer.wheel) if isinstance(found, RtkitError) else found
            offering = _of_type(id, wheel, digests) if wheel is not None else None
            if isinstance(found, RtkitError):
                chosen.lacks.setdefault(id, str(found))
                if offering is not None:
                    chosen.found.setdefault(id, offering)
            elif offering is not None:
                chosen.found[id] = offering
                chosen.lacks.pop(id, None)
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

    def _resolved(self, offer: Offer) -> tuple[Digests, Wheel] | RtkitError:
        key = (offer.name, offer.version)
        if key not in self._known:
            try:
                wanted = Requirement(f"{offer.name}=={offer.version}")
                wheels = resolve(wanted, self._repositories)
                digests = {each.file: each.sha256 for each in wheels}
                wheel = offer.wheel or fetch(wheels[0], self._draft)
                if not self._repositories.are_bundles():
                    check([wheel])
                self._known[key] = digests, wheel
            except RtkitError as error:
                self._known[key] = error
        return self._known[key]


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


class LocalInstaller:
    """Installs on this host what a plan says, from the repositories in which it was chosen."""

    def __init__(
        self,
        repositories: Sequence[str],
        digests: Mapping[str, Mapping[str, str]],
        timeout_s: float,
        system: str,
    ) -> None:
        self._repositories = repositories
        self._digests = digests
        self._timeout_s = timeout_s
        self._system = system

    def install(self, package: str) -> None:
        """Install a package, ``HOST/NAME==VERSION``, with the very bytes that were looked at.

        Raises:
            RtkitError: See `rtkit.packages.installed.install`.
        """
        text = package.partition("/")[2]
        with opened(self._repositories) as there:
            install(Requirement(text), there, self._digests.get(text), system=self._system)

    def uninstall(self, package: str) -> None:
        """Remove a package, ``HOST/NAME==VERSION``.

        Raises:
            Refused: A manager uses it.
        """
        text = package.partition("/")[2]
        for each in installed():
            if each.text == text:
                check_unused(each, self._timeout_s)
                remove(each)
