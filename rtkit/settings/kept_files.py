"""Keeps what was computed of a file in ``__pycache__`` beside it, as Python keeps byte code.

Where it cannot be kept, or is not to be (``PYTHONDONTWRITEBYTECODE``), nothing is lost but time.
"""

from __future__ import annotations

import contextlib
import os
import sys

from rtkit.errors import RtkitError
from rtkit.settings.reading import read_private


def kept(path: str, head: bytes) -> memoryview | None:
    """Return what is kept behind that head, unless a stranger could have written it."""
    try:
        whole = read_private(path)
    except RtkitError:
        return None
    return memoryview(whole)[len(head) :] if whole.startswith(head) else None


def keep(path: str, head: bytes, body: bytes) -> None:
    """Write it beside its place and move it there, so that nobody reads half of it."""
    if sys.dont_write_bytecode:
        return
    draft = f"{path}.{os.getpid()}"
    with contextlib.suppress(OSError):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW
        with open(os.open(draft, flags, 0o644), "wb") as file:
            try:
                file.write(head + body)
                os.replace(draft, path)
            except OSError:
                os.unlink(draft)
                raise
