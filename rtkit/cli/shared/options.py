"""Declares options and arguments of commands, each as the default of the parameter that takes it.

``number: int | None = option("-n --number N", "Stop after N.", COUNT)`` is an option and the
parameter of its value; several set one parameter (`either`), or go together as the fields of a
record (`together`). Types of values are words out of a few, taken in any case of letters, with a
suggestion for a misspelt one, and finite numbers: neither ``nan`` nor infinity, to which
``1e400`` overflows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import click

Declared = Mapping[str, Any]
"""Options and arguments, by the names of their parameters."""


class DeclaredOption(NamedTuple):
    """An option or argument whose parameter is not known yet."""

    kind: type[click.Parameter]
    names: tuple[str, ...]
    settings: dict[str, Any]

    def made(self, name: str) -> click.Parameter:
        """Return the option or argument that sets a parameter of this name."""
        settings = dict(self.settings)
        text = settings.pop("help", None)
        parameter = self.kind([*self.names, name], **settings)
        if isinstance(parameter, click.Option):
            parameter.help = text  # click would have it tidied, by a module that takes 5 ms
        return parameter


class Together(NamedTuple):
    """Options whose values one parameter takes: `make` gets them by name, None takes none."""

    make: Callable[..., Any] | None
    declared: Declared


def option(
    form: str, text: str, type: Any = None, kind: type[click.Option] = click.Option, **more: Any
) -> Any:
    """Return an option in the form of its help, ``"-n --number N"``; `more` is for click."""
    names = form.split()
    metavar = None if names[-1].startswith("-") else names.pop()
    return DeclaredOption(
        kind, tuple(names), {"metavar": metavar, "help": text, "type": type, **more}
    )


def flag(form: str, text: str, **more: Any) -> Any:
    """Return an option without a value, which is given or not."""
    return option(form, text, is_flag=True, **more)


def several(form: str, text: str, **more: Any) -> Any:
    """Return an option that may be given several times."""
    return option(form, text, multiple=True, **more)


def arguments(metavar: str) -> Any:
    """Return all arguments of a command; it says itself how many there must be."""
    return DeclaredOption(click.Argument, (), {"nargs": -1, "metavar": metavar})


def argument(metavar: str | None, **settings: Any) -> Any:
    """Return one argument."""
    return DeclaredOption(click.Argument, (), {"metavar": metavar, **settings})


def either(*options: Any) -> Any:
    """Return options that set the same parameter."""
    return options


def together(record: Any, declared: Declared | None = None) -> Any:
    """Return options whose values one parameter takes: the fields of a record, or those declared.

    Without a record it takes None, as the options do something of their own.
    """
    return Together(record, record._field_defaults if declared is None else declared)


def made_of(declared: Declared) -> Iterator[click.Parameter]:
    """Yield the options and arguments that are declared."""
    for name, each in declared.items():
        if isinstance(each, Together):
            yield from made_of(each.declared)
        else:
            yield from (one.made(name) for one in (each if type(each) is tuple else (each,)))


def gathered(declared: Declared, values: dict[str, Any]) -> dict[str, Any]:
    """Return what the parameters take, for the values of all options and arguments."""
    taken: dict[str, Any] = {}
    for name, each in declared.items():
        if isinstance(each, Together):
            inner = gathered(each.declared, values)
            taken[name] = each.make(**inner) if each.make is not None else None
        else:
            taken[name] = values.get(name)
    return taken


def setting(attribute: str, value: Any = None) -> dict[str, Any]:
    """Return what has an option set an attribute of the run, to a value or to its own."""

    def store(context: click.Context, _parameter: click.Parameter, given: Any) -> None:
        if given:
            setattr(context.obj, attribute, given if value is None else value)

    return {"expose_value": False, "callback": store}


def strict_option(text: str = "Take warnings for errors.") -> Any:
    """Return the option to take warnings for errors; the run knows it."""
    return flag("--strict", text, **setting("is_strict"))


def json_flag(text: str = "One JSON object a line.") -> Any:
    """Return the option to write records for other programs."""
    return flag("--json", text)


class WordChoice(click.Choice[str]):
    """One of these words, which are capitals; a dash stands for an underscore.

    Args:
        what: Noun for them in a message: ``level``.
        words: The words.
        is_short: The beginning of a word is enough.
    """

    def __init__(self, what: str, words: Sequence[str], *, is_short: bool = False) -> None:
        super().__init__(words)
        self._what = what
        self._is_short = is_short

    def get_missing_message(self, param: click.Parameter, ctx: click.Context | None) -> str:
        """Return what is told where none is given, on the same line."""
        return f"Known: {', '.join(self.choices)}"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """Return the word that is meant."""
        typed = str(value).casefold()
        for word in self.choices:
            known = word.casefold()
            if typed in (known, known.replace("_", "-")):
                return word
            if self._is_short and typed and known.startswith(typed):
                return word
        from rtkit.rtc.nearest import did_you_mean

        hint = did_you_mean(str(value), self.choices)
        self.fail(f"unknown {self._what}: {value}{hint}; known: {', '.join(self.choices)}")


class NumberChoice(click.FloatRange):
    """A number within bounds, as `click.FloatRange`, and finite."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number that was typed."""
        number: float = super().convert(value, param, ctx)
        if number - number != 0.0:
            self.fail(f"{value!r} is not a finite number.", param, ctx)
        return number


POSITIVE = NumberChoice(min=0.0, min_open=True)
COUNT = click.IntRange(min=1)


def insecure_flag() -> Any:
    """Return ``--insecure``."""
    return flag("--insecure", "Talk with other hosts without TLS, too; every rtls -l shows it.")


def lasting(text: str = "Stop after this time.", long: str = "--timeout") -> Any:
    """Return ``-t``: a time above zero [s], None if it was not given."""
    return option(f"-t {long} SECONDS", text, POSITIVE)


_GUARD = "\0"


class NumbersAreArguments(click.Command):
    """Takes ``-1.5`` for an argument, not for an option.

    Attributes:
        behind: The word behind which it does so; empty for everywhere.
    """

    behind = ""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Hide the minus from the parser by a mark that no argument of a process can contain."""
        start = 0 if not self.behind else args.index(self.behind) if self.behind in args else None
        late = args[start:] if start is not None else []
        guarded = [_GUARD + arg if _is_negative(arg) else arg for arg in late]
        rest = super().parse_args(ctx, args[: len(args) - len(late)] + guarded)
        for name, value in ctx.params.items():
            if isinstance(value, tuple):
                ctx.params[name] = tuple(word.removeprefix(_GUARD) for word in value)
        return rest


def _is_negative(argument: str) -> bool:
    return argument[:1] == "-" and (argument[1:2].isdigit() or argument[1:2] == ".")


class WatchOption(click.Option):
    """``--watch``, which takes seconds behind ``=`` only, and shows that."""

    def get_help_record(self, ctx: click.Context) -> tuple[str, str] | None:
        """Return the option with its value as optional."""
        record = super().get_help_record(ctx)
        return record and (record[0].replace(" SECONDS", "[=SECONDS]"), record[1])


class MayWatch(click.Command):
    """Takes ``--watch`` with or without ``=SECONDS``, never the next argument."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Give the bare option its value, then parse as usual."""
        end = args.index("--") if "--" in args else len(args)
        options = ["--watch=1" if each == "--watch" else each for each in args[:end]]
        return super().parse_args(ctx, options + args[end:])


def watch_option(text: str) -> Any:
    """Return ``--watch`` for a command of the class `MayWatch`."""
    return option("--watch SECONDS", text, NumberChoice(min=0.05), WatchOption)
