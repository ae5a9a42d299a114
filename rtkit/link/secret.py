"""Secret of a user: admits clients to the TCP endpoints of that user's managers.

It is made once, at random, and lies in a file that nobody else can read.

See decision 7.
"""

from __future__ import annotations

import os
import stat
from typing import NamedTuple

from rtkit import fault
from rtkit.errors import Refused, Unreachable
from rtkit.link import places

_NAME = "door.secret"
_BYTES = 32
_LARGEST = 4096


class Secret(NamedTuple):
    """User name and password."""

    user: str
    password: str

    def proof(self, nonce: str) -> str:
        """Return what shows that this side knows it, for one nonce."""
        import hmac

        return hmac.new(self.password.encode(), nonce.encode(), "sha256").hexdigest()


def file() -> str:
    """Return where the secret lies; its one line is ``user:password``."""
    return os.path.join(places.state_dir(), _NAME)


def make() -> str:
    """Make the secret if there is none yet, and return its file.

    Raises:
        Refused: It cannot be made, or others can read it.
    """
    places.make_private(places.state_dir())
    path = file()
    if not os.path.lexists(path):
        _write(path, f"rtkit-{os.getuid()}:{os.urandom(_BYTES).hex()}\n")
    _read(path)
    return path


def read() -> Secret:
    """Return the secret.

    Raises:
        Unreachable: There is none: no manager of this user ever had an endpoint.
        Refused: Others can read it, or it was tampered with.
    """
    path = file()
    try:
        user, _, password = _read(path).strip().partition(":")
    except FileNotFoundError:
        raise Unreachable(f"there is no secret of this user: {path}") from None
    if not user or not password:
        raise Refused(f"secret cannot be read; remove it, and restart the managers: {path}")
    return Secret(user, password)


def _write(path: str, text: str) -> None:
    """Lay a file down in one step; of several at once one wins."""
    draft = f"{path}.{os.getpid()}"
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(descriptor, "w", encoding="ascii") as stream:
            stream.write(text)
            stream.flush()
            os.fsync(descriptor)
        fault.point("secret.drafted")
        try:
            os.link(draft, path)
            fault.point("secret.linked")
        except FileExistsError:
            return
    except OSError as error:
        raise Refused(f"cannot keep the secret {path}: {error.strerror}") from error
    finally:
        os.unlink(draft)


def _read(path: str) -> str:
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise Refused(f"cannot read the secret {path}: {error.strerror}") from error
    with os.fdopen(descriptor, "rb") as stream:
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode) or status.st_uid != os.getuid():
            raise Refused(f"secret is no file of this user: {path}")
        if status.st_mode & 0o077:
            mode = f"{status.st_mode & 0o777:o}"
            raise Refused(f"secret can be read by others (mode {mode}); remove it: {path}")
        return stream.read(_LARGEST).decode("ascii", "replace")
