"""Bundles: a system profile with all packages that it needs, as one file that changes in no byte.

A bundle is a ZIP file, nothing of it compressed: ``bundle.json`` first, with the SHA-256 of all the
others, ``system.xml``, and wheels in ``wheels/``. Its comment is the SHA-256 of ``bundle.json``,
and behind a space its signature, if it has one.
The same content is always the same bytes, so what differs anywhere else is found, too.
"""

from __future__ import annotations

import filecmp
import hashlib
import json
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from rtkit.errors import InvalidDocument, NotFound, Refused, RtkitError

SUFFIX = ".rtbundle"
_SCHEMA = "rtkit.bundle/1"
_INDEX, _SYSTEM, _WHEELS = "bundle.json", "system.xml", "wheels"
_NAME = re.compile(r"bundle\.json|system\.xml|wheels/[A-Za-z0-9_.+!-]+\.whl")
_MOST_FILES = 2000
_LARGEST_INDEX = 1 << 24
_EPOCH = (1980, 1, 1, 0, 0, 0)


class Unpacked(NamedTuple):
    """A bundle that was checked.

    Attributes:
        system: Its system profile, XML.
        wheels: Folder of its wheels.
        packages: SHA-256 of the wheels of each ``NAME==VERSION``, by file.
        content: ``bundle.json``, with the SHA-256 of all files.
        signer: Who has signed it, where that was checked.
    """

    system: bytes
    wheels: str
    packages: dict[str, dict[str, str]]
    content: bytes
    signer: str = ""


def is_bundle(name: str) -> bool:
    """Return whether a file is called as bundles are."""
    return name.endswith(SUFFIX)


def write(path: str, system: bytes, packages: Mapping[str, Sequence[str]]) -> None:
    """Write a bundle, replaced as a whole.

    Args:
        path: The file.
        system: The system profile, XML.
        packages: Wheels by ``NAME==VERSION``.

    Raises:
        Refused: It cannot be written.
    """
    try:
        with tempfile.TemporaryDirectory(
            dir=os.path.dirname(os.path.abspath(path)), prefix=".rtpkg-"
        ) as draft:
            os.mkdir(os.path.join(draft, _WHEELS))
            with open(os.path.join(draft, _SYSTEM), "wb") as stream:
                stream.write(system)
            named = {}
            for name, files in sorted(packages.items()):
                named[name] = sorted(os.path.basename(each) for each in files)
                for each in files:
                    shutil.copyfile(each, os.path.join(draft, _WHEELS, os.path.basename(each)))
            wheels = sorted(os.listdir(os.path.join(draft, _WHEELS)))
            entries = [_SYSTEM, *(f"{_WHEELS}/{each}" for each in wheels)]
            digests = {each: _digest(os.path.join(draft, each)) for each in entries}
            index = {"schema": _SCHEMA, "files": digests, "packages": named}
            with open(os.path.join(draft, _INDEX), "w", encoding="ascii") as stream:
                json.dump(index, stream, indent=1, sort_keys=True)
            made = os.path.join(draft, "made")
            _pack(draft, [_INDEX, *entries], made)
            os.replace(made, path)
    except OSError as error:
        raise Refused(f"cannot write {path}: {error.strerror or error}") from error


def _digest(path: str) -> str:
    with open(path, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def sign(path: str) -> None:
    """Sign a bundle; it is replaced as a whole by the same with a signature.

    Raises:
        RtkitError: See `unpacked`, and `rtkit.packages.signing.signed`.
    """
    from rtkit.packages import signing

    with unpacked(path, may_be_unsigned=True) as found:
        folder = os.path.dirname(found.wheels)
        wheels = (f"{_WHEELS}/{each}" for each in sorted(os.listdir(found.wheels)))
        signature = signing.signed(found.content, signing.BUNDLE).encode()
        parent = os.path.dirname(os.path.abspath(path))
        with tempfile.TemporaryDirectory(dir=parent, prefix=".rtpkg-") as draft:
            made = os.path.join(draft, "made")
            _pack(folder, [_INDEX, _SYSTEM, *wheels], made, signature)
            os.replace(made, path)


def _pack(folder: str, entries: Sequence[str], path: str, signature: bytes = b"") -> None:
    with zipfile.ZipFile(path, "w") as archive:
        digest = _digest(os.path.join(folder, entries[0])).encode()
        archive.comment = b" ".join(filter(None, (digest, signature)))
        for name in entries:
            info = zipfile.ZipInfo(name, _EPOCH)
            info.create_system, info.external_attr = 3, 0o100644 << 16
            info.file_size = os.path.getsize(os.path.join(folder, name))
            with (
                open(os.path.join(folder, name), "rb") as source,
                archive.open(info, "w") as target,
            ):
                shutil.copyfileobj(source, target, 1 << 20)


def read_system(path: str) -> bytes:
    """Return the system profile of a bundle.

    Raises:
        RtkitError: See `unpacked`.
    """
    with unpacked(path) as found:
        return found.system


@contextmanager
def unpacked(
    path: str, *, must_be_signed: bool = False, may_be_unsigned: bool = False
) -> Iterator[Unpacked]:
    """Check a bundle, and have its files in a folder until the end; nothing of them is run.

    Args:
        path: The file.
        must_be_signed: Who has signed it is checked; so it is where the settings require it.
        may_be_unsigned: It is not, whatever the settings require.

    Raises:
        NotFound: There is no such file.
        InvalidDocument: It is no bundle.
        Refused: It is not what was bundled, or signed; names the part.
    """
    from rtkit.packages import signing

    with tempfile.TemporaryDirectory(prefix="rtpkg-") as folder:
        os.mkdir(os.path.join(folder, _WHEELS))
        try:
            with zipfile.ZipFile(path) as archive:
                index, entries = _unpack(archive, path, folder)
                signature = archive.comment.partition(b" ")[2]
        except FileNotFoundError:
            raise NotFound(f"no such file: {path}") from None
        except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError) as error:
            raise InvalidDocument(f"{path} is no bundle, or damaged: {error}") from None
        except OSError as error:
            raise Refused(f"cannot read {path}: {error.strerror or error}") from None
        again = os.path.join(folder, "again")
        _pack(folder, entries, again, signature)
        if not filecmp.cmp(path, again, shallow=False):
            raise Refused(f"{path} is not what was bundled: between its parts")
        os.unlink(again)
        files = index["files"]
        packages = {
            name: {each: files[f"{_WHEELS}/{each}"] for each in wheels}
            for name, wheels in index["packages"].items()
        }
        with open(os.path.join(folder, _INDEX), "rb") as stream:
            data = stream.read()
        is_checked = must_be_signed or (signing.are_required() and not may_be_unsigned)
        signer = _signer(path, signature, data) if is_checked else ""
        with open(os.path.join(folder, _SYSTEM), "rb") as stream:
            yield Unpacked(stream.read(), os.path.join(folder, _WHEELS), packages, data, signer)


def _signer(path: str, signature: bytes, index: bytes) -> str:
    from rtkit.packages import signing

    if not signature:
        raise Refused(f"{path} is not signed (rtpkg sign signs it)")
    try:
        return signing.signer(signature, hashlib.sha256(index).digest(), signing.BUNDLE)
    except RtkitError as error:
        raise Refused(f"{path} {error}") from None


def _unpack(
    archive: zipfile.ZipFile, path: str, folder: str
) -> tuple[dict[str, Any], Sequence[str]]:
    """Write the files of a bundle into a folder; return its index and their names."""
    infos = archive.infolist()
    entries = [each.filename for each in infos]
    if len(infos) > _MOST_FILES or len({*entries}) < len(entries):
        raise Refused(f"{path} has a part twice, or more than {_MOST_FILES}")
    for info in infos:
        if not _NAME.fullmatch(info.filename) or info.external_attr != 0o100644 << 16:
            raise Refused(f"{path} has a part that no bundle has: {info.filename!r}")
        if info.compress_type != zipfile.ZIP_STORED or info.file_size != info.compress_size:
            raise Refused(f"{path} is not what was bundled: {info.filename} is compressed")
    if entries[:1] != [_INDEX] or infos[0].file_size > _LARGEST_INDEX:
        raise InvalidDocument(f"{path} is no bundle: no {_INDEX}")
    index = _index(archive, path)
    if {*entries[1:]} != {*index["files"]}:
        odd = sorted({*entries[1:]} ^ {*index["files"]})
        raise Refused(f"{path} is not what was bundled: {odd[0]} is too much, or missing")
    for name in entries:
        target = os.path.join(folder, name)
        try:
            with archive.open(name) as source, open(target, "xb") as copy:
                shutil.copyfileobj(source, copy, 1 << 20)
        except zipfile.BadZipFile:
            raise Refused(f"{path} is not what was bundled: {name} has other bytes") from None
        if name != _INDEX and _digest(target) != index["files"][name]:
            raise Refused(f"{path} is not what was bundled: {name} has another SHA-256")
    return index, entries


def _index(archive: zipfile.ZipFile, path: str) -> dict[str, Any]:
    try:
        data = archive.read(_INDEX)
    except zipfile.BadZipFile:
        data = b""
    if archive.comment.partition(b" ")[0] != hashlib.sha256(data).hexdigest().encode():
        raise Refused(f"{path} is not what was bundled: {_INDEX} has another SHA-256")
    try:
        found: dict[str, Any] = json.loads(data)
        files = found["files"]
        named = [f"{_WHEELS}/{each}" for wheels in found["packages"].values() for each in wheels]
        if found["schema"] != _SCHEMA or not {_SYSTEM, *named} <= {*files}:
            raise ValueError(found["schema"])
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise InvalidDocument(f"{path} is no bundle of this rtkit: {error}") from None
    return found
