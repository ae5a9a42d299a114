"""Write files whole or not at all."""

from __future__ import annotations

import os
import sys

from rtkit.errors import NotFound, Refused

STDOUT = "-"


def write_output(data: bytes, output: str, *, is_new: bool = False) -> None:
    """Write to a file, or to stdout for ``-``.

    A file that was there is replaced in one step and keeps its mode; a link stays a link. If it
    must be new, what is there is never touched.

    Raises:
        NotFound: It cannot be written; what was there before is unchanged.
        Refused: It must be new and is not.
    """
    if output == STDOUT:
        sys.stdout.buffer.write(data)
        return
    try:
        place = os.path.realpath(output)
        if os.path.exists(place) and not os.path.isfile(place):
            # A pipe or a terminal cannot be replaced; a folder says so itself.
            with open(place, "wb") as stream:
                stream.write(data)
        else:
            _replace(data, place, is_new=is_new)
    except FileExistsError as error:
        raise Refused(f"{output} is there already; --force replaces it") from error
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else str(error)
        raise NotFound(f"cannot write {output}: {why}") from error


def _replace(data: bytes, place: str, *, is_new: bool) -> None:
    import tempfile

    if is_new and os.path.lexists(place):
        raise FileExistsError
    descriptor, temporary = tempfile.mkstemp(prefix=".rtkit-", dir=os.path.dirname(place))
    try:
        with open(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, _mode(place))
        if not is_new or not _link(temporary, place):
            os.replace(temporary, place)
            temporary = ""
    finally:
        if temporary:
            os.unlink(temporary)


def _link(temporary: str, place: str) -> bool:
    """Give a file a second name, if nothing has that yet; return whether links can be made."""
    try:
        os.link(temporary, place)
    except FileExistsError:
        raise
    except OSError:
        return False
    return True


def _mode(place: str) -> int:
    try:
        return os.stat(place).st_mode & 0o7777
    except FileNotFoundError:
        mask = os.umask(0)
        os.umask(mask)
        return 0o666 & ~mask
