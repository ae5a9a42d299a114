"""Component types of a script: its own, those of modules beside it, and composites."""

from __future__ import annotations

import os
from collections.abc import Mapping

from rtkit.component.base import Component
from rtkit.component.composite import TYPES as COMPOSITES
from rtkit.errors import NotFound
from rtkit.modules.loader import import_source, registered_by
from rtkit.modules.search import SUFFIX, Search
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings import values
from rtkit.settings.properties import Settings


class ScriptTypes:
    """The component types that a script may create.

    Args:
        settings: They name modules to load, and folders where these are looked for.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        folders = settings.items("manager.modules.load_path") or (os.curdir,)
        more = settings.items("manager.modules.Python.load_paths")
        self._search = Search([*folders, *more])
        self._types: dict[str, type[Component]] = {}

    def add(self, component: type[Component]) -> None:
        """Take a type; it goes by either of its names."""
        name = component.type_profile().type_name
        described: Mapping[str, str] = getattr(component, "described", {})
        self._types[name] = component
        self._types.setdefault(described.get("implementation_id", name), component)

    def preload(self) -> None:
        """Load the modules that the settings name.

        Raises:
            NotFound: One is not there, or has no init function.
            Refused: One does not import, or its init function fails; says where.
        """
        for key in ("manager.preload.modules", "manager.modules.preload"):
            for item in self._settings.items(key):
                for file, init in values.modules(item):
                    self._load(file, init)

    def find(self, name: str) -> type[Component]:
        """Return the type of a name; its module may be one that was not loaded yet.

        Raises:
            NotFound: There is none.
            Refused: Its module does not load.
        """
        known = self._types.get(name) or COMPOSITES.get(name)
        if known is None and self._search.has(f"{name}{SUFFIX}"):
            self._load(f"{name}{SUFFIX}", "")
            known = self._types.get(name)
        if known is None:
            hint = did_you_mean(name, [*self._types, *COMPOSITES])
            raise NotFound(f"no component type {name}{hint}")
        return known

    def _load(self, path: str, init: str) -> None:
        source = self._search.read(path)
        usual = f"{os.path.basename(source.file).partition('.')[0]}Init"
        name = init or source.init or usual
        module = import_source(source)
        for each in registered_by(module, name, path, is_usual=name == usual):
            self.add(each)
