"""Folder of keys: certificates of this user and, where the CA is, those that it has issued.

Nobody else can read what lies in it: a key that others could read is refused.
"""

from __future__ import annotations

import os
import stat

from rtkit.errors import NotFound, Refused
from rtkit.link import places

CA_CERTIFICATE = "ca.crt"
CA_KEY = "ca.key"
CERTIFICATE = "own.crt"
KEY = "own.key"
REVOKED = "revoked.crl"
ISSUED = "issued"
VARIABLE = "RTKIT_KEYS"
_LARGEST = 1 << 22


def path() -> str:
    """Return the folder: ``RTKIT_KEYS``, else ``rtkit/keys`` in the configuration folder."""
    base = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")
    return os.path.abspath(os.environ.get(VARIABLE) or os.path.join(base, "rtkit", "keys"))


def file(name: str) -> str:
    """Return the path of a file in it."""
    return os.path.join(path(), name)


def opened(name: str) -> int:
    """Open a file of the folder, or at a path, to read; the open file itself is checked.

    Raises:
        NotFound: There is none; tells what makes it.
        Refused: It is no file of this user; others can read a key, or write a certificate.
    """
    place = os.path.join(path(), name)
    try:
        descriptor = os.open(place, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        hint = "rtkeys init makes a CA, rtkeys issue a certificate for another host"
        raise NotFound(f"no keys: {place} is not there ({hint})") from None
    except OSError as error:
        raise Refused(f"cannot read {place}: {error.strerror}") from error
    status = os.fstat(descriptor)
    others = 0o077 if os.path.basename(name) in (KEY, CA_KEY) else 0o022
    why = ""
    if not stat.S_ISREG(status.st_mode) or status.st_uid not in (os.getuid(), 0):
        why = f"no file of this user: {place}"
    elif status.st_mode & others:
        what = "read" if others == 0o077 else "write"
        mode = f"{status.st_mode & 0o777:o}"
        why = f"others can {what} it (mode {mode}): {place} (chmod 600 if none has, else revoke)"
    if why:
        os.close(descriptor)
        raise Refused(why)
    return descriptor


def read(name: str) -> bytes:
    """Return the content of a file of the folder, as `opened` does."""
    with os.fdopen(opened(name), "rb") as stream:
        return stream.read(_LARGEST)


def make(place: str) -> None:
    """Make a folder for this user alone, or check that it is so.

    Raises:
        Refused: It cannot be made, is not ours, or is open to others.
    """
    places.make_private(place)


def write(place: str, data: bytes, *, is_new: bool = True) -> None:
    """Write a file for this user alone, in one step.

    Raises:
        Refused: It is there already, and was to be new.
    """
    draft = f"{place}.{os.getpid()}"
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(descriptor)
        if not is_new:
            os.rename(draft, place)
            return
        try:
            os.link(draft, place)
        except FileExistsError:
            raise Refused(f"is there already, and never overwritten: {place}") from None
    finally:
        if os.path.lexists(draft):
            os.unlink(draft)
