"""Reads wheels, and refuses those that could do harm; nothing of them is run.

What is refused: paths that leave the folder, links, control characters in names, more or larger
files than bounds allow, files that RECORD lacks or has with another SHA-256.
"""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import os
import stat
import zipfile
import zlib
from collections.abc import Iterator
from typing import NamedTuple

from packaging.metadata import InvalidMetadata, Metadata
from packaging.utils import InvalidWheelFilename, canonicalize_name, parse_wheel_filename

from rtkit.errors import InvalidDocument, Malformed, NotFound, Refused
from rtkit.modules.describing import describe
from rtkit.modules.search import SUFFIX, entry_points
from rtkit.rtc.profiles import TypeProfile

LARGEST_WHEEL = 1 << 29
"""Most bytes of a wheel, and a fourth of what may be in it."""
_MOST_FILES = 50_000
_DAMAGED = (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError, EOFError)
_PIECE = 1 << 20
SIGNATURE = ".jws"
"""Behind the name of RECORD, that of the file with its signature."""
_UNSIGNED = ("RECORD", f"RECORD{SIGNATURE}", "RECORD.p7s")


class Wheel(NamedTuple):
    """A wheel that was checked.

    Attributes:
        file: Its name, without folder.
        sha256: Of its bytes, in hexadecimal.
        requires: Requirements on other packages, as PEP 508 writes them.
        entries: Name, module and init function of each entry point of components.
        types: What the entry points offer, as their sources describe it.
        profiles: RTC profiles in it, by path.
        record: RECORD, with the SHA-256 of all files.
        signature: Of that, see `rtkit.packages.signing`; empty for none.
    """

    file: str
    name: str
    version: str
    sha256: str
    summary: str
    requires: tuple[str, ...]
    entries: tuple[tuple[str, str, str], ...]
    types: tuple[TypeProfile, ...]
    profiles: dict[str, bytes]
    record: bytes = b""
    signature: bytes = b""


def named(file: str) -> tuple[str, str]:
    """Return name and version that the name of a wheel's file says.

    Raises:
        Malformed: It is no such name.
    """
    if not (file.isascii() and file.isprintable()):
        raise Malformed(f"not the name of a wheel: {file!r}")
    try:
        name, version, _, _ = parse_wheel_filename(file)
    except InvalidWheelFilename as error:
        raise Malformed(f"not the name of a wheel: {error}") from None
    return str(name), str(version)


def read_wheel(path: str) -> Wheel:
    """Return what a wheel is.

    Raises:
        NotFound: There is no such file.
        Refused: It is not safe to unpack, or its bytes are not those of its RECORD; says why.
        InvalidDocument: It is no wheel.
    """
    file = path.rpartition("/")[2]
    name, version = named(file)
    try:
        if os.path.exists(path) and not os.path.isfile(path):
            raise Refused(f"cannot read {path}: it is no file")  # a pipe may have no end
        with open(path, "rb") as stream, zipfile.ZipFile(stream) as archive:
            _check_entries(archive, file)
            return _read(archive, file, name, version, _digest(stream))
    except FileNotFoundError:
        raise NotFound(f"no such file: {path}") from None
    except (*_DAMAGED, InvalidMetadata) as error:
        raise InvalidDocument(f"{file} is no wheel, or damaged: {error}") from None
    except OSError as error:
        raise Refused(f"cannot read {path}: {error.strerror}") from None


def _digest(stream: io.BufferedReader) -> str:
    stream.seek(0)
    return hashlib.file_digest(stream, "sha256").hexdigest()


def _check_entries(archive: zipfile.ZipFile, file: str) -> None:
    infos = archive.infolist()
    names = [each.filename for each in infos]
    if len(names) > _MOST_FILES or sum(each.file_size for each in infos) > 4 * LARGEST_WHEEL:
        raise Refused(
            f"{file} unpacks to more than {_MOST_FILES} files, or {4 * LARGEST_WHEEL >> 20} MiB"
        )
    if len(set(names)) < len(names):
        raise Refused(f"{file} has a file twice")
    for each in infos:
        name = each.filename
        if not name.isprintable() or "\\" in name:
            raise Refused(f"{file} has a file with control characters in its name: {name!r}")
        if name.startswith("/") or ":" in name or ".." in name.split("/"):
            raise Refused(f"{file} has a path that leaves its folder: {name}")
        kind = stat.S_IFMT(each.external_attr >> 16)
        if kind not in (0, stat.S_IFREG, stat.S_IFDIR):
            raise Refused(f"{file} has a link, or a special file: {name}")


def _read(archive: zipfile.ZipFile, file: str, name: str, version: str, sha256: str) -> Wheel:
    tops = {each.partition("/")[0] for each in archive.namelist()}
    infos = [each for each in tops if each.endswith(".dist-info")]
    if len(infos) != 1:
        raise InvalidDocument(f"{file} is no wheel: {len(infos)} folders .dist-info")
    metadata = _metadata(archive, f"{infos[0]}/METADATA", file)
    if canonicalize_name(metadata.name) != name or str(metadata.version) != version:
        raise Refused(f"{file} calls itself {metadata.name} {metadata.version} inside")
    _check_record(archive, infos[0], file)
    text = _text(archive, f"{infos[0]}/entry_points.txt", file)
    entries = tuple(entry_points(text))
    profiles = {
        each: archive.read(each)
        for each in archive.namelist()
        if each.endswith((".xml", ".yaml", ".json")) and ".dist-info/" not in each
    }
    return Wheel(
        file=file,
        name=name,
        version=version,
        sha256=sha256,
        summary=metadata.summary or "",
        requires=tuple(map(str, metadata.requires_dist or ())),
        entries=entries,
        types=tuple(_types(archive, entries)),
        profiles=profiles,
        record=archive.read(f"{infos[0]}/RECORD"),
        signature=_text(archive, f"{infos[0]}/RECORD{SIGNATURE}", file).encode(),
    )


def _text(archive: zipfile.ZipFile, path: str, file: str) -> str:
    try:
        return archive.read(path).decode("utf-8")
    except KeyError:
        return ""
    except UnicodeDecodeError:
        raise InvalidDocument(f"{file} is no wheel: {path} is no text") from None


def _metadata(archive: zipfile.ZipFile, path: str, file: str) -> Metadata:
    try:
        return Metadata.from_email(_text(archive, path, file), validate=False)
    except (InvalidMetadata, ExceptionGroup, ValueError) as error:
        raise InvalidDocument(f"{file} is no wheel: {path}: {error}") from None


def _check_record(archive: zipfile.ZipFile, info: str, file: str) -> None:
    text = _text(archive, f"{info}/RECORD", file)
    rows = {row[0]: row[1] for row in csv.reader(io.StringIO(text)) if len(row) == 3}
    unsigned = {f"{info}/{each}" for each in _UNSIGNED}
    for path in archive.namelist():
        if path.endswith("/") or path in unsigned:
            continue
        digest = hashlib.sha256()
        with archive.open(path) as stream:
            while piece := stream.read(_PIECE):
                digest.update(piece)
        found = base64.urlsafe_b64encode(digest.digest()).decode().rstrip("=")
        if path not in rows:
            raise Refused(f"{file}: RECORD has no {path}")
        if rows[path] != f"sha256={found}":
            raise Refused(f"{file}: {path} is not what RECORD says (its SHA-256 is another one)")


def _types(
    archive: zipfile.ZipFile, entries: tuple[tuple[str, str, str], ...]
) -> Iterator[TypeProfile]:
    for _, module, init in entries:
        path = f"{module.replace('.', '/')}{SUFFIX}"
        try:
            source = archive.read(path)
        except KeyError:
            continue
        try:
            found = describe(source, path, init, module.rpartition(".")[0])
        except Malformed:
            continue  # known only when it runs; `objections` says so where it matters
        yield from (each.type for each in found or ())


def objections(wheel: Wheel) -> list[str]:
    """Return all that speaks against a wheel as a package of components."""
    from rtkit.errors import RtkitError
    from rtkit.profile.read import read_profile
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile_tools.validation import may_be_profile, validated

    if not wheel.entries:
        return [f"{wheel.file} has no entry point of the group rtkit.components"]
    found: list[str] = []
    described: set[tuple[str, str, str]] = set()
    for path, data in wheel.profiles.items():
        if not may_be_profile(data):
            continue
        checked = validated(data, path).only_errors()
        found += [f"{path}:{each.line}: {each.text}" for each in checked.findings]
        try:
            profile = read_profile(data, path).profile
        except RtkitError:
            continue
        if isinstance(profile, RtcProfile) and (info := profile.basic_info) is not None:
            described.add((info.vendor, info.name, info.version))
    for name, module, _ in wheel.entries:
        if not any(each.type_name in (name, module.rpartition(".")[2]) for each in wheel.types):
            found.append(f"entry point {name}: {module} offers no type that its source describes")
    for each in wheel.types:
        if (each.vendor, each.type_name, each.version) not in described:
            found.append(f"type {each.id} has no RTC profile in the package")
    return found
