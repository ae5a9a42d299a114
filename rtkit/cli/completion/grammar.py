"""Classifies the word at the cursor: an option, its value, or an argument of a command.

It is read from the commands themselves, so a new one is completed without being told here; only
what an argument's name does not say has a row in `ARGUMENTS` or `VALUES`.
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import NamedTuple

import click

from rtkit.cli import COMMANDS, load
from rtkit.cli.completion.candidates import Candidate
from rtkit.cli.shared.group import CommandGroup

ARGUMENTS: dict[str, tuple[str, ...]] = {
    "rtact": ("inactive",),
    "rtcat": ("anything:",),
    "rtcomp": ("manager|component",),
    "rtcon": ("port", "fitting"),
    "rtconf": ("component|manager", "word", "conf"),
    "rtcryo": ("host",),
    "rtcwd": ("directory",),
    "rtdeact": ("active",),
    "rtdel": ("deletable",),
    "rtdis": ("connected", "connected-to"),
    "rtdoc": ("component",),
    "rtdoctor": (),
    "rtexit": ("component|slave",),
    "rtfind": ("directory",),
    "rtfsm": ("component", "word"),
    "rtget": ("live",),
    "rtinject": ("in-port",),
    "rtlisten": ("live",),
    "rtlog": ("out-port",),
    "rtls": ("anything",),
    "rtmgr": ("manager|word", "manager-name"),
    "rtprint": ("out-port",),
    "rtprofile from": ("module",),
    "rtprofile new": ("component-or-system",),
    "rtproxy": ("live", "live"),
    "rtpwd": (),
    "rtreset": ("faulty",),
    "rtserve": ("class", ""),
    "rtset": ("live", "value", ""),
    "rtstodot": ("profile",),
    "rttop": ("anything",),
    "rtvlog": ("anything",),
    "rtwait": ("waited-for",),
    "rtwatch": ("anything",),
}
"""Types of the arguments of a command, the last one for all that follow."""

VALUES: dict[tuple[str, str], str] = {
    ("rtcomp", "-a"): "component:",
    ("rtcomp", "-r"): "component:",
    ("rtcomp", "-t"): "composite-type",
    ("rtcon", "-i"): "",
    ("rtcon", "-p"): "connector-property",
    ("rtmgr", "-c"): "type",
    ("rtmgr", "-d"): "instance",
    ("rtmgr", "-l"): "module",
    ("rtmgr", "-s"): "property",
    ("rtmgr", "-u"): "loaded-module",
}
"""Type of an option's value, by the option's first name."""

_GLUED = {("rtls", "--watch")}
"""Options that take a value only behind ``=``."""

_BY_METAVAR: dict[str, str] = {
    "COMPONENT": "component",
    "DIR": "folder",
    "EC": "context",
    "FILE": "file",
    "FOLDER": "folder",
    "ID": "connector",
    "IDL": "file",
    "MANAGER": "manager",
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
        kind: ``option``, ``words``, or what of `ARGUMENTS` and `VALUES`; empty for free text.
        typed: The word as far as it is typed; of ``--option=value`` only the value.
        front: What stands before `typed` in the same word.
        arguments: The arguments before this one.
        options: First names of the options before it, with the values of those that have one.
        words: What the words of that kind are, where the command itself says it.
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
    command = load(name).command
    if not isinstance(command, CommandGroup):
        return _ask(name, command, words, typed)
    before = _ask(name, command, words, typed)
    if not before.arguments:
        told = tuple(Candidate(word, each.summary) for word, each in command.words.items())
        return before if before.kind == "option" else before._replace(kind="words", words=told)
    word = command.words.get(before.arguments[0])
    if word is None:
        return before._replace(kind="")
    inner: click.Command = importlib.import_module(word.module).main.command
    rest = words[list(words).index(before.arguments[0]) + 1 :]
    return _ask(f"{name} {before.arguments[0]}", inner, rest, typed)


def _ask(name: str, command: click.Command, words: Sequence[str], typed: str) -> CursorMeaning:
    known = {each: p for p in command.params if isinstance(p, click.Option) for each in p.opts}
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
            if waiting is not None and (name, waiting.opts[0]) in _GLUED:
                waiting = None
    asked = CursorMeaning(name, "", typed, "", tuple(arguments), options)
    if waiting is not None:
        return _value(asked, waiting)
    if typed.startswith("-") and not is_over:
        front, equals, value = typed.partition("=")
        if equals and front in known:
            return _value(asked._replace(typed=value, front=f"{front}="), known[front])
        return asked._replace(kind="option", words=_options(command, name))
    return asked._replace(kind=_argument(name, command, len(arguments)))


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


def _value(asked: CursorMeaning, option: click.Option) -> CursorMeaning:
    if isinstance(option.type, click.Choice):
        told = tuple(Candidate(str(each)) for each in option.type.choices)
        return asked._replace(kind="words", words=told)
    kind = VALUES.get((asked.command, option.opts[0]))
    if kind is None:
        kind = _by_metavar(option.metavar or "", _BY_METAVAR)
    return asked._replace(kind=kind)


def _argument(name: str, command: click.Command, place: int) -> str:
    kinds = ARGUMENTS.get(name)
    if kinds is None:
        metavars = [p.metavar or "" for p in command.params if isinstance(p, click.Argument)]
        words = " ".join(metavars).split()
        kinds = tuple(_by_metavar(word, _ARGUMENT_METAVAR) for word in words)
    return kinds[min(place, len(kinds) - 1)] if kinds else ""


def _by_metavar(metavar: str, kinds: dict[str, str]) -> str:
    """Return the kind that a metavar says: ``[FILE|FOLDER|-]...`` is a file."""
    plain = metavar.replace("[", "|").replace("]", "|").replace(".", "|").split("|")
    return next((kinds[word] for word in plain if word in kinds), "")


def _options(command: click.Command, name: str) -> tuple[Candidate, ...]:
    context = click.Context(command, info_name=name, **command.context_settings)
    told = []
    for parameter in command.get_params(context):
        if isinstance(parameter, click.Option):
            about = (parameter.help or "").partition(". ")[0].removesuffix(".")
            told += [Candidate(text, about) for text in parameter.opts]
    return tuple(told)
