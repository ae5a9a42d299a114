"""Checks the folders of this user: rights, space, stale files, stores set aside and waiting."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator

from rtkit.cli.managers.doctor import ERROR, NOTE, OK, WARNING, Diagnosis
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.link import places, secret
from rtkit.link.processes import state_of

_LEAST_SPACE = 50 << 20
_SOCKET = ".sock"
_HEARTBEATS = ".beats"
_DEAD = ("", "Z", "X")


def folders() -> Iterator[Diagnosis]:
    """Look at the folders of sockets and of logs, and at the secret."""
    for what, path in (("sockets", places.runtime_path()), ("logs", places.state_dir())):
        yield _folder(what, path)
    if places.state_dir() == places.runtime_path() + ".state":
        text = f"{places.usual_state_dir()} cannot be written: logs and what managers keep"
        text += f" are in {places.state_dir()}, which a restart of the machine may empty"
        yield Diagnosis("folders", NOTE, text, "choose another one with RTKIT_STATE_DIR")
    yield from _socket_length()
    yield _secret()


def _folder(what: str, path: str) -> Diagnosis:
    if not os.path.lexists(path):
        base = path
        while not os.path.exists(base):
            base = os.path.dirname(base)
        if os.path.isdir(base) and os.access(base, os.W_OK | os.X_OK):
            return Diagnosis("folders", OK, f"{what}: {path} (made at the first start)", "", path)
        text = f"folder of {what} cannot be made: {path} (no permission in {base})"
        variable = "RTKIT_STATE_DIR" if path == places.state_dir() else "RTKIT_RUNTIME_DIR"
        return Diagnosis("folders", ERROR, text, f"choose another one with {variable}", path)
    try:
        places.check_private(path)
    except Refused as error:
        text, _, cure = str(error).rpartition(" (")
        cure = cure.removesuffix(")").removeprefix("repair it with: ")
        return Diagnosis("folders", ERROR, text or str(error), cure, path)
    status = os.statvfs(path)
    free = status.f_bavail * status.f_frsize
    if free < _LEAST_SPACE:
        text = f"only {free >> 20} MiB are free in {path}: logs will be lost"
        return Diagnosis("folders", WARNING, text, "make room on that disk", path)
    return Diagnosis("folders", OK, f"{what}: {path}", "", path)


def is_trusted() -> bool:
    """Return whether the folder of sockets is safe to look for managers and services in."""
    try:
        places.runtime_dir()
    except Refused:
        return False
    return True


def _socket_length() -> Iterator[Diagnosis]:
    if not is_trusted():
        return
    path = places.data_socket(places.DEFAULT_MANAGER, 4_194_304)
    try:
        places.check_socket_length(path)
    except Refused as error:
        cure = "export RTKIT_RUNTIME_DIR=/tmp/rtkit-$(id -u)"
        yield Diagnosis("folders", ERROR, str(error), cure, places.runtime_dir())


def _secret() -> Diagnosis:
    path = secret.file()
    try:
        secret.read()
    except Unreachable:
        return Diagnosis("doors", OK, "no secret yet: it is made with the first TCP door", "", path)
    except RtkitError as error:
        cure = f"rm {places.quoted(path)}, then rtmgr restart"
        return Diagnosis("doors", ERROR, str(error), cure, path)
    return Diagnosis("doors", OK, "the secret of the TCP doors is in order", "", path)


def remains() -> Iterator[Diagnosis]:
    """Check for orphans of killed managers and processes: files, and slaves that live on."""
    try:
        entries = sorted(os.listdir(places.runtime_dir()))
    except OSError:
        return
    found = [*_orphans(entries), *_files_of_the_dead(entries)]
    yield from found or [Diagnosis("remains", OK, "nothing is left of processes that have ended")]


def _orphans(entries: list[str]) -> Iterator[Diagnosis]:
    names = {entry.removesuffix(_SOCKET) for entry in entries if entry.endswith(_SOCKET)}
    for name in sorted(names):
        if places.owner(name) is not None:
            continue
        living = sum(_lives(pid) for pid in _slaves(entries, name))
        quoted = places.quoted(name)
        if living:
            text = f"manager {name!r} was killed; slaves of it that live on: {living}"
            cure = f"rtmgr start {quoted} takes them over, rtmgr stop {quoted} ends them"
        else:
            text = f"manager {name!r} was killed and left its socket"
            cure = f"rtmgr start {quoted}, or rtmgr stop {quoted} to clear up"
        yield Diagnosis("remains", ERROR, text, cure, name)


def _files_of_the_dead(entries: list[str]) -> Iterator[Diagnosis]:
    dead: dict[str, list[str]] = {}
    for entry in entries:
        name, pid = _parts(entry)
        if pid is not None and places.owner(name) is None and not _lives(pid):
            dead.setdefault(name, []).append(entry)
    for name, files in dead.items():
        if f"{name}{_SOCKET}" in entries:
            continue
        text = f"files of processes that have ended: {', '.join(files)}"
        yield Diagnosis("remains", ERROR, text, f"rtmgr stop {places.quoted(name)}", name)


def _slaves(entries: list[str], name: str) -> set[int]:
    """Return the pids of processes that had heartbeats: slaves, not zygotes or attached ones."""
    parts = (_parts(entry) for entry in entries if entry.endswith(_HEARTBEATS))
    return {pid for owner, pid in parts if owner == name and pid is not None}


def _parts(entry: str) -> tuple[str, int | None]:
    """Return manager and pid of a file ``NAME.PID.KIND``."""
    rest, _, _kind = entry.rpartition(".")
    name, dot, pid = rest.rpartition(".")
    return (name, int(pid)) if dot and pid.isdigit() else (entry, None)


def _lives(pid: int) -> bool:
    return state_of(pid) not in _DEAD


_SUFFIX = ".desired"
_DUMP = re.compile(r"(.+)\.fault-\d+\.dump")
_ASIDE = re.compile(r"(.+)\.desired\.(damaged|unrestored)-\d+")


def stores() -> Iterator[Diagnosis]:
    """Look at the stores of all managers of this user, and at the dumps of their faults."""
    folder = places.state_dir()
    try:
        entries = sorted(os.listdir(folder))
    except OSError:
        return
    found = [*_aside(folder, entries), *_waiting(entries), *_dumped(folder, entries)]
    yield from found or [Diagnosis("stores", OK, "no manager has lost what it kept")]


def _aside(folder: str, entries: list[str]) -> Iterator[Diagnosis]:
    for entry in entries:
        match = _ASIDE.fullmatch(entry)
        if match is None:
            continue
        path = os.path.join(folder, entry)
        name, what = match.groups()
        text = f"a {what} state store of manager {name!r} was put aside: {path}"
        cure = f"look whether all is there (rtls), then rm {places.quoted(path)}*"
        yield Diagnosis("stores", WARNING if what == "damaged" else NOTE, text, cure, path)


def _waiting(entries: list[str]) -> Iterator[Diagnosis]:
    for entry in entries:
        name = entry.removesuffix(_SUFFIX)
        if name == entry or places.owner(name) is not None:
            continue
        quoted = places.quoted(name)
        text = f"manager {name!r} does not run, and has kept what it held"
        cure = f"rtmgr start {quoted} brings it back, rtmgr stop {quoted} forgets it"
        yield Diagnosis("stores", NOTE, text, cure, name)


def _dumped(folder: str, entries: list[str]) -> Iterator[Diagnosis]:
    for path, match in ((os.path.join(folder, each), _DUMP.fullmatch(each)) for each in entries):
        if match is not None:
            text = f"a fault in the work of manager {match[1]!r} was dumped: {path}"
            cure = f"rtmgr replay {places.quoted(path)} shows it; report it, then remove the file"
            yield Diagnosis("dumps", WARNING, text, cure, path)
