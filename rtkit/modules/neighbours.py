"""Isolates the helper modules beside component modules: each folder imports its own.

Python knows a module by its name alone, so ``helper`` beside one component module would be taken
for the ``helper`` beside another one. While a module is imported, the files of its own folder go
before those of other folders of component modules; what was imported before goes before all.
"""

from __future__ import annotations

import os
import re
import sys
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from functools import partial
from itertools import takewhile
from operator import is_not
from types import ModuleType

from rtkit.modules.search import ModuleSource, file_of

_of_packages: dict[str, dict[str, ModuleType]] = {}
"""By folder of a module that is part of a package what was imported of that package, by name."""
_beside: dict[str, dict[str, ModuleType]] = {}
"""By folder what was imported from it, by the names of modules. It belongs to `sys.modules`."""


@contextmanager
def among_neighbours(real: str) -> Iterator[None]:
    """Let a module import what lies beside it, behind everything that has its name already."""
    folder = os.path.dirname(real)
    if folder not in _beside and folder in sys.path:
        yield  # it is Python's own, or somebody else's
        return
    is_known = folder in _beside
    own = _beside.setdefault(folder, {})
    others = [each for each in _beside if each != folder]
    sys.path[:] = [path for path in sys.path if path not in _beside] + [folder, *others]
    strange = {
        name: sys.modules.pop(name)
        for other in others
        for name, module in _beside[other].items()
        if sys.modules.get(name) is module and _is_in(folder, name)
    }
    sys.modules.update(own)
    last = None if is_known else next(reversed(sys.modules))
    try:
        yield
    finally:
        found = ((name, sys.modules.get(name)) for name in _since(last))
        own.update(
            (name, each) for name, each in found if each is not None and lies_in(folder, name, each)
        )
        sys.modules.update(strange)
        sys.path[:] = [path for path in sys.path if path not in _beside] + list(_beside)


@contextmanager
def among_its_own(source: ModuleSource) -> Iterator[None]:
    """Let a module import what lies beside it, and the other modules of its package."""
    if not source.package:
        with among_neighbours(source.real):
            yield
        return
    top = source.package.partition(".")[0]
    stem = os.path.basename(source.file).partition(".")[0]
    is_found = file_of(f"{source.package}.{stem}") == source.file
    folder = source.real  # of the outermost package
    for _ in source.package.split("."):
        folder = os.path.dirname(folder)
    with nullcontext() if is_found else among_neighbours(folder), among_neighbours(source.real):
        last = next(reversed(sys.modules))
        try:
            yield
        finally:
            own = _of_packages.setdefault(os.path.dirname(source.real), {})
            for others in list(_of_packages.values()):
                own |= {n: m for n, m in others.items() if n.partition(".")[0] == top}
            new = [name for name in _since(last) if name.partition(".")[0] == top]
            own |= {name: sys.modules[name] for name in new if name in sys.modules}


def disown(folder: str) -> None:
    """Know nothing more of a folder, as if no module of it had been imported."""
    _beside.pop(folder, None)


def _since(last: str | None) -> list[str]:
    """Return the names of the modules that came after that one, the newest first; None for all.

    A slave shares the others with its zygote. A look at each would copy the memory that they lie
    in, and take a slave with one component a fifth longer.
    """
    return list(takewhile(partial(is_not, last), reversed(sys.modules)))


def fingerprints(source: ModuleSource) -> dict[str, int]:
    """Return the CRC-32 of each file beside a module that it imports, as it is now.

    Also of those that these import; a package counts as a whole, also that which it is part of.
    """
    folder = os.path.dirname(source.real)
    own = _beside.get(folder, {})
    packaged = (each.__file__ for each in _of_packages.get(folder, {}).values())
    whole = {file: read(file) for file in packaged if file}
    found = {file: zlib.crc32(text) for file, text in whole.items() if text is not None}
    left, texts = {name.partition(".")[0] for name in own}, [source.text]
    while texts:
        text = texts.pop()
        named = {top for top in left if _imports(text, top)}
        left -= named
        for name, module in own.items():
            content = read(module.__file__ or "") if name.partition(".")[0] in named else None
            if content is not None and module.__file__:
                found[module.__file__] = zlib.crc32(content)
                texts.append(content)
    return found


def read(file: str) -> bytes | None:
    """Return what is in a file now, None if it cannot be read."""
    try:
        with open(file, "rb") as stream:
            return stream.read()
    except OSError:
        return None


def has_changed(files: Mapping[str, int]) -> bool:
    """Return whether one of these files has another CRC-32 now; unreadable ones have not."""
    now = ((read(file), crc) for file, crc in files.items())
    return any(text is not None and zlib.crc32(text) != crc for text, crc in now)


def _imports(source: bytes, name: str) -> bool:
    line = rb"^[ \t]*(?:from|import)\b[^\n]*\b" + re.escape(name.encode()) + rb"\b"
    return re.search(line, source, re.MULTILINE) is not None


def forget_neighbours(real: str) -> None:
    """Have what lies beside a module imported anew by the next one of its folder."""
    for known in (_beside, _of_packages):
        own = known.get(os.path.dirname(real), {})
        for name, module in own.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]
        own.clear()


def _is_in(folder: str, name: str) -> bool:
    """Return whether a folder has a module of that name, or the package that it is part of."""
    path = os.path.join(folder, name.partition(".")[0])
    return os.path.isfile(f"{path}.py") or os.path.isdir(path)


def lies_in(folder: str, name: str, module: ModuleType) -> bool:
    """Return whether a module was found in that folder, not below it by another path."""
    file = getattr(module, "__file__", None)
    path = os.path.join(folder, name.partition(".")[0])
    return isinstance(file, str) and (file == f"{path}.py" or file.startswith(f"{path}/"))
