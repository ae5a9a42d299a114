"""Wheels of rtkit and all it needs, chosen for the Python and the machine of another host.

They are kept in the cache folder, a folder for each kind of host, and fetched there by pip.
"""

from __future__ import annotations

import base64
import fcntl
import hashlib
import importlib.metadata
import json
import os
import re
import shutil
import tempfile
import zipfile
from collections.abc import Collection, Sequence
from functools import lru_cache
from typing import NamedTuple

from rtkit.errors import NotFound, Refused, Unreachable
from rtkit.hosts.far_side import FarSide
from rtkit.link.places import check_trusted
from rtkit.packages.tools import pip
from rtkit.packages.wheel_target import WheelKind, WheelTarget
from rtkit.version import __version__

_SUMS = "digests.json"
_ASIDES = ("note:", "hint:", "[notice]")
"""Lines of pip that give no reason begin so."""


def cache_folder() -> str:
    """Return the folder of wheels in the user's cache."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return os.path.join(base, "rtkit", "wheels")


class WheelSet(NamedTuple):
    """Wheels that make a version of rtkit.

    Attributes:
        id: Version, with a fingerprint of what is in the wheels.
        files: Paths by name.
        digests: SHA-256 by name, in hexadecimal.
        own: Name of the one of rtkit, made here: no index has the same.
    """

    id: str
    files: dict[str, str]
    digests: dict[str, str]
    own: str = ""

    @property
    def versions(self) -> dict[str, str]:
        """Version of each, by canonical name."""
        from packaging.utils import parse_wheel_filename

        return {name: str(version) for name, version, *_ in map(parse_wheel_filename, self.files)}


def wheels_for(kind: WheelKind, extras: tuple[str, ...] = ()) -> WheelSet:
    """Return the wheels for a kind of host; they are fetched unless they are there, undamaged.

    With `extras` come what these need, too.
    Who asks at the same time, in this command or in another, waits for those that are fetched.

    Raises:
        NotFound: There is no wheel of a package for that kind, and its name.
        Unreachable: They are not there, and the index of pip does not answer.
        Refused: pip cannot be run here, or others may write in the cache folder.
    """
    cache = cache_folder()
    os.makedirs(cache, mode=0o700, exist_ok=True)
    check_trusted(cache)
    with open(os.path.join(cache, "lock"), "w", encoding="ascii") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # not lockf: threads exclude each other, too
        return _wheels_in(cache, kind, extras)


@lru_cache
def _wheels_in(cache: str, kind: WheelKind, extras: tuple[str, ...]) -> WheelSet:
    own = own_wheel()
    needs = requirements(extras)
    key = hashlib.sha256("\n".join(sorted(needs)).encode()).hexdigest()[:8]
    folder = os.path.join(cache, f"{kind.name}-{key}")
    digests = _digests(folder)
    if digests is None:
        shutil.rmtree(folder, ignore_errors=True)
        digests = _fetch(kind, needs, folder)
    files = {name: os.path.join(folder, name) for name in digests}
    files[os.path.basename(own)] = own
    digests |= {os.path.basename(own): _digest(own)}
    whole = hashlib.sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()
    return WheelSet(f"{__version__}-{whole[:12]}", files, digests, os.path.basename(own))


def target_of(look: FarSide, extras: tuple[str, ...], *, is_bare: bool) -> WheelTarget:
    """Return what packages for a host are chosen for; a bare one gets this rtkit before them.

    Raises:
        RtkitError: See `wheels_for`; or rtkit cannot be made on the host.
    """
    if not is_bare:
        return look.target
    if obstacles := look.obstacles(needs_room=not look.current):
        raise Refused("; ".join(obstacles))
    return WheelTarget(look.kind, wheels_for(look.kind, extras).versions)


def requirements(extras: Collection[str] = ()) -> list[str]:
    """Return what rtkit needs, and what some of its extras do."""
    needs = [each.partition(";") for each in importlib.metadata.requires("rtkit") or []]
    return [
        need + mark + condition if "extra ==" not in condition else need
        for need, mark, condition in needs
        if "extra ==" not in condition or condition.rpartition("==")[2].strip(" \"'") in extras
    ]


def _digests(folder: str) -> dict[str, str] | None:
    """Return the SHA-256 of the wheels that were fetched, None if they are not all as they were."""
    try:
        known = dict(json.loads(_content(os.path.join(folder, _SUMS)) or "null"))
        found = {name: _digest(os.path.join(folder, name)) for name in known}
    except (OSError, ValueError, TypeError):
        return None
    return known if found == known else None


def _fetch(kind: WheelKind, needs: Sequence[str], folder: str) -> dict[str, str]:
    """Fetch the wheels into a new folder, which is there when all are; return their SHA-256."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(folder)) as draft:
        target = os.path.join(draft, "wheels")
        os.mkdir(target)
        words = ("-q", "--retries", "1", "-d", target, *kind.pip_options(), *needs)
        _, text = pip("download", *words, is_isolated=False)  # the index is the user's own
        if "connection broken by" in text:
            raise Unreachable(f"no wheels for {kind.name}: the index that pip asks does not answer")
        if text:
            raise NotFound(f"no wheels for {kind.name}: {_reason(text)}")
        digests = {name: _digest(os.path.join(target, name)) for name in sorted(os.listdir(target))}
        with open(os.path.join(target, _SUMS), "w", encoding="utf-8") as file:
            json.dump(digests, file)
        os.rename(target, folder)
    return digests


def _reason(text: str) -> str:
    found = re.findall(r"No matching distribution found for (.*)", text)
    lines = [each for each in text.splitlines() if each and not each.startswith(_ASIDES)]
    return f"none of {', '.join(dict.fromkeys(found))}" if found else lines[-1]


def own_wheel() -> str:
    """Return the wheel of this rtkit, made of what is installed.

    Raises:
        Refused: It cannot be made.
    """
    distribution = importlib.metadata.distribution("rtkit")
    origin = json.loads(distribution.read_text("direct_url.json") or "{}")
    folder = os.path.join(cache_folder(), "rtkit")
    os.makedirs(folder, mode=0o700, exist_ok=True)
    if origin.get("dir_info", {}).get("editable"):
        return _built(origin["url"].removeprefix("file://"), folder)
    return _repacked(distribution, folder)


def _repacked(distribution: importlib.metadata.Distribution, folder: str) -> str:
    """Return a wheel of the installed files: their list is what a wheel's is."""
    tags = re.findall(r"^Tag: (.*)$", distribution.read_text("WHEEL") or "", re.MULTILINE)
    name = f"rtkit-{distribution.version}-{tags[0] if tags else 'py3-none-any'}.whl"
    inside = [
        (str(each), each.locate().read_bytes())  # type: ignore[attr-defined]
        for each in distribution.files or ()
        if not str(each).startswith("..")
        and not str(each).endswith((".pyc", "/RECORD", "/INSTALLER", "/REQUESTED", "_url.json"))
    ]
    record = next(str(each) for each in distribution.files or () if str(each).endswith("/RECORD"))
    lines = [f"{path},sha256={_record_digest(data)},{len(data)}" for path, data in inside]
    path = os.path.join(folder, name)
    with (
        tempfile.NamedTemporaryFile(dir=folder, delete=False) as draft,
        zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for each, data in sorted(inside):
            archive.writestr(zipfile.ZipInfo(each, (2020, 1, 1, 0, 0, 0)), data)
        archive.writestr(record, "\n".join([*lines, f"{record},,", ""]))
    os.replace(draft.name, path)
    return path


def _built(source: str, folder: str) -> str:
    """Return a wheel that is built of a folder of sources, unless they are as they were."""
    mark = os.path.join(folder, "built")
    state = _state_of(source)
    known = sorted(each for each in os.listdir(folder) if each.endswith(".whl"))
    if known and _content(mark) == state:
        return os.path.join(folder, known[0])
    with tempfile.TemporaryDirectory(dir=folder) as draft:
        _, text = pip("wheel", "-q", "--no-deps", "-w", draft, source, is_isolated=False)
        if text:
            raise Refused(f"no wheel of {source}: {_reason(text)}")
        (made,) = os.listdir(draft)
        for each in known:
            os.unlink(os.path.join(folder, each))
        shutil.move(os.path.join(draft, made), os.path.join(folder, made))
    with open(mark, "w", encoding="utf-8") as file:
        file.write(state)
    return os.path.join(folder, made)


def _content(path: str) -> str:
    try:
        with open(path, encoding="utf-8") as file:
            return file.read()
    except FileNotFoundError:
        return ""


def _state_of(source: str) -> str:
    """Return a text that changes with the sources."""
    digest = hashlib.sha256(source.encode())
    for top in ("rtkit", "schemas", "examples", "profiles", "pyproject.toml"):
        for folder, names, files in os.walk(os.path.join(source, top)):
            names[:] = sorted(each for each in names if each != "__pycache__")
            for each in sorted(files):
                status = os.stat(os.path.join(folder, each))
                digest.update(f"{folder}/{each} {status.st_size} {status.st_mtime_ns}".encode())
    return digest.hexdigest()


def _digest(path: str) -> str:
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


def _record_digest(data: bytes) -> str:
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")
