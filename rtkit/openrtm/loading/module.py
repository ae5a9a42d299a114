"""Runs a module written for OpenRTM-aist for the loader, and finds its init function."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from types import CodeType, FunctionType, ModuleType
from typing import Any

from rtkit.openrtm.api.manager import ModuleManager, Registrar
from rtkit.openrtm.loading.folder import ComponentFolder, folder_of
from rtkit.openrtm.migrate.source import Compile

_REGISTER = b"registerFactory"
_CREATES_TOO = "MyModuleInit"
"""Name of the function that RTC Builder writes for a module that is run as a script."""


class OpenRtmModule:
    """Facts that the loader needs of a module that was written for OpenRTM-aist.

    Attributes:
        ahead: Name of the module that imports what most of them need.
    """

    ahead = "rtkit.openrtm.ahead"

    def __init__(self, module: ModuleType, folder: ComponentFolder, text: bytes) -> None:
        self._module = module
        self._folder = folder
        self._has_factories = _REGISTER in text

    @property
    def files(self) -> Mapping[str, int]:
        """CRC-32 of each file beside it that it, or a sibling, has read, by path."""
        return self._folder.files

    def init_function(self, name: str, *, is_usual: bool) -> Callable[[Any], object] | None:
        """Return the function that registers its components.

        Where none has the usual name, it is the only one of one argument that registers anything,
        else the one that RTC Builder calls `MyModuleInit`, else the only one without arguments.
        """
        found: Any = getattr(self._module, name, None)
        if callable(found) or not is_usual:
            usual: Callable[[Any], object] | None = found if callable(found) else None
            return usual
        registering = [each for each in self._functions() if _registers(each)]
        alone = [each for each in registering if each.__name__ != _CREATES_TOO]
        mine: Any = getattr(self._module, _CREATES_TOO, None)
        if len(alone) == 1 or not callable(mine):
            return next(iter([*alone, *registering]), None) or self._main_function()
        function: Callable[[Any], object] = mine
        return function

    def _main_function(self) -> Callable[[Any], object] | None:
        """Return what has the main function register, where that is the only one that does."""
        mains = [each for each in self._functions(0) if _registers(each)]
        if len(mains) != 1:
            return None
        return lambda manager: manager.run_main(mains[0])

    @property
    def way(self) -> str:
        """Advice where no init function was found: what registers, or how it is run."""
        file = str(self._module.__file__)
        if any(map(_registers, (*self._functions(), *self._functions(0)))):
            stem = os.path.basename(file).partition(".")[0]
            return f": say {file}:{stem}Init, which finds what registers"
        register = "registers when it is run" if self._has_factories else "registers no component"
        return f": it {register} (rtkit openrtm run {file})"

    def _functions(self, arguments: int = 1) -> list[FunctionType]:
        return [
            each
            for each in vars(self._module).values()
            if isinstance(each, FunctionType)
            and each.__code__.co_argcount == arguments
            and each.__globals__ is vars(self._module)
        ]

    def manager(self, registrar: Registrar) -> ModuleManager:
        """Return the manager that its init function gets."""
        return ModuleManager(registrar)


def _registers(function: FunctionType) -> bool:
    return _names_registration(function.__code__)


def _names_registration(code: CodeType) -> bool:
    inner = (each for each in code.co_consts if isinstance(each, CodeType))
    return _REGISTER.decode() in code.co_names or any(map(_names_registration, inner))


def run_module(module: ModuleType, text: bytes, compile_source: Compile) -> OpenRtmModule:
    """Run a module with the names of OpenRTM.

    Raises:
        BaseException: Whatever it raises.
    """
    folder = folder_of(str(module.__file__), compile_source)
    folder.run(module, text)
    return OpenRtmModule(module, folder, text)
