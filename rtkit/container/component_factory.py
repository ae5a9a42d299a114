"""Makes the components of a process, and loads the modules that they come from.

It is apart from the container because an attached process brings its components, made already:
the code that finds, loads and configures them is a third of what a container imports.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from rtkit.component.base import Component
from rtkit.component.standin import stand_in
from rtkit.container.process_settings import complete, configure
from rtkit.deployment.message import Message
from rtkit.errors import NotFound, Refused
from rtkit.modules.loader import Loader, UntriedModule
from rtkit.rtc.create import CreateString
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ModuleProfile
from rtkit.rtc.serde import decode, encode
from rtkit.settings.options import CONF, unknown_options


class ComponentFactory:
    """Makes the components of a process, from the modules that its loader finds."""

    def __init__(self, loader: Loader, load_path: Sequence[str] = ()) -> None:
        self._loader = loader
        self.configured: Message = {"load_path": [*load_path]}

    def configure(self, message: Message) -> None:
        """Configure this process as its manager's message says.

        Raises:
            Refused: A processor is not there.
        """
        configure(message, self._loader)
        self.configured = message

    def load(self, path: str, init: str) -> dict[str, Any]:
        """Load a module and return its profile and fingerprint.

        Raises:
            RtkitError: There is none, or it cannot be imported.
        """
        return self._record(self._loader.load(path, init))

    def unload(self, message: Message) -> str:
        """Forget a module; return where its file is, empty if there is none of that name."""
        return self._loader.unload(message["path"])

    def fingerprint(self, message: Message) -> int:
        """Return a fingerprint of the present file of a module, 0 if it cannot be read."""
        try:
            return self._loader.present_fingerprint(message["path"])
        except (NotFound, Refused):
            return 0

    def changed(self, component: Component) -> str:
        """Return the path of a component's module if it has been edited since it was imported."""
        return self._loader.changed(component.type)

    def odd_options(self, component: Component, create: CreateString) -> list[str]:
        """Return findings about options that mean nothing to a component."""
        return odd_options(component, create.options)

    @property
    def modules(self) -> list[Any]:
        """All modules of this process."""
        return list(map(self._record, self._loader.modules))

    def found(self) -> list[Any]:
        """Return the modules that were found by the names of types since this was asked last."""
        return list(map(self._record, self._loader.found()))

    def _record(self, module: ModuleProfile) -> dict[str, Any]:
        fingerprint = self._loader.fingerprint(module.file)
        odd = self._loader.remarks(module)
        record = {"module": encode(module), "fingerprint": fingerprint, "remarks": odd}
        ahead = self._loader.ahead(module)
        return record | ({"ahead": ahead} if ahead else {})

    def make(self, create: CreateString, message: Message) -> Component | dict[str, Any]:
        """Return a component that is not initialised, or which module has to be tried before.

        Raises:
            RtkitError: It cannot be made.
        """
        if message.get("pattern") is not None:
            pattern = decode(ComponentPattern, message["pattern"])
            create = complete(message, create, pattern.type, inherits=False)
            return stand_in(pattern, create.instance_name, create.options)
        self._loader.tried = message.get("tried", {})
        try:
            for path, init in message.get("modules", ()):
                self._loader.load(path, init)
            return self._loader.make(create, partial(complete, message))
        except UntriedModule as untried:
            return {"untried": untried.path, "init": untried.init}


def odd_options(component: Component, options: Mapping[str, str]) -> list[str]:
    """Return findings about options that resemble known ones, a line each.

    Others are properties of the component, which may ask for them.
    """
    return [*_parameters(component, options), *unknown_options(options)]


def _parameters(component: Component, options: Mapping[str, str]) -> Iterator[str]:
    """Yield options for parameters that the component does not have."""
    if component.is_stand_in or component.composite_type:
        return
    known = component.configuration.values
    for key in options:
        if not key.startswith(CONF):
            continue
        set_id, _, name = key.removeprefix(CONF).partition(".")
        if set_id and name and name not in known and not set_id.startswith("_"):
            hint = did_you_mean(name, known, 1)
            yield f"{component.instance} has no parameter {name}{hint}: {key}"
