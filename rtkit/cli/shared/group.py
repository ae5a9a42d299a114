"""Groups subcommands, ``rtprofile validate``: one module each, imported when it is typed."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import NamedTuple

import click

from rtkit.cli.shared.app import SETTINGS, App, Main, WrongArguments, common_options
from rtkit.errors import UsageProblem


class Subcommand(NamedTuple):
    """A word of a command.

    Attributes:
        module: The module whose `main` it runs.
        summary: The first sentence of its help.
    """

    module: str
    summary: str


class CommandGroup(click.Group):
    """Looks its words up in a table, so that listing them imports none of them."""

    def __init__(self, name: str, words: Mapping[str, Subcommand], help_text: str) -> None:
        super().__init__(
            name,
            help=help_text,
            params=[*common_options(is_local=True)],
            callback=_nothing,
            invoke_without_command=True,
            no_args_is_help=False,
            subcommand_metavar="COMMAND [ARGS]...",
            context_settings=SETTINGS,
            add_help_option=False,
        )
        self.words = dict(words)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the words in the order of the table."""
        return list(self.words)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a word."""
        word = self.words.get(cmd_name)
        if word is None:
            return None
        main: Main = importlib.import_module(word.module).main
        return main.command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the words with their summaries."""
        with formatter.section("Commands"):
            formatter.write_dl([(word, each.summary) for word, each in self.words.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; its messages carry its full name from here on."""
        app: App = ctx.obj
        typed = args[0]
        found = self.get_command(ctx, typed)
        if found is None:
            from rtkit.rtc.nearest import did_you_mean

            hint = did_you_mean(typed, self.words) or f" (one of {', '.join(self.words)})"
            raise UsageProblem(f"no such command: {typed}{hint}")
        app.name = f"{app.name} {typed}"
        app.command = found
        return typed, found, args[1:]


def group(name: str, words: Mapping[str, Subcommand], help_text: str) -> Main:
    """Return the command that has these words."""
    return Main(name, CommandGroup(name, words, help_text))


@click.pass_context
def _nothing(context: click.Context) -> None:
    if context.invoked_subcommand is None:
        raise WrongArguments("No command specified.")
