"""Caches byte code of modules: compiled once for all processes, kept where Python keeps it.

A hundred slaves of one module compile it once. What is kept is what Python's own import keeps
(``__pycache__``, checked by the hash of the source, PEP 552), so both use each other's.
"""

from __future__ import annotations

import marshal
from importlib.util import MAGIC_NUMBER, cache_from_source, source_hash
from types import CodeType

from rtkit.settings.kept_files import keep, kept

_CHECKED_HASH = (0b11).to_bytes(4, "little")


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
        keep(kept_in, head, marshal.dumps(code))
    return code


def _kept(path: str, head: bytes) -> CodeType | None:
    body = kept(path, head)
    if body is None:
        return None
    try:
        code = marshal.loads(body)
    except (ValueError, EOFError, TypeError):
        return None
    return code if isinstance(code, CodeType) else None
