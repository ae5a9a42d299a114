"""Keeps the packages of the user: each version in a folder of its own, with all that it needs.

A folder is made elsewhere and renamed last; it goes by the same way. So what is interrupted leaves
nothing that counts, and the next one clears it away.
"""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from packaging.requirements import Requirement
from packaging.tags import sys_tags
from packaging.utils import canonicalize_name, parse_wheel_filename

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.modules.package_folders import RECORD, folders, root
from rtkit.packages.bundle import unpacked
from rtkit.packages.records import Installed
from rtkit.packages.repository import Repositories
from rtkit.packages.resolving import fetch, resolve
from rtkit.packages.signing import are_required, check
from rtkit.packages.wheel import Wheel, read_wheel
from rtkit.rtc.nearest import did_you_mean

_DRAFTS = ".drafts"
_WHEELS = ".wheels"
_LOCK = "rtkit.lock/1"
SYSTEMS = ".rtkit-systems.json"
"""File of a version's folder: the systems that plans installed it for; it goes with it."""
Digests = dict[str, str]
"""SHA-256 in hexadecimal by the name of a wheel's file."""


def installed() -> list[Installed]:
    """Return what is installed, sorted by name, the newest version of each first."""
    found = []
    for each in folders():
        try:
            with open(os.path.join(each.path, RECORD), encoding="utf-8") as file:
                record = json.load(file)
            types, requires = tuple(record["types"]), tuple(record["requires"])
            found.append(Installed(*each, types, requires, dict(record["wheels"])))
        except (OSError, ValueError, KeyError, TypeError):
            continue  # no folder of ours
    return found


def meant(wanted: Requirement) -> list[Installed]:
    """Return the installed versions that a requirement means.

    Raises:
        NotFound: There is none; names the nearest.
    """
    name = canonicalize_name(wanted.name)
    known = installed()
    found = [e for e in known if e.name == name and wanted.specifier.contains(e.version, True)]
    if not found:
        hint = did_you_mean(name, [each.name for each in known if each.name != name])
        there = ", ".join(each.version for each in known if each.name == name)
        raise NotFound(f"{wanted} is not installed{f'; there is {there}' if there else hint}")
    return found


def install(
    wanted: Requirement,
    repositories: Repositories,
    lock: Mapping[str, str] | None = None,
    *,
    must_be_signed: bool = False,
    system: str = "",
) -> Installed:
    """Install a package and all that it needs; what is installed already is left as it is.

    Args:
        wanted: The package, and which versions of it will do.
        repositories: Where it and all that it needs are taken from, and from nowhere else.
        lock: SHA-256 that wheels must have, by the names of files; others may have any.
        must_be_signed: Each wheel has to be; so it is where the settings require it. What is in a
            bundle is signed with that.
        system: For which a plan installs it, noted if it is new.

    Raises:
        NotFound: No repository has it.
        Refused: Versions exclude each other, a wheel is not safe, or not signed, or its bytes have
            changed.
    """
    chosen = resolve(wanted, repositories)
    digests = {each.file: each.sha256 for each in chosen}
    compare(digests, lock or {}, "the lock has")
    name, version = chosen[0].name, chosen[0].version
    target = os.path.join(root(), name, version)
    if not os.path.isdir(target):
        with work_folder() as draft:
            wheels = [fetch(each, draft) for each in chosen]
            if not repositories.are_bundles():
                check(wheels, is_required=must_be_signed)
            _keep(wheels, draft, target, system)
    found = next(each for each in installed() if each.path == target)
    if (must_be_signed or are_required()) and not repositories.are_bundles():
        check([read_wheel(each) for each in kept_wheels(found)], is_required=True)
    compare({chosen[0].file: chosen[0].sha256}, found.wheels, "installed is")
    return found


def install_bundle(
    path: str, lock: Mapping[str, str] | None = None, *, must_be_signed: bool = False
) -> list[Installed]:
    """Install all packages of a bundle, from nowhere else; see `install`.

    Raises:
        RtkitError: See `rtkit.packages.bundle.unpacked`.
    """
    with unpacked(path, must_be_signed=must_be_signed) as found:
        there = Repositories({path: found.wheels}, [])
        return [install(Requirement(each), there, lock) for each in found.packages]


def compare(found: Mapping[str, str], wanted: Mapping[str, str], what: str) -> None:
    """Refuse wheels, SHA-256 by file, whose bytes differ from what is wanted of those files.

    Raises:
        Refused: One differs; `what` tells which other SHA-256 is known.
    """
    for file, digest in found.items():
        if wanted.get(file, digest) != digest:
            raise Refused(
                f"{file} is not what it was: {what} SHA-256 {wanted[file]},"
                f" the repository has {digest}"
            )


def install_wheels(files: Sequence[str], system: str = "") -> Installed:
    """Install a package from its wheel and those that it needs, without pip; see `install`.

    Raises:
        Refused: One is not safe, or for another kind of machine.
    """
    fitting = {*sys_tags()}
    for each in files:
        _, _, _, tags = parse_wheel_filename(os.path.basename(each))
        if fitting.isdisjoint(tags):
            raise Refused(f"{os.path.basename(each)} is for another kind of machine, or of Python")
    wheels = [read_wheel(each) for each in files]
    target = os.path.join(root(), wheels[0].name, wheels[0].version)
    if not os.path.isdir(target):
        with work_folder() as draft:
            for each in files:
                shutil.copyfile(each, os.path.join(draft, os.path.basename(each)))
            _keep(wheels, draft, target, system)
    found = next(each for each in installed() if each.path == target)
    compare({wheels[0].file: wheels[0].sha256}, found.wheels, "installed is")
    return found


def _keep(wheels: list[Wheel], draft: str, target: str, system: str) -> None:
    """Unpack wheels, and have them at their place by one rename."""
    whole = _unpacked(wheels, draft)
    if system:
        with open(os.path.join(whole, SYSTEMS), "w", encoding="utf-8") as file:
            json.dump([system], file)
    os.makedirs(os.path.dirname(target), exist_ok=True)
    try:
        os.rename(whole, target)
    except OSError:
        if not os.path.isdir(target):  # else somebody else was as quick
            raise


def _unpacked(wheels: list[Wheel], draft: str) -> str:
    """Return a folder with what wheels hold, that of the package first; nothing of them is run."""
    own = wheels[0]
    if not own.entries:
        raise Refused(f"{own.name} {own.version} is no package of components: no entry point")
    whole = os.path.join(draft, "whole")
    files = [os.path.join(draft, each.file) for each in wheels]
    for path in reversed(files):
        _unpack(path, whole)
    kept = os.path.join(whole, _WHEELS)
    os.mkdir(kept)  # bundles are made of them, and what is sent to other hosts
    for each in files:
        os.rename(each, os.path.join(kept, os.path.basename(each)))
    record = {
        "types": [each.id for each in own.types],
        "requires": own.requires,
        "wheels": {each.file: each.sha256 for each in wheels},
    }
    with open(os.path.join(whole, RECORD), "w", encoding="utf-8") as file:
        json.dump(record, file, indent=1)
    return whole


def _unpack(path: str, folder: str) -> None:
    """Unpack a wheel that was checked; of its data what is to be imported."""
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
        tops = {each.partition("/")[0] for each in archive.namelist()}
    for data in (each for each in tops if each.endswith(".data")):
        for part in ("purelib", "platlib"):
            source = os.path.join(folder, data, part)
            if os.path.isdir(source):
                shutil.copytree(source, folder, dirs_exist_ok=True)
        shutil.rmtree(os.path.join(folder, data))


def kept_wheels(package: Installed) -> list[str]:
    """Return the wheels that a package was installed from, its own and those that it needs.

    Raises:
        NotFound: They are not there.
        Refused: One has changed since.
    """
    paths = [os.path.join(package.path, _WHEELS, each) for each in package.wheels]
    for path, digest in zip(paths, package.wheels.values(), strict=True):
        if not os.path.isfile(path):
            again = f"rtpkg uninstall {package.text}, then rtpkg install {package.text}"
            raise NotFound(f"{package.text} was installed without its wheels ({again})")
        if read_wheel(path).sha256 != digest:
            raise Refused(f"{path} has changed since it was installed")
    return paths


def remove(package: Installed) -> None:
    """Remove a version of a package; it is gone at once, or there as a whole."""
    with work_folder() as draft:
        try:
            os.rename(package.path, os.path.join(draft, "gone"))
        except FileNotFoundError:
            return  # somebody else was as quick


@contextmanager
def work_folder() -> Iterator[str]:
    """Make a folder to work in, and clear away those whose processes have died.

    It is beside the packages, so that what is made there can be renamed to be one.
    """
    top = os.path.join(root(), _DRAFTS)
    os.makedirs(top, mode=0o700, exist_ok=True)
    with _locked(top, fcntl.LOCK_EX):
        for each in os.listdir(top):
            path = os.path.join(top, each)
            try:
                with _locked(path, fcntl.LOCK_EX | fcntl.LOCK_NB):
                    shutil.rmtree(path, ignore_errors=True)
            except (BlockingIOError, FileNotFoundError):
                continue  # in use, or its process has just removed it
        draft = tempfile.mkdtemp(dir=top)
        held = os.open(draft, os.O_RDONLY | os.O_CLOEXEC)
        fcntl.flock(held, fcntl.LOCK_SH)
    try:
        yield draft
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        os.close(held)


@contextmanager
def _locked(folder: str, how: int) -> Iterator[None]:
    descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, how)
        yield
    finally:
        os.close(descriptor)


def read_lock(path: str) -> dict[str, Digests]:
    """Return the wheels of each ``NAME==VERSION`` of a lock; nothing if there is no such file.

    Raises:
        Malformed: It is no lock.
    """
    try:
        with open(path, encoding="utf-8") as file:
            found: Any = json.load(file)
        if found["schema"] != _LOCK:
            raise ValueError(found["schema"])
        return {str(name): dict(wheels) for name, wheels in found["packages"].items()}
    except FileNotFoundError:
        return {}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Malformed(f"{path} is no lock of rtpkg: {error}") from None


def write_lock(path: str, packages: Mapping[str, Mapping[str, str]]) -> None:
    """Write a lock, replaced as a whole."""
    folder = os.path.dirname(os.path.abspath(path))
    with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as draft:
        json.dump({"schema": _LOCK, "packages": dict(sorted(packages.items()))}, draft, indent=1)
        draft.write("\n")
    os.replace(draft.name, path)
