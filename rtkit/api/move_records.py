"""Records of moves by request: of those under way, and of where they led components.

A record is a file beside the logs, ``MANAGER.NAME.move`` while the move is not done, ``.moved``
once the component has left that manager for another one.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING

from rtkit.errors import InvalidDocument, Malformed
from rtkit.rtc.names import Path, is_local_host

if TYPE_CHECKING:
    from rtkit.deployment.moving import MoveRecord

_SUFFIX, _MOVED = ".move", ".moved"


def _file(manager: str, instance: str, suffix: str = _SUFFIX) -> str:
    from rtkit.link.places import state_dir

    return os.path.join(state_dir(), f"{manager}.{instance}{suffix}")


def keep(record: MoveRecord) -> None:
    """Keep the record of a move that begins."""
    from rtkit.link.atomic import write_output
    from rtkit.link.places import make_private, state_dir
    from rtkit.rtc.serde import encode_text

    make_private(state_dir())
    file = _file(record.source.manager, record.facts.instance)
    write_output(encode_text(record).encode(), file)


def forget(record: MoveRecord) -> None:
    """Forget a move of which nothing is left to be done."""
    with suppress(FileNotFoundError):
        os.unlink(_file(record.source.manager, record.facts.instance))


def finish(record: MoveRecord) -> None:
    """Forget a move, but not where the component went, if it left its manager."""
    source, name = record.source.manager, record.facts.instance
    if source == record.manager:
        forget(record)
        return
    with suppress(FileNotFoundError):
        os.replace(_file(source, name), _file(source, name, _MOVED))
    forget_moved(record.manager, name)


def unfinished(path: Path, place: tuple[str, str]) -> MoveRecord | None:
    """Return the record of the same move, if one was begun and not finished.

    Raises:
        InvalidDocument: It is damaged.
    """
    from rtkit.deployment.moving import MoveRecord
    from rtkit.link.places import host_name
    from rtkit.rtc.serde import decode_text

    for file in _records(_SUFFIX):
        try:
            with open(file, encoding="utf-8") as stream:
                record = decode_text(MoveRecord, stream.read())
        except (OSError, ValueError, Malformed) as error:
            raise InvalidDocument(f"{file}: the record of a move is damaged: {error}") from error
        if (record.manager, record.slave) == place and _means(path, record, host_name()):
            return record
    return None


def _means(path: Path, record: MoveRecord, hostname: str) -> bool:
    """Return whether a path names the component of a move, where it was or where it goes."""
    from rtkit.deployment.moving import place_text

    host, *rest = path.elements or ("",)
    local = "localhost" if is_local_host(host, hostname) else host
    typed = "/".join((local, *rest))
    source, facts = record.source.manager, record.facts
    names = {*record.shown_at(source), *record.shown_at(record.manager)}
    leaf = f"{facts.instance}.rtc"
    for manager, process in ((source, facts.process), (record.manager, record.slave)):
        place = place_text(manager).removeprefix("/")
        names.add(f"{place}/{leaf}")
        if process not in ("", manager):
            names.add(f"{place}/{process}.mgr/{leaf}")
    return typed in names


def has_moved() -> bool:
    """Return whether anything is known to have been moved from its manager by request."""
    return next(_records(_MOVED), "") != ""


def last_move(manager: str, instance: str) -> MoveRecord | None:
    """Return the last of the moves that led a component away from a manager by request."""
    moves = _moves(manager, instance)
    return moves[-1] if moves and moves[-1].manager != manager else None


def forget_moves(manager: str, instance: str) -> None:
    """Forget where a component was moved from a manager: it is there again, or nowhere."""
    for move in _moves(manager, instance):
        forget_moved(move.source.manager, instance)


def forget_moved_to(manager: str) -> None:
    """Forget what was moved to a manager that has ended, or is given up: it lives nowhere."""
    for file in list(_records(_MOVED)):
        move = _read(file)
        if move is not None and move.manager == manager:
            os.unlink(file)


def forget_moved(manager: str, instance: str) -> None:
    """Forget the move of a component from a manager."""
    with suppress(FileNotFoundError):
        os.unlink(_file(manager, instance, _MOVED))


def _moves(manager: str, instance: str) -> list[MoveRecord]:
    """Return the moves of a component from a manager on, the first one first."""
    found: list[MoveRecord] = []
    while (move := _read(_file(manager, instance, _MOVED))) is not None and move not in found:
        found.append(move)
        manager = move.manager
    return found


def _read(file: str) -> MoveRecord | None:
    """Return the record of a move that is done; None if there is none that can be read."""
    from rtkit.deployment.moving import MoveRecord
    from rtkit.rtc.serde import decode_text

    with suppress(OSError, ValueError, Malformed), open(file, encoding="utf-8") as stream:
        return decode_text(MoveRecord, stream.read())
    return None


def _records(suffix: str) -> Iterator[str]:
    """Yield the files with records of moves, in order."""
    from rtkit.link.places import state_dir

    folder = state_dir()
    with suppress(FileNotFoundError):
        for name in sorted(os.listdir(folder)):
            if name.endswith(suffix):
                yield os.path.join(folder, name)
