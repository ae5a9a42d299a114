"""Loads modules from files and makes components with the factories that they register."""

from __future__ import annotations

import os
import stat
import sys
from types import ModuleType
from typing import Any

from rtkit.component.base import Component
from rtkit.component.callbacks import describe_failure
from rtkit.component.factory import Factories
from rtkit.errors import NotFound, Refused
from rtkit.rtc.create import CreateString
from rtkit.rtc.profiles import ModuleProfile


class _Registrar:
    """What an init function is handed: the part of a manager that modules may use."""

    def __init__(self) -> None:
        self.classes: list[type[Component]] = []

    def register_factory(self, component_class: type[Component]) -> None:
        """Offer a component class for creation."""
        self.classes.append(component_class)


class Loader:
    """The modules and factories of one process.

    Modules are looked for by path, or by name in the load paths; a component type that nobody
    registered is looked for as ``<implementation_id>.py`` there.
    """

    def __init__(self, load_path: list[str]) -> None:
        self.load_path = load_path
        self.factories = Factories()
        self._modules: dict[str, ModuleProfile] = {}

    def load(self, path: str, init: str = "") -> ModuleProfile:
        """Load a module and call its init function; loading it again changes nothing.

        Raises:
            NotFound: There is no such file, or no such init function in it.
            Refused: It does not import, or its init function raises; says where.
        """
        known = self._modules.get(path)
        if known is not None:
            return known
        file = self._find(path)
        name = init or f"{os.path.basename(file).partition('.')[0]}Init"
        module = _import(file, _read(file))
        classes = _initialise(module, name, path)
        types = tuple(self.factories.register(component_class) for component_class in classes)
        profile = self._modules[path] = ModuleProfile(path, name, types)
        return profile

    def unload(self, path: str) -> None:
        """Forget a module and its factories; components already made stay."""
        module = self._modules.pop(path, None)
        if module is None:
            return
        kept = {profile.id for other in self._modules.values() for profile in other.types}
        for profile in module.types:
            if profile in self.factories.types and profile.id not in kept:
                self.factories.unregister(profile)

    def make(self, create: CreateString) -> Component:
        """Make a component, loading the module of its type if nobody offers it yet.

        Raises:
            NotFound: Nobody knows the type.
            Refused: Its module does not load, or its constructor raises.
        """
        try:
            return self.factories.make(create)
        except NotFound:
            path = f"{create.implementation_id}.py"
            is_name = os.path.basename(path) == path  # a type's name must not lead elsewhere
            if not is_name or path in self._modules or not self._search(path):
                raise
        self.load(path)
        return self.factories.make(create)

    def _find(self, path: str) -> str:
        file = path if os.path.isabs(path) else self._search(path)
        if not file or not os.path.isfile(file):
            looked = ", ".join(self.load_path)
            raise NotFound(f"no module {path} (looked in {looked})")
        return file

    def _search(self, path: str) -> str:
        for name in (path, f"{path}.py"):
            for folder in self.load_path:
                file = os.path.join(folder, name)
                if os.path.isfile(file):
                    return file
        return ""


def _read(file: str) -> bytes:
    """Return the source of a module, the very file that was found not to be open to everybody."""
    folder = os.path.dirname(file)
    status = os.stat(folder)
    if status.st_mode & stat.S_IWOTH and not status.st_mode & stat.S_ISVTX:
        raise Refused(f"module lies where everybody may write, refused: {file}")
    try:
        with open(file, "rb") as source:
            status = os.fstat(source.fileno())
            if status.st_mode & stat.S_IWOTH:
                raise Refused(f"module may be written by everybody, refused: {file}")
            return source.read()
    except OSError as error:
        raise Refused(f"cannot read module {file}: {error.strerror}") from error


def _import(file: str, source: bytes) -> ModuleType:
    name = "rtkit_module_" + "".join(c if c.isalnum() else "_" for c in file)
    module = ModuleType(name)
    module.__file__ = file
    sys.modules[name] = module
    try:
        exec(compile(source, file, "exec"), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        raise Refused(_import_failure(error, file)) from error
    return module


def _import_failure(error: BaseException, file: str) -> str:
    line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    return f"module does not import: {type(error).__name__}: {error} ({file}:{line or 1})"


def _initialise(module: ModuleType, name: str, path: str) -> list[type[Component]]:
    function: Any = getattr(module, name, None)
    if not callable(function):
        raise NotFound(f"no init function {name} in module {path}")
    registrar = _Registrar()
    try:
        function(registrar)
    except BaseException as error:
        why = describe_failure(error, function)
        raise Refused(f"init function {name} of {path} failed: {why}") from error
    return registrar.classes
