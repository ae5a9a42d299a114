"""Imports for the modules of one folder: OpenRTM's names, what IDL files declare, siblings.

A module that is run here has an `__import__` of its own among its built-in functions. So the names
that it imports are there for it and for its siblings, and for nothing else in the process; two
folders may have different modules of one name. Everything else is imported as usual.
"""

from __future__ import annotations

import builtins
import os
import sys
import zlib
from collections.abc import Iterator, Mapping
from importlib.util import resolve_name
from threading import RLock
from types import ModuleType
from typing import Any

from rtkit.openrtm.corba.definitions import FolderDefinitions
from rtkit.openrtm.loading.names import own_stub, shared_module
from rtkit.openrtm.migrate.source import Compile, compiled

_PREFIX = "rtkit_module_"
_FORMER = {
    "basestring": str,
    "long": int,
    "raw_input": input,
    "unichr": chr,
    "unicode": str,
    "xrange": range,
}
"""Built-in functions of Python 2 that old components still name."""
_folders: dict[str, ComponentFolder] = {}


def folder_of(file: str, compile_source: Compile) -> ComponentFolder:
    """Return the folder of a file; the same one each time."""
    path = os.path.dirname(os.path.abspath(file))
    known = _folders.get(path)
    if known is None:
        known = _folders[path] = ComponentFolder(path, compile_source)
    return known


def forget_folder(path: str) -> None:
    """Have what lies in a folder imported anew by its next module."""
    folder = _folders.pop(path, None)
    if folder is not None:
        for name in folder.names:
            sys.modules.pop(name, None)


class ComponentFolder:
    """A folder of component modules, and what these have imported from it.

    Attributes:
        path: Where it is.
        names: Names in `sys.modules` of the siblings that were imported; no `import` says them.
        files: CRC-32 of each file beside a module that was read, by path.
    """

    def __init__(self, path: str, compile_source: Compile) -> None:
        self.path = path
        self.names: list[str] = []
        self.files: dict[str, int] = {}
        self._compile = compile_source
        self._modules: dict[str, ModuleType] = {}
        self._places = [path]
        self._usual_path: frozenset[str] = frozenset()
        self._lock = RLock()
        self._definitions = FolderDefinitions(path, self.read)
        own = {"__import__": self._import, "open": self._open}
        self._builtins = {**vars(builtins), **_FORMER, **own}

    def run(self, module: ModuleType, text: bytes) -> None:
        """Run a module; what it adds to `sys.path` of its project counts for this folder alone.

        Raises:
            BaseException: Whatever the module raises.
        """
        file = str(module.__file__)
        before = [*sys.path]
        self._usual_path = frozenset(before)
        vars(module)["__builtins__"] = self._builtins
        try:
            exec(compiled(file, text, self._compile), vars(module))
        finally:
            self._places += [each for each in self._added() if each not in self._places]
            sys.path[:] = [each for each in sys.path if each in before or not self._is_near(each)]
            self._usual_path = frozenset()

    def read(self, file: str) -> bytes:
        """Return what is in a file of this folder, and note that it was read."""
        with open(file, "rb") as stream:
            text = stream.read()
        self.files[file] = zlib.crc32(text)
        return text

    def _added(self) -> Iterator[str]:
        """Yield places nearby that a running module has added to Python's search path."""
        for each in sys.path if self._usual_path else ():
            if each not in self._usual_path and self._is_near(each):
                yield os.path.normpath(os.path.join(self.path, each))

    def _is_near(self, place: str) -> bool:
        """Return whether a place belongs to the project; others are libraries for all."""
        project = os.path.dirname(self.path)
        whole = os.path.normpath(os.path.join(self.path, place))
        return not os.path.isabs(place) or f"{whole}/".startswith(f"{project.rstrip('/')}/")

    def _open(self, file: Any, mode: str = "r", *args: Any, **named: Any) -> Any:
        """Open a file; one to read by a relative path lies beside the module, if nowhere else.

        Such a component is started by hand in its folder, a manager runs elsewhere.
        """
        if isinstance(file, str) and "r" in mode and not os.path.exists(file):
            beside = os.path.join(self.path, file)
            file = beside if os.path.exists(beside) else file
        return open(file, mode, *args, **named)

    def _import(
        self,
        name: str,
        globals: Mapping[str, Any] | None = None,
        locals: Mapping[str, Any] | None = None,
        fromlist: tuple[str, ...] | None = (),
        level: int = 0,
    ) -> Any:
        full = resolve_name("." * level + name, _package(globals)) if level else name
        with self._lock:
            top = self.find(full.partition(".")[0])
            if top is None:
                try:
                    return builtins.__import__(name, globals, locals, fromlist or (), level)
                except ModuleNotFoundError as error:
                    self._explain(error, full.partition(".")[0], globals)
                    raise
            leaf = self._walk(full)
            for each in fromlist or ():
                if each != "*" and not hasattr(leaf, each):
                    self.find(f"{full}.{each}")
        return leaf if fromlist else top

    def _explain(
        self, error: ModuleNotFoundError, name: str, scope: Mapping[str, Any] | None
    ) -> None:
        """Have an error tell of IDL files, where the module would come of one."""
        file = str((scope or {}).get("__file__", ""))
        if error.name == name and os.path.isfile(file):
            why = self._definitions.why_missing(name, self.read(file))
            error.msg = why or error.msg

    def _walk(self, full: str) -> ModuleType:
        names = full.split(".")
        for at in range(1, len(names) + 1):
            part = ".".join(names[:at])
            found = self.find(part)
            if found is None:
                raise ModuleNotFoundError(f"No module named {part!r}", name=part)
        assert found is not None
        return found

    def find(self, full: str) -> ModuleType | None:
        """Return a module of that name that belongs to this folder; None for all others."""
        known = self._modules.get(full)
        if known is not None:
            return known
        outer, _, last = full.rpartition(".")
        if not outer and last in sys.stdlib_module_names:
            return None
        parent = self._modules.get(outer)
        found = shared_module(full) or self._definitions.module(full)
        if found is None and isinstance(getattr(parent, last, None), ModuleType):
            found = getattr(parent, last)
        if found is not None:
            self._modules[full] = found
        else:
            found = self._sibling(full, parent) or self._elsewhere(full)
        if found is not None and parent is not None and last not in vars(parent):
            setattr(parent, last, found)
        return found

    def _elsewhere(self, full: str) -> ModuleType | None:
        found = own_stub(full) or self._definitions.module_elsewhere(full)
        if found is not None:
            self._modules[full] = found
        return found

    def _sibling(self, full: str, parent: ModuleType | None) -> ModuleType | None:
        places = [*self._places, *self._added()]
        if "." in full:
            places = list(getattr(parent, "__path__", ()))
        for place in places:
            path = os.path.join(place, full.rpartition(".")[2])
            inner = os.path.join(path, "__init__.py")
            if os.path.isfile(inner):
                return self._load(full, inner, [path])
            if os.path.isfile(f"{path}.py"):
                return self._load(full, f"{path}.py", None)
            if parent is not None and os.path.isdir(path):  # a folder in a package is part of it
                return self._portion(full, path)
        return None

    def _portion(self, full: str, path: str) -> ModuleType:
        module = ModuleType(full)
        module.__path__ = [path]
        self._modules[full] = module
        return module

    def _load(self, full: str, file: str, path: list[str] | None) -> ModuleType:
        name = _PREFIX + "".join(c if c.isalnum() else "_" for c in file)
        module = ModuleType(name)
        module.__file__ = file
        module.__package__ = full if path else full.rpartition(".")[0]
        if path:
            module.__path__ = path
        vars(module)["__builtins__"] = self._builtins
        self._modules[full] = sys.modules[name] = module
        self.names.append(name)
        try:
            exec(compiled(file, self.read(file), self._compile), vars(module))
        except BaseException:
            del self._modules[full], sys.modules[name]
            self.names.remove(name)
            raise
        return module


def _package(scope: Mapping[str, Any] | None) -> str:
    package = (scope or {}).get("__package__")
    if not package:
        raise ImportError("attempted relative import with no known parent package")
    return str(package)
