"""Finds the values of options that nobody typed: in the environment, and in files of settings.

``RTKIT_RTLS_TIMEOUT``, and ``timeout`` of the table ``[rtls]``, stand for ``rtls --timeout``;
``RTKIT_TIMEOUT``, and ``timeout`` above all tables, for that of each command.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

import click

from rtkit.errors import Malformed
from rtkit.settings.layer_file import Options, SettingsFile
from rtkit.settings.layers import PREFIX, Layers

_OF_ALL = ("timeout",)
_NOT_SET = ("help", "version")


class Default(NamedTuple):
    """The value of an option, and where it is from: ``environment`` or a layer; and its name."""

    parameter: click.Option
    value: Any
    origin: str
    place: str


def settable(command: click.Command) -> dict[str, click.Option]:
    """Return the options that may have a default, by their long names without dashes.

    Not those that are given several times, and not those of which only one may be given.
    """
    names = Counter(each.name for each in command.params)
    found = {}
    for each in command.params:
        if isinstance(each, click.Option) and not each.multiple and names[each.name] == 1:
            long = [text[2:] for text in each.opts if text.startswith("--")]
            found.update({name: each for name in long if name not in _NOT_SET})
    return found


def of_command(
    name: str, command: click.Command, layers: Layers, given: Collection[str] = ()
) -> Iterator[Default]:
    """Yield the defaults of a command, ``rtls`` or ``rtprofile show``: each from where it counts.

    The settings `given` are those of all commands that a file has put into the environment.

    Raises:
        Malformed: A value or a name is wrong; names its place.
    """
    options = settable(command)
    title = f"[{name.replace(' ', '.')}]"
    tables = [(each, _table(each, name, title)) for each in layers.files]
    for layer, table in tables:
        _check_names(table, command, options, f"{layer.file}: {title}")
    for option, parameter in options.items():
        found = [_of_variable(f"{name} {option}", parameter)]
        of_all = _of_variable(option, parameter) if option in _OF_ALL else None
        found.append(of_all if option not in given else None)
        for layer, table in tables:
            if option in table:
                place = f"{layer.file}: {title} {option}"
                found.append(Default(parameter, table[option], layer.origin, place))
        for default in filter(None, (*found, of_all)):
            yield _checked(default)
            break


def variable_of(words: str) -> str:
    """Return the variable for an option: ``rtls max-time`` has RTKIT_RTLS_MAX_TIME."""
    return PREFIX + words.upper().replace(" ", "_").replace("-", "_")


def _of_variable(words: str, parameter: click.Option) -> Default | None:
    variable = variable_of(words)
    value = os.environ.get(variable)
    return Default(parameter, value, "environment", variable) if value else None


def _table(layer: SettingsFile, name: str, title: str) -> Options:
    commands = layer.commands
    for word in name.split():
        commands = commands.get(word, {})
        if not isinstance(commands, dict):
            raise Malformed(f"{layer.file}: {title}: not a table")
    return commands


def _check_names(
    table: Options, command: click.Command, options: dict[str, click.Option], place: str
) -> None:
    words: list[str] = []
    if isinstance(command, click.Group):
        words = command.list_commands(click.Context(command))
    for key in table:
        if key not in options and key not in words:
            from rtkit.rtc.nearest import did_you_mean

            raise Malformed(
                f"{place}: unknown option: {key}{did_you_mean(key, [*options, *words])}"
            )


def _checked(default: Default) -> Default:
    parameter, value = default.parameter, default.value
    try:
        if isinstance(value, bool) is not parameter.is_flag and not isinstance(value, str):
            raise click.BadParameter("true or false are wanted" if parameter.is_flag else "no text")
        text = value if isinstance(value, bool) else str(value)
        parameter.type_cast_value(click.Context(click.Command("")), text)
    except click.BadParameter as error:
        raise Malformed(f"{default.place}: {error.message}") from None
    return default._replace(value=text)


def default_map(
    name: str, command: click.Command, layers: Layers, given: Collection[str]
) -> dict[str, Any]:
    """Return the defaults as click takes them; those of words stand in maps of their own.

    Raises:
        Malformed: A value or a name is wrong; names its place.
    """
    found = of_command(name, command, layers, given)
    return {str(each.parameter.name): each.value for each in found}
