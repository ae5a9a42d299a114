"""Classifies the word at the cursor: an option, its value, or an argument of a command.

It is read from the commands themselves: what they declare of their arguments and of the values
of their options, or else what the names of these say.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import click

from rtkit.cli.completion.candidates import Candidate
from rtkit.cli.shared.command import Main
from rtkit.cli.shared.commands import COMMANDS, load
from rtkit.cli.shared.group import CommandGroup
from rtkit.cli.shared.options import WatchOption

_BY_METAVAR: dict[str, str] = {
    "COMPONENT": "component",
    "DIR": "folder",
    "EC": "context",
    "FILE": "file",
    "FOLDER": "folder",
    "ID": "connector",
    "IDL": "file",
    "MANAGER": "manager",
    "NAME=VALUE": "parameter",
    "PATH": "anything:",
    "PORT": "port",
    "PROFILE": "profile",
    "SET": "set",
}
_ARGUMENT_METAVAR: dict[str, str] = {
    **_BY_METAVAR,
    "AFTER": "profile",
    "BEFORE": "profile",
    "FILE": "profile",
    "INPUT": "profile",
    "OUTPUT": "profile",
    "SYSTEM": "profile",
}


class CursorMeaning(NamedTuple):
    """Meaning of the word at the cursor.

    Attributes:
        command: Name of the command, with its word where it has words: ``rtprofile show``.
        kind: ``option``, ``words``, or a type of `argument_types`; empty for free text.
        typed: The word as far as it is typed; of ``--option=value`` only the value.
        front: Text before `typed` in the same word.
        arguments: The arguments before this one.
        options: First names of the options before it, with the values of those that have one.
        words: Words of that kind, where the command itself says them.
    """

    command: str
    kind: str
    typed: str
    front: str = ""
    arguments: tuple[str, ...] = ()
    options: dict[str, str] = {}  # noqa: RUF012 - never changed
    words: tuple[Candidate, ...] = ()


def ask(name: str, words: Sequence[str], typed: str) -> CursorMeaning | None:
    """Return the meaning of `typed` behind a command and `words`; None for a foreign command."""
    if name not in COMMANDS.values():
        return None
    main = load(name)
    before = _ask(name, main, words, typed)
    if not isinstance(main.command, CommandGroup):
        return before
    group = main.command
    if not before.arguments:
        choices = tuple(Candidate(word, group.summary(word)) for word in group.words)
        return before if before.kind == "option" else before._replace(kind="words", words=choices)
    word = before.arguments[0]
    if word not in group.words:
        return before._replace(kind="")
    rest = words[list(words).index(word) + 1 :]
    return _ask(f"{name} {word}", load(f"{name} {word}"), rest, typed)


def _ask(name: str, main: Main, words: Sequence[str], typed: str) -> CursorMeaning:
    options_known = (p for p in main.command.params if isinstance(p, click.Option))
    known = {each: option for option in options_known for each in option.opts}
    arguments: list[str] = []
    options: dict[str, str] = {}
    waiting: click.Option | None = None
    is_over = False
    for word in words:
        if waiting is not None:
            options[waiting.opts[0]] = word
            waiting = None
        elif is_over or not word.startswith("-") or word == "-":
            arguments.append(word)
        elif word == "--":
            is_over = True
        else:
            waiting = _option(word, known, options)
            if isinstance(waiting, WatchOption):
                waiting = None
    asked = CursorMeaning(name, "", typed, "", tuple(arguments), options)
    if waiting is not None:
        return _value(main, asked, waiting)
    if typed.startswith("-") and not is_over:
        front, equals, value = typed.partition("=")
        if equals and front in known:
            return _value(main, asked._replace(typed=value, front=f"{front}="), known[front])
        return asked._replace(kind="option", words=_options(main.command, name))
    candidates = tuple(Candidate(word) for word in main.words)
    return asked._replace(kind=_argument(main, len(arguments)), words=candidates)


def _option(
    word: str, known: dict[str, click.Option], options: dict[str, str]
) -> click.Option | None:
    """Note the options of a word, and return the last of them if its value is the next word."""
    if word.startswith("--"):
        name, equals, value = word.partition("=")
        option = known.get(name)
        if option is None:
            return None
        options[option.opts[0]] = value
        return None if equals or not _has_value(option) else option
    for place, letter in enumerate(word[1:], 2):
        option = known.get(f"-{letter}")
        if option is None:
            return None
        options[option.opts[0]] = word[place:] if _has_value(option) else ""
        if _has_value(option):
            return None if word[place:] else option
    return None


def _has_value(option: click.Option) -> bool:
    return not (option.is_flag or option.count)


def _value(main: Main, asked: CursorMeaning, option: click.Option) -> CursorMeaning:
    if isinstance(option.type, click.Choice):
        candidates = tuple(Candidate(str(each)) for each in option.type.choices)
        return asked._replace(kind="words", words=candidates)
    kind = main.values.get(option.opts[0])
    if kind is None:
        kind = _by_metavar(option.metavar or "", _BY_METAVAR)
    return asked._replace(kind=kind)


def _argument(main: Main, place: int) -> str:
    kinds = main.arguments
    if kinds is None:
        params = main.command.params
        metavars = [p.metavar or "" for p in params if isinstance(p, click.Argument)]
        words = " ".join(metavars).split()
        kinds = tuple(_by_metavar(word, _ARGUMENT_METAVAR) for word in words)
    return kinds[min(place, len(kinds) - 1)] if kinds else ""


def _by_metavar(metavar: str, kinds: dict[str, str]) -> str:
    """Return the kind that a metavar says: ``[FILE|FOLDER|-]...`` is a file."""
    plain = metavar.replace("[", "|").replace("]", "|").replace(".", "|").split("|")
    return next((kinds[word] for word in plain if word in kinds), "")


def _options(command: click.Command, name: str) -> tuple[Candidate, ...]:
    context = click.Context(command, info_name=name, **command.context_settings)
    candidates = []
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option):
            about = (parameter.help or "").partition(". ")[0].removesuffix(".")
            candidates += [Candidate(text, about) for text in parameter.opts]
    return tuple(candidates)
