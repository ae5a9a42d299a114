"""Finds system profiles in the folders that the user has granted, and nothing outside of them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from itertools import islice

from rtkit.errors import NotFound, Refused

_ENDINGS = (".xml", ".yaml", ".yml", ".json")
_MOST = 1000
_HEAD = 4096
_FLAGS = os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW
_FOLDER = _FLAGS | os.O_DIRECTORY


def profiles_in(folders: Sequence[str], endings: Sequence[str] = _ENDINGS) -> list[str]:
    """Return the paths of files whose names have some endings, 1000 at most."""
    return sorted(islice(_files(folders, tuple(endings)), _MOST))


def profiles_of(
    folders: Sequence[str], may_be: Callable[[bytes], bool], most: int = _MOST
) -> list[str]:
    """Return the paths of files that may be profiles of a kind, by how they begin.

    Args:
        folders: Those granted.
        may_be: Tells that of the first bytes of a file.
        most: So many are returned at most.
    """
    return sorted(islice((each for each in _files(folders, _ENDINGS) if _is(each, may_be)), most))


def _is(path: str, may_be: Callable[[bytes], bool]) -> bool:
    try:
        with open(path, "rb", opener=no_link) as stream:
            return may_be(stream.read(_HEAD))
    except OSError:
        return False  # it went, or may not be read: then it cannot be opened either


def no_link(path: str, flags: int) -> int:
    """Open a file, and no link, as `open` wants its `opener`."""
    return os.open(path, flags | _FLAGS | os.O_NONBLOCK)


def _files(folders: Sequence[str], endings: tuple[str, ...]) -> Iterator[str]:
    """Yield the paths of files; those of a folder within another one that is granted, once."""
    found = set[str]()
    for folder in folders:
        for at, below, names in os.walk(folder):
            below[:] = sorted(each for each in below if not each.startswith("."))
            for name in sorted(names):
                path = os.path.join(at, name)
                if name.endswith(endings) and path not in found and not os.path.islink(path):
                    found.add(path)
                    yield path


def granted(
    path: str, folders: Sequence[str], *, is_new: bool = False, endings: Sequence[str] = _ENDINGS
) -> str:
    """Return a path after a look that it is a file in one of the folders, whatever links say.

    Each part is opened relative to the folder above it, and no link is followed.

    Args:
        path: As `profiles_in` has it, or of a file that is to be written.
        folders: Those granted, without links.
        is_new: It need not be there.
        endings: Its name has one of these.

    Raises:
        Refused: It is in no folder that is granted, leads through a link, or is no file.
        NotFound: It is not there.
    """
    folder, parts = _split(path, folders)
    if not path.endswith(tuple(endings)):
        raise Refused(f"{path}: the name is to end in {', '.join(endings)}")
    try:
        _look(folder, parts)
    except FileNotFoundError:
        if not is_new:
            raise NotFound(f"No such file: {path}") from None
    except OSError as error:
        raise Refused(f"{path}: {error.strerror}; links are not followed") from None
    return path


def granted_folder(path: str, folders: Sequence[str]) -> str:
    """Return a path after a look that it is a granted folder or one below, which may be new.

    Raises:
        Refused: It is in no folder that is granted, leads through a link, or is a file.
    """
    if path in folders:
        return path
    folder, parts = _split(path, folders)
    at = os.open(folder, _FOLDER)
    try:
        for part in parts:
            below = os.open(part, _FOLDER, dir_fd=at)
            os.close(at)
            at = below
    except FileNotFoundError:
        pass
    except OSError as error:
        raise Refused(f"{path}: {error.strerror}; links are not followed") from None
    finally:
        os.close(at)
    return path


def _split(path: str, folders: Sequence[str]) -> tuple[str, list[str]]:
    """Return the granted folder that holds a path, and the names below it.

    Raises:
        Refused: There is none.
    """
    folder = next((each for each in folders if path.startswith(os.path.join(each, ""))), None)
    parts = path[len(os.path.join(folder, "")) :].split("/") if folder is not None else []
    if folder is None or any(each in ("", ".", "..") for each in parts) or "\0" in path:
        raise Refused(f"{path!r} is in no folder that this page was granted (--root)")
    return folder, parts


def _look(folder: str, parts: Sequence[str]) -> None:
    at = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        for part in parts[:-1]:
            below = os.open(part, _FOLDER, dir_fd=at)
            os.close(at)
            at = below
        with closing(os.fdopen(os.open(parts[-1], _FLAGS | os.O_NONBLOCK, dir_fd=at))):
            return
    finally:
        os.close(at)
