"""Caches byte code of modules: compiled once for all processes, kept where Python keeps it.

A hundred slaves of one module compile it once. What is kept is what Python's own import keeps
(``__pycache__``, checked by the hash of the source, PEP 552), so both use each other's. Where it
cannot be kept, or is not to be (``PYTHONDONTWRITEBYTECODE``), nothing is lost but time.
"""

from __future__ import annotations

import contextlib
import marshal
import os
import sys
from importlib.util import MAGIC_NUMBER, cache_from_source, source_hash
from types import CodeType

from rtkit.errors import RtkitError
from rtkit.settings.reading import read_private

_CHECKED_HASH = (0b11).to_bytes(4, "little")
_HEAD = len(MAGIC_NUMBER) + len(_CHECKED_HASH) + 8


def code_of(file: str, source: bytes) -> CodeType:
    """Return the code of a module with this very source.

    Raises:
        SyntaxError: It is none.
        ValueError: It is no text.
    """
    kept_in = cache_from_source(file)
    head = MAGIC_NUMBER + _CHECKED_HASH + source_hash(source)
    code = _kept(kept_in, head)
    if code is None or code.co_filename != file:
        code = compile(source, file, "exec", dont_inherit=True)
        if not sys.dont_write_bytecode:
            _keep(kept_in, head + marshal.dumps(code))
    return code


def _kept(path: str, head: bytes) -> CodeType | None:
    """Return what is kept of that head, unless a stranger could have written it."""
    try:
        whole = read_private(path)
    except RtkitError:
        return None
    if not whole.startswith(head):
        return None
    try:
        code = marshal.loads(memoryview(whole)[_HEAD:])
    except (ValueError, EOFError, TypeError):
        return None
    return code if isinstance(code, CodeType) else None


def _keep(path: str, whole: bytes) -> None:
    """Write it beside its place and move it there, so that nobody reads half of it."""
    draft = f"{path}.{os.getpid()}"
    with contextlib.suppress(OSError):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC | os.O_NOFOLLOW
        with open(os.open(draft, flags, 0o644), "wb") as file:
            try:
                file.write(whole)
                os.replace(draft, path)
            except OSError:
                os.unlink(draft)
                raise
