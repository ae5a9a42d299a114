"""``rtconfig``: show settings, and the files and variables they are from."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import NamedTuple

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.defaults import of_command, settable, variable_of
from rtkit.cli.shared.options import arguments, flag, json_flag
from rtkit.errors import NotFound
from rtkit.settings.layer_file import SETTINGS
from rtkit.settings.layers import Layers, candidates

_WORDS = ("show", "files")


class _Row(NamedTuple):
    """A setting: `place` is the file, with its table, or the variable that has the value."""

    key: str
    value: str
    origin: str
    place: str


@command(
    "rtconfig",
    examples=(
        ("rtconfig show --origin", "All settings, and where each is from."),
        ("rtconfig files", "Which files count, the strongest first?"),
        ("rtconfig show rtls.json", "The default of rtls --json."),
    ),
    json=("setting", "settings-file"),
    arguments=("words", "setting"),
    words=_WORDS,
)
def main(
    app: App,
    has_origin: bool = flag("--origin", "Also where each is from."),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments("show|files [SETTING]..."),
) -> None:
    r"""Show settings, and the files and variables that they are from.

    A flag counts more than the environment, that more than rtkit.toml of the project (in this
    folder or above it), that more than rtkit/config.toml of the user (in XDG_CONFIG_HOME, else
    ~/.config), that more than rtkit/config.toml of the system (in XDG_CONFIG_DIRS, else /etc).

    \b
        manager = "robot"          # a setting of all commands, RTKIT_MANAGER
        module_path = ["modules"]  # from the folder of the file
        [rtls]
        json = true                # as rtls --json, RTKIT_RTLS_JSON

    Tables have the long options of a command without dashes, those of a word of rtprofile are
    named [rtprofile.check]. Unknown keys and wrong values are errors.
    """
    if not words or words[0] not in _WORDS:
        raise WrongArguments(no_such("word", words[0], _WORDS) if words else "show or files?")
    if words[0] == "files":
        _show_files(is_json)
        return
    rows = _chosen(list(_rows(app)), words[1:])
    if is_json:
        terminal.write(json_records.line("setting", row._asdict()) for row in rows)
    else:
        cells = [list(row if has_origin else row[:2]) for row in rows]
        terminal.write(terminal.table(cells))


def _rows(app: App) -> Iterator[_Row]:
    """Yield all settings, and those options of commands that have a default of the user's."""
    for setting in SETTINGS:
        layer = app.given.get(setting.key)
        value = os.environ.get(variable_of(setting.key))
        if layer is not None:
            yield _Row(setting.key, value or "", layer.origin, layer.file)
        elif value is not None:
            yield _Row(setting.key, value, "environment", variable_of(setting.key))
        else:
            yield _Row(setting.key, setting.default, "default", "")
    for name, each_command in _commands():
        for each in of_command(name, each_command, app.layers or Layers(), app.given):
            if each.place != "RTKIT_TIMEOUT":
                option = next(text[2:] for text in each.parameter.opts if text.startswith("--"))
                yield _Row(_key(name, option), _text(each.value), each.origin, each.place)


def _unset() -> Iterator[_Row]:
    """Yield all options that may have a default, as if none had."""
    for name, each_command in _commands():
        for option, parameter in settable(each_command).items():
            value = parameter.default is True if parameter.is_flag else parameter.default
            yield _Row(_key(name, option), _text(value), "default", "")


def _commands() -> Iterator[tuple[str, click.Command]]:
    from rtkit.cli.shared.commands import TABLE, load

    return ((name, load(name).command) for name in TABLE)


def _key(name: str, option: str) -> str:
    return f"{name.replace(' ', '.')}.{option}"


def _text(value: object) -> str:
    if isinstance(value, str | int | float):
        return str(value).lower() if isinstance(value, bool) else str(value)
    return ""


def _chosen(rows: list[_Row], keys: tuple[str, ...]) -> list[_Row]:
    known = {row.key: row for row in (*_unset(), *rows)} if keys else {}
    for key in keys:
        if key not in known:
            raise NotFound(no_such("setting", key, known))
    return [known[key] for key in keys] if keys else rows


def _show_files(is_json: bool) -> None:
    rows = [(origin, path, os.path.exists(path)) for origin, path in candidates()]
    if is_json:
        records = [{"origin": a, "path": b, "exists": c} for a, b, c in rows]
        terminal.write(json_records.lines("settings-file", records))
    else:
        cells = [[a, b if c else f"{b} (not there)"] for a, b, c in rows]
        terminal.write(terminal.table(cells))
