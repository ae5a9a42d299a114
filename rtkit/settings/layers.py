"""Layers of settings: flag, environment, project, user, system; each counts more than the next.

Files are TOML; `rtkit.settings.layer_file` reads one, and is imported where there is one: each
command begins here.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator
from typing import TYPE_CHECKING, NamedTuple

from rtkit.errors import NotFound, Refused

if TYPE_CHECKING:
    from rtkit.settings.layer_file import SettingsFile

PROJECT_FILE = "rtkit.toml"
_FILE = "rtkit/config.toml"
PREFIX = "RTKIT_"


class Layers(NamedTuple):
    """The files that count, from the strongest, and warnings about others."""

    files: tuple[SettingsFile, ...] = ()
    warnings: tuple[str, ...] = ()

    def apply(self) -> dict[str, SettingsFile]:
        """Set the environment variables that are not set; return by setting who has set them."""
        given = {}
        for layer in self.files:
            for key, value in layer.settings.items():
                variable = PREFIX + key.upper()
                if variable not in os.environ:
                    os.environ[variable], given[key] = value, layer
        return given


def has_variables() -> bool:
    """Return whether an environment variable may stand for an option."""
    ours = [name.removeprefix(PREFIX) for name in os.environ if name.startswith(PREFIX)]
    return any(name.startswith("RT") or name == "TIMEOUT" for name in ours)


def candidates() -> Iterator[tuple[str, str]]:
    """Yield origin and path of each file that would count, the strongest first."""
    folder = os.getcwd()
    while not os.path.lexists(path := os.path.join(folder, PROJECT_FILE)) and folder != "/":
        folder = os.path.dirname(folder)
    yield "project", path if folder != "/" else os.path.join(os.getcwd(), PROJECT_FILE)
    own = os.environ.get("XDG_CONFIG_HOME") or os.path.expanduser("~/.config")
    yield "user", os.path.join(own, _FILE)
    for base in (os.environ.get("XDG_CONFIG_DIRS") or "/etc").split(":"):
        yield "system", os.path.join(base, _FILE)


def read(commands: Callable[[], Collection[str]] | None = None) -> Layers:
    """Read the files that are there; `commands` names those that may have tables.

    A project's file that a stranger can have written is left out with a warning: it stands in a
    folder into which one only happened to go.

    Raises:
        Refused: A file of the user or of the system cannot be read, or a stranger can write it.
        Malformed: Names file and key.
    """
    found = [each for each in candidates() if os.path.lexists(each[1])]
    if not found:
        return Layers()
    from rtkit.settings.layer_file import parse
    from rtkit.settings.reading import read_private

    layers, warnings = [], []
    for origin, path in found:
        try:
            data = read_private(path, must_be_ours=True)
        except Refused as error:
            if origin != "project":
                raise
            warnings.append(str(error))
        except NotFound:  # a dead link
            warnings.append(f"no such file: {path}")
        else:
            layers.append(parse(origin, path, data, commands and commands()))
    return Layers(tuple(layers), tuple(warnings))
