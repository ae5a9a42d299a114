"""Modules for the IDL files beside components: ``X_idl``, ``X`` and ``X__POA``.

omniORB generates these as Python files; here they are made of the definitions themselves, which
are read when the first name of them is used. Several files may open one module, and each folder
has modules of its own.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from functools import cached_property
from types import ModuleType
from typing import Any

from rtkit.component.standard import find as find_standard
from rtkit.openrtm.generated import GENERATED, opened_modules
from rtkit.openrtm.lazy_module import LazyModule

STUB, SERVANTS, _GLOBAL = "_idl", "__POA", "_GlobalIDL"
_GENERATED = "_idl.py"
_MODULE = re.compile(rb"^[ \t}]*module\s+(\w+)", re.MULTILINE)
_OWN_FOLDER = "idl"
PLACES = "RTM_IDL_PATH"
"""Environment variable with further folders; installers of OpenRTM set it to that of its own."""
Read = Callable[[str], bytes]


class FolderDefinitions:
    """The IDL files of a folder, of those in it, and of the one called ``idl`` beside it."""

    def __init__(self, path: str, read: Read) -> None:
        self._path = path
        self._read = read

    def module(self, name: str) -> ModuleType | None:
        """Return the module that omniORB would have generated; None where no file declares it."""
        if name in ("RTC", "RTC__POA"):
            return self._standard(name)
        if not self._files or "." in name:
            return None
        if name.endswith(STUB) and self._declares(name.removesuffix(STUB)):
            return LazyModule(name, self._missing)
        scope = name.removesuffix(SERVANTS)
        if scope != _GLOBAL and scope not in self._scopes:
            return None
        return self._declared(name, () if scope == _GLOBAL else (scope,))

    def module_elsewhere(self, name: str) -> ModuleType | None:
        """Return a module of files in the folders that ``RTM_IDL_PATH`` names, the first wins."""
        found = (each.module(name) for each in self._elsewhere)
        return next((each for each in found if each is not None), None)

    @property
    def places(self) -> list[str]:
        """Folders in which IDL files are looked for, as a message tells them."""
        beside = [self._path, f"{self._path}{os.sep}*", self._own_folder]
        return [
            *beside,
            *(each if os.path.isdir(each) else f"{each} (no folder)" for each in _named()),
        ]

    @cached_property
    def _elsewhere(self) -> list[FolderDefinitions]:
        return [FolderDefinitions(each, self._read) for each in _named() if os.path.isdir(each)]

    def _missing(self, name: str) -> Any:
        raise KeyError(name)

    def _declared(self, name: str, path: tuple[str, ...]) -> ModuleType:
        is_servants = name.endswith(SERVANTS)

        def find(each: str) -> Any:
            kind = self._declarations.servant if is_servants else self._declarations.value
            return kind((*path, each))

        return LazyModule(name, find, lambda: self._declarations.names(path))

    def _standard(self, name: str) -> ModuleType:
        """Return the module of the standard, with what files here add to it."""
        from rtkit.openrtm.standard_types import rtc_names, rtc_value

        declared = self._declared(name, ("RTC",))

        def find(each: str) -> Any:
            if not name.endswith(SERVANTS):
                try:
                    return rtc_value(each)
                except KeyError:
                    pass
            if "RTC" not in self._scopes:
                raise KeyError(each)
            return getattr(declared, each)

        def listed() -> list[str]:
            own = self._declarations.names(("RTC",)) if "RTC" in self._scopes else ()
            return [*rtc_names(), *own]

        return LazyModule(name, find, listed)

    @cached_property
    def _declarations(self) -> Any:
        from rtkit.openrtm.declared import Declarations

        return Declarations(self._path, self._files, self._read)

    def _declares(self, stem: str) -> bool:
        names = {os.path.basename(file).lower() for file in self._files}
        return f"{stem}.idl".lower() in names or f"{stem}{_GENERATED}".lower() in names

    @property
    def _own_folder(self) -> str:
        return os.path.join(os.path.dirname(self._path), _OWN_FOLDER)

    @cached_property
    def _files(self) -> list[str]:
        """IDL files, then what omniidl generated of files that are not there."""
        folders = dict.fromkeys([self._path, *_inner(self._path), self._own_folder])
        found = [file for folder in folders for file in _files_in(folder, ".idl")]
        stems = {os.path.basename(file)[:-4].lower() for file in found}
        generated = [
            file
            for file in _files_in(self._path, _GENERATED)
            if os.path.basename(file).removesuffix(_GENERATED).lower() not in stems
        ]
        return found + [file for file in generated if GENERATED in self._read(file)[:100]]

    @cached_property
    def _scopes(self) -> set[str]:
        """The modules that the files open, found without reading them as IDL."""
        return {name for file in self._files for name in _opened(file, self._read(file))}


def _named() -> list[str]:
    """Return the folders that the environment names."""
    return [each for each in os.environ.get(PLACES, "").split(os.pathsep) if each]


def _inner(folder: str) -> list[str]:
    with os.scandir(folder) as entries:
        return sorted(
            each.path for each in entries if each.is_dir() and not each.name.startswith(".")
        )


def _opened(file: str, text: bytes) -> Iterator[str]:
    """Yield the modules that a file adds something to."""
    if file.endswith(_GENERATED):
        yield from opened_modules(text)
        return
    for name in _MODULE.findall(text):
        if name != b"RTC" or not _is_standard_only(text):
            yield name.decode()


def _files_in(folder: str, ending: str) -> Iterator[str]:
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return
    yield from (os.path.join(folder, n) for n in names if n.lower().endswith(ending))


_STRUCT_NAME = re.compile(rb"\b(?:struct|enum|interface|union|exception)\s+(\w+)")


def _is_standard_only(text: bytes) -> bool:
    """Return whether a file declares nothing but what every process knows."""
    return all(find_standard("RTC", name.decode()) for name in _STRUCT_NAME.findall(text))
