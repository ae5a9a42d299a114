"""Modules of OpenRTM-aist that are run as scripts: their components live in the script's process.

``rtkit openrtm run FILE`` runs one, and so does ``python FILE`` where ``PYTHONPATH`` has the
folder that ``rtkit openrtm path`` tells. What the module asks of ``Manager`` is asked of the
manager of this host, which is started where none runs.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from types import CodeType, ModuleType
from typing import Any

from rtkit.by_hand import RunningComponent, begin, wait_for
from rtkit.component.base import Component
from rtkit.container.process_settings import layered
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.link import places
from rtkit.logs.late import late
from rtkit.manager import launch
from rtkit.openrtm.api.adapter import HeldComponent
from rtkit.openrtm.api.manager import Manager, ModuleManager
from rtkit.openrtm.loading.folder import ComponentFolder, folder_of
from rtkit.openrtm_scripts.far_references import FarComponent
from rtkit.openrtm_scripts.script_types import ScriptTypes
from rtkit.rtc.create import CreateString, parse_create
from rtkit.settings import configuration
from rtkit.settings.configuration import CommandLineSettings
from rtkit.settings.properties import INHERITED

_START_S = 20.0
_NOT_TWICE = ("modules.preload", "components.precreate", "components.preconnect",
              "components.preactivation")  # fmt: skip
"""Settings of ``rtc.conf`` that the script heeds itself, below ``manager.``."""
_log = late(__name__)


class ScriptManager(ModuleManager):
    """The manager that a script initialises, creates its components with, and runs.

    Args:
        arguments: Of the command line, as OpenRTM-aist takes them.
    """

    def __init__(self, arguments: Sequence[str]) -> None:
        super().__init__(self)
        self._running: list[RunningComponent] = []
        options = _options(arguments)
        self._wanted = CommandLineSettings(options.f, tuple(options.o))
        self._settings = configuration.read(self._wanted).settings
        for key, value in self._settings.table().items():
            self._config.setProperty(key, value)
        self._types = ScriptTypes(self._settings)

    def register_factory(self, component: type[HeldComponent]) -> None:
        """Take a component type, for `createComponent`."""
        self._types.add(component)

    def activateManager(self) -> bool:
        """Join the manager of this host, and create the components of the script."""
        self._join()
        self._types.preload()
        super().activateManager()
        for text in self._settings.items("manager.components.precreate"):
            self.createComponent(text)
        with _tree() as tree:
            for text in self._settings.items("manager.components.preconnect"):
                tree.connect(*_ends(tree, text), **_properties(text))
            for name in self._settings.items("manager.components.preactivation"):
                tree.activate(_path(tree, name))
        return True

    def createComponent(self, comp_args: str) -> Any:
        """Create a component in this process; return the author's object, None without its type."""
        create = parse_create(comp_args)
        try:
            kind = self._types.find(create.implementation_id)
        except RtkitError as error:
            _log().error("%s", error)
            return None
        self._join()
        complete = partial(self._completed, kind)
        running = begin(kind, create.instance_name, create.options, complete, _START_S)
        self._running.append(running)
        return _object_of(running)

    def deleteComponent(self, component: Any) -> None:
        """End a component, given by its object or name."""
        for each in self._running:
            held = each.component
            if component in (held.instance, getattr(held, "servant", None)):
                each.close()

    def getComponents(self) -> list[Any]:
        """Return the objects of all components that live."""
        return [_object_of(each) for each in self._running if each.is_running]

    def getComponent(self, instance_name: str) -> Any:
        """Return the object of a component; None if there is none."""
        for each in self._running:
            if each.is_running and each.component.instance == instance_name:
                return _object_of(each)
        return None

    def runManager(self, no_block: bool | None = None) -> None:
        """Return when all components were ended, or at Ctrl-C; at once if not to block."""
        if not no_block:
            wait_for(self._running)

    def shutdown(self) -> None:
        """End all components of this process."""
        for each in self._running:
            each.close()

    terminate = shutdown

    def join(self) -> None:
        """Do nothing: `runManager` waits."""

    def _completed(
        self, kind: type[Component], instance: str, options: Mapping[str, str]
    ) -> Mapping[str, str]:
        """Return options with those that configuration files have for an instance, or its type."""
        files = {
            key.removesuffix(".config_file"): value
            for key, value in self._settings.below("").items()
            if key.endswith(".config_file")
        }
        type_ = kind.type_profile()
        create = CreateString(type_.type_name, options={**options, "instance_name": instance})
        settings = {
            "inherited": self._settings.below(*INHERITED),
            "config_files": files,
            "given": self._settings.of_components(),
        }
        return layered(create, type_, settings).options

    def _join(self) -> None:
        """Start the manager of this host with the same settings, if it does not run."""
        empty = tuple(f"manager.{each}:" for each in _NOT_TWICE)
        wanted = self._wanted._replace(overrides=(*self._wanted.overrides, *empty))
        launch.ensure(places.usual_manager(), wanted, _START_S)


def _object_of(running: RunningComponent) -> Any:
    """Return the author's object of a component; a reference to one that has none."""
    return getattr(running.component, "servant", None) or FarComponent(running.path)


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog=arguments[0] if arguments else None)
    parser.add_argument("-f", metavar="FILE", default="", help="configuration file")
    text = "property, over the configuration file"
    parser.add_argument("-o", metavar="KEY:VALUE", action="append", default=[], help=text)
    for option, text in (
        ("-a", "no effect: the manager of this host names components"),
        ("-d", "no effect: the manager of this host is the master"),
        ("-i", "no effect"),
    ):
        parser.add_argument(option, action="store_true", help=text)
    parser.add_argument("-p", metavar="PORT", help="no effect: the manager has the port")
    known, rest = parser.parse_known_args(arguments[1:])
    if rest:
        _log().warning("not understood, and left to the script: %s", " ".join(rest))
    return known


def _tree() -> Any:
    from rtkit.api.connect import connect

    return connect()


def _path(tree: Any, instance: str) -> str:
    for row in tree.listing().rows:
        if row.instance == instance and row.names:
            return f"/{row.names[0]}"
    raise NotFound(f"no component {instance}")


def _ends(tree: Any, text: str) -> list[str]:
    """Return the paths of the ports of ``A.out?port=B.in&KEY=VALUE``."""
    first, _, rest = text.partition("?")
    others = [each[len("port=") :] for each in rest.split("&") if each.startswith("port=")]
    ends = []
    for each in (first, *others):
        instance, _, port = each.strip().rpartition(".")
        ends.append(f"{_path(tree, instance)}:{port}")
    return ends


def _properties(text: str) -> dict[str, str]:
    pairs = [each.partition("=") for each in text.partition("?")[2].split("&") if each]
    return {key.replace(".", "__"): value for key, _, value in pairs if key != "port"}


def run_script(file: str, arguments: Sequence[str]) -> None:
    """Run a file as Python runs a script, with the names of OpenRTM.

    Raises:
        OSError: It cannot be read.
        Refused: It raises an error; says which, and where.
    """
    sys.argv = [file, *arguments]
    sys.path.insert(0, os.path.dirname(os.path.abspath(file)))
    _take_over()
    main = ModuleType("__main__")
    main.__file__ = file
    sys.modules["__main__"] = main
    folder = folder_of(file, _compiled)
    source = folder.read(file)
    try:
        folder.run(main, source)
    except RtkitError:
        raise
    except Exception as error:
        from rtkit.modules.loader import failure_in  # most scripts end well

        raise Refused(f"the script failed: {failure_in(file, error)}") from error


def take_over(name: str) -> None:
    """Have all imports of this process find the names of OpenRTM; called by the first of them."""
    main = sys.modules["__main__"]
    folder = folder_of(getattr(main, "__file__", None) or os.path.join(os.getcwd(), "-"), _compiled)
    _take_over()
    sys.meta_path.insert(0, _Finder(folder))
    found = folder.find(name)
    assert found is not None
    sys.modules[name] = found


def _take_over() -> None:
    def begin(arguments: list[str]) -> ScriptManager:
        return ScriptManager(arguments or sys.argv)

    Manager.begin = begin


def _compiled(file: str, text: bytes) -> CodeType:
    code: CodeType = compile(text, file, "exec", dont_inherit=True)
    return code


class _Finder(MetaPathFinder):
    """Finds modules of a script's folder, and those of OpenRTM, for everybody in this process."""

    def __init__(self, folder: ComponentFolder) -> None:
        self._folder = folder

    def find_spec(self, fullname: str, path: Any, target: Any = None) -> ModuleSpec | None:
        """See `importlib.abc.MetaPathFinder`."""
        if fullname.partition(".")[0] == "rtkit":  # what is found needs these itself
            return None
        found = self._folder.find(fullname)
        return None if found is None else spec_from_loader(fullname, _Loader(found))


class _Loader(Loader):
    def __init__(self, module: ModuleType) -> None:
        self._module = module

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return self._module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: it has run."""
