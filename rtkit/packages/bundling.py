"""Finds the packages that a system profile needs, with their wheels."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from importlib import metadata

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from rtkit.deployment.described import type_of
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.packages.installed import compare, installed, kept_wheels
from rtkit.packages.offering import offerings
from rtkit.packages.precheck import is_built_in
from rtkit.packages.repository import Repositories, newest_first, offers, opened
from rtkit.packages.resolving import fetch, resolve
from rtkit.packages.signing import check
from rtkit.packages.wheel import read_wheel
from rtkit.packages.wheel_target import WheelTarget
from rtkit.profile.rts_model import ComponentInstance, RtsProfile


def gather(profile: RtsProfile, repositories: Repositories, folder: str) -> dict[str, list[str]]:
    """Return the wheels of all packages that a system needs, by ``NAME==VERSION``.

    Args:
        profile: The system profile.
        repositories: Where packages are found that are not installed.
        folder: Gets wheels that are fetched.

    Raises:
        NotFound: A component is of no package; names it.
        Refused: A package has changed since it was installed.
    """
    needing = {type_of(each.id).id: each for each in profile.components if not is_built_in(each)}
    found = offerings(needing)
    packages = {all[0].package.text: kept_wheels(all[0].package) for all in found.values()}
    for id in needing.keys() - found.keys():
        name = _offered(id, needing[id], repositories)
        if name not in packages:
            packages |= fetched(Requirement(name), repositories, folder)
    _check_alike(packages)
    check_whole(packages)
    return packages


def fetched(
    wanted: Requirement,
    repositories: Repositories,
    folder: str,
    target: WheelTarget | None = None,
) -> dict[str, list[str]]:
    """Return the wheels of a package and of all that it needs, by its ``NAME==VERSION``.

    Args:
        wanted: The package.
        repositories: Where it is found.
        folder: Gets the wheels.
        target: The host that it is for, None for this one.

    Raises:
        NotFound: No repository has it.
        Refused: Versions exclude each other, or a wheel is not signed where that is required.
    """
    chosen = resolve(wanted, repositories, target)
    name = f"{chosen[0].name}=={chosen[0].version}"
    there = os.path.join(folder, name)
    os.mkdir(there)
    wheels = [fetch(each, there, target) for each in chosen]
    if not repositories.are_bundles():
        check(wheels)
    return {name: [os.path.join(there, each.file) for each in wheels]}


def _offered(id: str, component: ComponentInstance, repositories: Repositories) -> str:
    """Return the newest package of repositories that offers a type, as ``NAME==VERSION``."""
    there = [each for each in offers(repositories) if not isinstance(each, RtkitError)]
    for each in newest_first(there):
        if each.wheel is not None and id in [type.id for type in each.wheel.types]:
            return f"{each.name}=={each.version}"
    raise NotFound(
        f"component {component.instance_name}: no installed package has {id}, and no repository"
        " that was looked in (rtpkg build makes a package of a folder, rtpkg install installs it)"
    )


def _check_alike(packages: Mapping[str, Sequence[str]]) -> None:
    """Refuse wheels of one name and other bytes."""
    known: dict[str, str] = {}
    for path in (path for paths in packages.values() for path in paths):
        file = os.path.basename(path)
        with open(path, "rb") as stream, open(known.setdefault(file, path), "rb") as other:
            if stream.read() != other.read():
                raise Refused(f"two packages have other bytes of {file}")


def pushable(
    package: str,
    names: Sequence[str],
    digests: Mapping[str, str],
    folder: str,
    target: WheelTarget | None = None,
) -> dict[str, list[str]]:
    """Return the wheels of a package as it is installed here, else of repositories, by its name.

    Args:
        package: ``NAME==VERSION``.
        names: Repositories.
        digests: SHA-256 that the wheels must have, by file.
        folder: Gets wheels that are fetched.
        target: The host that it is for; None while that is not known, so for one as this one.

    Raises:
        NotFound: No repository has it, or it needs what a clean rtkit has not.
        Refused: A wheel has changed, or is not signed where that is required.
    """
    here = next((each for each in installed() if each.text == package), None)
    is_kept = here is not None and {**here.wheels} == {**digests}
    if here is not None and is_kept and (target is None or target.kind.fits(here.wheels)):
        found = {package: kept_wheels(here)}
        check([read_wheel(each) for each in found[package]])
    else:
        with opened(names) as there:
            found = fetched(Requirement(package), there, folder, target)
        wheels = (read_wheel(each) for each in found[package])
        compare({each.file: each.sha256 for each in wheels}, digests, "the plan has")
        if target is not None:
            return found  # with all that the host lacks
    check_whole(found)
    return found


def check_whole(packages: Mapping[str, Sequence[str]]) -> None:
    """Refuse packages that need what neither they nor rtkit alone have.

    Raises:
        NotFound: One does; names it.
    """
    clean = _with_rtkit()
    for name, paths in packages.items():
        wheels = [read_wheel(each) for each in paths]
        there = {*clean, *(each.name for each in wheels)}
        for wheel in wheels:
            for needed in _needs(wheel.requires):
                if needed not in there:
                    raise NotFound(
                        f"{name} needs {needed}, which this Python has, and a clean rtkit has not"
                        f" (where it has not, rtpkg install {name} takes it in)"
                    )


def _with_rtkit() -> set[str]:
    """Return the names of rtkit and of all that it needs."""
    found: set[str] = set()
    left = ["rtkit"]
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            try:
                left += _needs(metadata.requires(name) or ())
            except metadata.PackageNotFoundError:
                continue
    return found


def _needs(requires: Iterable[str]) -> list[str]:
    wanted = (Requirement(each) for each in requires)
    return [
        canonicalize_name(each.name)
        for each in wanted
        if each.marker is None or each.marker.evaluate({"extra": ""})
    ]
