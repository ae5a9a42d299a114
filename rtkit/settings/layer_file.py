"""Reads a file of settings, which is TOML.

A key at the top is a setting of all commands, and gets the value of its environment variable
where that is not set; a table as ``[rtls]`` has defaults of that command's options. The variables
of the environment carry on to the processes that a command starts.
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Collection, Mapping
from typing import Any, NamedTuple

from rtkit.errors import Malformed
from rtkit.rtc.nearest import did_you_mean

Options = Mapping[str, Any]
"""Table of a command: values of its options, or tables of its words."""


class Setting(NamedTuple):
    """A setting of all commands.

    Attributes:
        kind: ``text``, ``flag``, ``seconds``, ``list``, ``paths`` or ``places``: those two are
            taken from the folder of the file, places unless they are URLs.
    """

    key: str
    kind: str
    default: str
    meaning: str


SETTINGS = (
    Setting("manager", "text", "manager", "manager that is asked, a name or HOST:PORT"),
    Setting("servers", "list", "", "addresses that are always in the tree"),
    Setting("realm", "text", "default", "systems of different realms never meet"),
    Setting("port", "text", "2810", "TCP endpoint of managers, none for none"),
    Setting("module_path", "paths", "", "folders of modules of components"),
    Setting("profile_path", "paths", "", "folders of RTC profiles"),
    Setting("repositories", "places", "", "where packages are: folders, URLs, git+URLs"),
    Setting("signed", "flag", "", "whether only signed packages are installed"),
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


def parse(origin: str, path: str, data: bytes, commands: Collection[str] | None) -> SettingsFile:
    """Return the settings of a file; `commands` names those that may have tables.

    Raises:
        Malformed: Names file and key.
    """
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
            hint = did_you_mean(key, [*known, *(commands or ())])
            raise Malformed(f"{path}: unknown key: {key}{hint}")
    return SettingsFile(origin, path, settings, tables)


def _text(setting: Setting, value: Any, path: str) -> str:
    """Return a value as its environment variable has it."""
    is_number = type(value) in (int, float)
    if setting.kind in ("list", "paths", "places"):
        items = [value] if isinstance(value, str) else value
        if isinstance(items, list) and all(isinstance(item, str) for item in items):
            if setting.kind == "places":
                return ";".join(e if "://" in e else _joined([e], path) for e in items)
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
