"""Layers of settings: flag, environment, project, user, system; each counts more than the next.

Files are TOML. What stands at the top is a setting of all commands, and gets the value of its
environment variable where that is not set; a table as ``[rtls]`` has defaults of that command's
options. The variables of the environment carry on to the processes that a command starts.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any, NamedTuple

from rtkit.errors import Malformed, NotFound, Refused

PROJECT_FILE = "rtkit.toml"
_FILE = "rtkit/config.toml"
PREFIX = "RTKIT_"

Options = Mapping[str, Any]
"""Table of a command: values of its options, or tables of its words."""


class Setting(NamedTuple):
    """A setting of all commands.

    Attributes:
        kind: ``text``, ``flag``, ``seconds``, ``list`` or ``paths``: those are taken from the
            folder of the file.
    """

    key: str
    kind: str
    default: str
    meaning: str

    @property
    def variable(self) -> str:
        """Name of its environment variable."""
        return PREFIX + self.key.upper()


SETTINGS = (
    Setting("manager", "text", "manager", "manager that is asked, a name or HOST:PORT"),
    Setting("servers", "list", "", "addresses that are always in the tree"),
    Setting("realm", "text", "default", "systems of different realms never meet"),
    Setting("port", "text", "2810", "TCP endpoint of managers, none for none"),
    Setting("module_path", "paths", "", "folders of modules of components"),
    Setting("profile_path", "paths", "", "folders of RTC profiles"),
    Setting("timeout", "seconds", "10", "bound on each call [s]"),
    Setting("exit_detail", "flag", "", "whether exit statuses tell kinds of failure apart"),
    Setting("completion_timeout", "seconds", "1", "how long TAB waits for a manager [s]"),
)


class SettingsFile(NamedTuple):
    """Settings of all commands, and tables of commands; `origin` is project, user or system."""

    origin: str
    file: str
    settings: Mapping[str, str]
    commands: Mapping[str, Options]


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
            layers.append(_layer(origin, path, data, commands and commands()))
    return Layers(tuple(layers), tuple(warnings))


def _layer(origin: str, path: str, data: bytes, commands: Collection[str] | None) -> SettingsFile:
    import tomllib

    try:
        entries = tomllib.loads(data.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Malformed(f"{path}: {error}") from None
    known = {setting.key: setting for setting in SETTINGS}
    settings, tables = {}, {}
    for key, value in entries.items():
        if key in known:
            settings[key] = _text(known[key], value, path)
        elif isinstance(value, dict) and (commands is None or key in commands):
            tables[key] = value
        else:
            from rtkit.rtc.nearest import did_you_mean

            hint = did_you_mean(key, [*known, *(commands or ())])
            raise Malformed(f"{path}: unknown key: {key}{hint}")
    return SettingsFile(origin, path, settings, tables)


def _text(setting: Setting, value: Any, path: str) -> str:
    """Return a value as its environment variable has it."""
    is_number = type(value) in (int, float)
    if setting.kind in ("list", "paths"):
        items = [value] if isinstance(value, str) else value
        if isinstance(items, list) and all(isinstance(item, str) for item in items):
            return ";".join(items) if setting.kind == "list" else _joined(items, path)
    elif setting.kind == "flag" and isinstance(value, bool):
        return "1" if value else "0"
    elif {"text": is_number or isinstance(value, str), "seconds": is_number and value > 0}.get(
        setting.kind
    ):
        return str(value)
    wanted = {"flag": "true or false", "text": "a text", "seconds": "a number above 0"}
    raise Malformed(f"{path}: {setting.key}: not {wanted.get(setting.kind, 'a list of texts')}")


def _joined(items: list[str], path: str) -> str:
    folder = os.path.dirname(os.path.abspath(path))
    return ":".join(os.path.join(folder, os.path.expanduser(item)) for item in items)
