"""Loads modules from files and makes components with the factories that they register."""

from __future__ import annotations

import contextlib
import os
import re
import sys
import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any, NamedTuple

from rtkit.component.base import Component
from rtkit.component.composite import TYPES as COMPOSITES
from rtkit.component.contexts.callbacks import describe_failure, near_misses
from rtkit.component.describe import CODE
from rtkit.component.factory import Factories
from rtkit.errors import NotFound, Refused
from rtkit.modules.bytecode import code_of
from rtkit.modules.known import instead
from rtkit.modules.neighbours import among_its_own, fingerprints, forget_neighbours, has_changed
from rtkit.modules.search import ModuleSource, Search
from rtkit.rtc.create import CreateString
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.profiles import ModuleProfile, TypeProfile

_FOREIGN = "__rtkit_foreign__"
"""In a module that was written for OpenRTM-aist: what the loader needs to know of it."""
_OPENRTM = b"OpenRTM_aist"
_LOOK_S = 0.01
"""How long a file counts as what it was when it was looked at: no edit is as quick [s]."""
Complete = Callable[[CreateString, TypeProfile], CreateString]


def _as_it_is(create: CreateString, _type: TypeProfile) -> CreateString:
    return create


class UntriedModule(Exception):
    """A module that no other process has imported before, so that it is not imported here.

    Attributes:
        path: As it was asked for.
        init: Name of its init function; empty for the usual one.
    """

    def __init__(self, path: str, init: str) -> None:
        super().__init__(path)
        self.path = path
        self.init = init


class _Registrar:
    """Interface that an init function gets: the part of a manager that modules may use."""

    def __init__(self) -> None:
        self.classes: list[type[Component]] = []

    def register_factory(self, component_class: type[Component]) -> None:
        """Offer a component class for creation."""
        self.classes.append(component_class)


class _Imported(NamedTuple):
    """A module that was imported, with the fingerprint of its content.

    Attributes:
        beside: CRC-32 of the files beside it that it imports.
    """

    module: ModuleType
    fingerprint: int
    stamp: tuple[int, int, int]
    beside: Mapping[str, int]


class Loader:
    """The modules and factories of one process.

    Modules are looked for by path, or by name in the load paths; a component type that nobody
    registered is looked for as ``<implementation_id>.py`` there, then by its name among the
    installed packages.

    Args:
        load_path: Folders of modules.
        imports_untried: Whether a module may be imported that no other process has imported
            before. It may hang or end the process, which a manager must not.

    Attributes:
        tried: Fingerprints of the modules that another process has imported, by path.
    """

    def __init__(self, load_path: list[str], *, imports_untried: bool = True) -> None:
        self.factories = Factories()
        self.tried: Mapping[str, int] = {}
        self._imports_untried = imports_untried
        self._search = Search(load_path)
        self._is_search_allowed = True
        self._imported: dict[str, _Imported] = {}
        self._modules: dict[tuple[str, str], ModuleProfile] = {}
        self._known: dict[tuple[str, str], ModuleProfile] = {}
        self._found: list[ModuleProfile] = []
        self._remarks: dict[tuple[str, str], list[str]] = {}
        self._look_at_s: dict[str, float] = {}

    def configure(
        self, folders: Sequence[str], *, is_absolute_allowed: bool, is_search_allowed: bool
    ) -> None:
        """Change where modules are looked for; those that are loaded stay."""
        self._search = Search(folders, is_absolute_allowed=is_absolute_allowed)
        self._is_search_allowed = is_search_allowed

    def load(self, path: str, init: str = "") -> ModuleProfile:
        """Load a module and call its init function; doing that again changes nothing.

        Raises:
            NotFound: There is no such file, or no such init function in it.
            Refused: It does not import, or its init function raises; says where. Or it has
                changed since another init function of it was called.
            UntriedModule: Another process has to import it first.
        """
        asked = (path, init)
        if asked not in self._known:
            self._known[asked] = self._load(path, init)
        return self._known[asked]

    def _load(self, path: str, init: str) -> ModuleProfile:
        source = self._search.read(path)
        usual = f"{os.path.basename(source.file).partition('.')[0]}Init"
        name = init or source.init or usual
        known = self._modules.get((source.real, name))
        if known is not None:
            return known
        fingerprint = zlib.crc32(source.text)
        if not self._imports_untried and self.tried.get(path) != fingerprint:
            raise UntriedModule(path, init)
        imported = self._imported.get(source.real)
        if imported is not None and imported.fingerprint != fingerprint:
            raise Refused(f"module {path} has changed since it was loaded (rtmgr -u forgets it)")
        with among_its_own(source):
            module = imported.module if imported else import_source(source)
            classes = registered_by(module, name, path, is_usual=name == usual)
        if imported is None:
            foreign = vars(module).get(_FOREIGN)
            beside = fingerprints(source) | (dict(foreign.files) if foreign else {})
            imported = _Imported(module, fingerprint, _stamp(source.real), beside)
        types = self.factories.register_all(classes)
        code = {source.real: fingerprint, **imported.beside}
        for each in classes:
            setattr(each, CODE, "\n".join(f"{crc:08x} {file}" for file, crc in code.items()))
        self._imported[source.real] = imported
        aliases = (path,) if path != source.path else ()
        profile = ModuleProfile(source.path, name, types, source.real, aliases)
        self._modules[source.real, name] = profile
        self._remarks[source.real, name] = [t for each in classes for t in near_misses(each)]
        return profile

    def remarks(self, module: ModuleProfile) -> list[str]:
        """Return what is odd in the component classes of a module."""
        return self._remarks.get((module.file, module.init), [])

    def ahead(self, module: ModuleProfile) -> str:
        """Return which module processes import best before they import that one; mostly none."""
        foreign = vars(self._imported[module.file].module).get(_FOREIGN)
        return foreign.ahead if foreign else ""

    def fingerprint(self, path: str) -> int:
        """Return the fingerprint of the content of a loaded module."""
        return self._imported[self._real(path)].fingerprint

    def present_fingerprint(self, path: str) -> int:
        """Return a fingerprint of the present file of a module.

        Raises:
            NotFound: There is no such file.
            Refused: It lies where no module is taken from.
        """
        return zlib.crc32(self._search.read(path).text)

    def changed(self, type_: TypeProfile) -> str:
        """Return the path of the module of a type if it has been edited since it was imported."""
        for (real, _), module in self._modules.items():
            if type_ in module.types and self._is_touched(real):
                if has_changed(self._imported[real].beside):
                    return module.path
                was = self._imported[real].fingerprint
                with contextlib.suppress(NotFound, Refused):
                    return module.path if self.present_fingerprint(real) != was else ""
        return ""

    def _is_touched(self, real: str) -> bool:
        """Return whether a file, or one beside it, has changed; one look serves a whole batch.

        Each look gives the interpreter lock away, which another thread then keeps for long.
        """
        now_s = time.monotonic()
        if now_s < self._look_at_s.get(real, 0.0):
            return False
        imported = self._imported[real]
        is_touched = _stamp(real) != imported.stamp or has_changed(imported.beside)
        self._look_at_s[real] = 0.0 if is_touched else now_s + _LOOK_S
        return is_touched

    def found(self) -> list[ModuleProfile]:
        """Return the modules that were found by the names of types since this was asked last."""
        found, self._found = self._found, []
        return found

    @property
    def modules(self) -> tuple[ModuleProfile, ...]:
        """Return the loaded modules, one entry for each init function."""
        return tuple(self._modules.values())

    def unload(self, path: str) -> str:
        """Forget a module and its factories; components already made stay.

        Return where its file is, empty if there is none of that name and it was not loaded.
        """
        real = self._real(path)
        gone = [self._modules.pop(key) for key in list(self._modules) if key[0] == real]
        self._known = {asked: each for asked, each in self._known.items() if each.file != real}
        self._imported.pop(real, None)
        folder = os.path.dirname(real)
        if all(os.path.dirname(each) != folder for each in self._imported):
            forget_neighbours(real)
            if "rtkit.openrtm.loading.folder" in sys.modules:
                from rtkit.openrtm.loading.folder import forget_folder

                forget_folder(folder)
        kept = {profile.id for other in self._modules.values() for profile in other.types}
        for profile in (each for module in gone for each in module.types):
            if profile in self.factories.types and profile.id not in kept:
                self.factories.unregister(profile)
        return real

    def _real(self, path: str) -> str:
        """Return the file that a path means, also when it has been loaded and is there no more."""
        for (asked, _), module in self._known.items():
            if asked == path or module.file == path:
                return module.file
        try:
            return self._search.read(path).real
        except (NotFound, Refused):
            return ""

    def make(self, create: CreateString, complete: Complete = _as_it_is) -> Component:
        """Make a component, loading the module of its type if nobody offers it yet.

        `complete` may add properties when the type is known.

        Raises:
            NotFound: Nobody knows the type.
            Refused: Its module does not load, or its constructor raises.
        """
        if create.implementation_id in COMPOSITES and not self._offers(create.implementation_id):
            self.factories.register(COMPOSITES[create.implementation_id])
        return self.factories.make(complete(create, self._type_of(create)))

    def _type_of(self, create: CreateString) -> TypeProfile:
        """Return the type that a create string means, loading its module if nobody offers it yet.

        Raises:
            NotFound: Nobody knows the type.
            Refused: Its module does not load.
        """
        fields = (create.vendor, create.category, create.language, create.version)
        try:
            return self.factories.find(create.implementation_id, *fields)
        except NotFound as error:
            name = create.implementation_id
            is_name = os.path.basename(name) == name  # a type's name must not lead elsewhere
            path = self._search.path_of(create) if self._is_search_allowed and is_name else ""
            if not path or (path, "") in self._known or not self._search.has(path):
                raise NotFound(f"{error}{self._instead(create.implementation_id)}") from None
        self._found.append(self.load(path))
        return self.factories.find(create.implementation_id, *fields)

    def _instead(self, type_name: str) -> str:
        """Return what could be made in place of a type that is not known."""
        if self._offers(type_name):
            return ""  # it is known, but not with that vendor or version
        registered = [profile.type_name for profile in self.factories.types]
        search = self._search if self._is_search_allowed else None
        return instead(type_name, registered, COMPOSITES, search)

    def _offers(self, type_name: str) -> bool:
        return any(profile.type_name == type_name for profile in self.factories.types)


def _stamp(file: str) -> tuple[int, int, int]:
    """Return what changes with a file."""
    try:
        status = os.stat(file)
    except OSError:
        return (0, 0, 0)
    return status.st_ino, status.st_size, status.st_mtime_ns


def import_source(source: ModuleSource) -> ModuleType:
    """Import a module from what was read; by relative imports it gets others of its package.

    Raises:
        Refused: It does not import; says where.
    """
    file = source.file
    name = "rtkit_module_" + "".join(c if c.isalnum() else "_" for c in file)
    module = ModuleType(name)
    module.__file__ = file
    module.__package__ = source.package
    sys.modules[name] = module
    try:
        if _OPENRTM in source.text:  # 0095: the one look that costs others nothing
            from rtkit.openrtm.loading.module import run_module

            vars(module)[_FOREIGN] = run_module(module, source.text, code_of)
        else:
            exec(code_of(file, source.text), module.__dict__)
    except BaseException as error:
        del sys.modules[name]
        raise Refused(_import_failure(error, file)) from error
    return module


def _import_failure(error: BaseException, file: str) -> str:
    if isinstance(error, Refused) and re.match(r".*\.py:\d+\b", str(error)):
        return f"module does not import: {error}"
    return f"module does not import: {failure_in(file, error)}"


def failure_in(file: str, error: BaseException) -> str:
    """Return what was raised by a file of an author, with its line, and what would help."""
    line = getattr(error, "lineno", None) if isinstance(error, SyntaxError) else None
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == file:
            line = trace.tb_lineno
        trace = trace.tb_next
    from rtkit.extras import hint
    from rtkit.openrtm.migrate.age_hint import age_hint

    reason = f": {error}{hint(error) or age_hint(error, file)}" if str(error) else ""
    return f"{type(error).__name__}{reason} ({file}:{line or 1})"


def registered_by(
    module: ModuleType, name: str, path: str, *, is_usual: bool
) -> list[type[Component]]:
    """Return the component classes that an init function of a module registers.

    Args:
        module: It is imported.
        name: Of the function.
        path: Of the module, as it was asked for.
        is_usual: Whether the name is the one that is looked for where none is given.

    Raises:
        NotFound: It has no such function.
        Refused: The function raises; says where.
    """
    foreign = vars(module).get(_FOREIGN)
    function: Any = getattr(module, name, None)
    if foreign is not None:
        function = foreign.init_function(name, is_usual=is_usual)
    if not callable(function):
        offered = [each for each, value in vars(module).items() if callable(value)]
        hint = did_you_mean(name, [each for each in offered if each.endswith("Init")])
        way = foreign.way if foreign is not None and not hint else ""
        raise NotFound(f"no init function {name}{hint} in module {path}{way}")
    registrar = _Registrar()
    try:
        function(registrar if foreign is None else foreign.manager(registrar))
    except BaseException as error:
        why = describe_failure(error, function)
        raise Refused(f"init function {name} of {path} failed: {why}") from error
    return registrar.classes
