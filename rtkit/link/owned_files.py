"""Files of the systems that a manager owns, beside its logs: one a system."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from rtkit.link import places

_FOLDER = "owned"


def folder() -> str:
    """Return the folder of these files."""
    return os.path.join(places.state_dir(), _FOLDER)


def path_of(manager: str, system: str) -> str:
    """Return the path of the file of a system."""
    return os.path.join(folder(), f"{manager}.{system.replace('/', '%2F')}")


def of_manager(manager: str) -> list[str]:
    """Return the paths of the files of all systems that a manager owns, in order."""
    try:
        names = os.listdir(folder())
    except FileNotFoundError:
        return []
    own = sorted(each for each in names if each.startswith(f"{manager}."))
    return [os.path.join(folder(), each) for each in own]


def read(path: str) -> str:
    """Return the text of such a file, empty if it is not there."""
    with suppress(FileNotFoundError), open(path, encoding="utf-8") as file:
        return file.read()
    return ""


def write(path: str, text: str) -> None:
    """Write such a file in one step."""
    with _held():
        _write(path, text)


def exchange(path: str, is_known: Callable[[str], bool], text: str) -> bool:
    """Write such a file if its text is still the known one; return whether it was."""
    with _held():
        if not is_known(read(path)):
            return False
        _write(path, text)
    return True


def remove(path: str) -> bool:
    """Remove such a file; return whether it was there."""
    try:
        with _held():
            os.unlink(path)
    except FileNotFoundError:
        return False
    return True


def _write(path: str, text: str) -> None:
    from rtkit.link.atomic import write_output

    write_output(text.encode(), path, mode=0o600)


@contextmanager
def _held() -> Iterator[None]:
    """Keep others, who write or remove such files as well, off the folder."""
    descriptor = os.open(places.make_private(folder()), os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)
