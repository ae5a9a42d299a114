"""Groups subcommands, ``rtprofile validate``: one module each, imported when it is typed."""

from __future__ import annotations

from collections.abc import Sequence

import click

from rtkit.cli.shared.app import App, WrongArguments, no_such
from rtkit.cli.shared.command import SETTINGS, Examples, Main, common_options
from rtkit.cli.shared.commands import TABLE, load
from rtkit.errors import UsageProblem


class CommandGroup(click.Group):
    """Looks its words up in the table, so that listing them imports none of them.

    Attributes:
        words: The words, in the order of the help.
    """

    def __init__(self, name: str, words: Sequence[str], help_text: str, examples: Examples) -> None:
        super().__init__(
            name,
            help=help_text,
            params=common_options(examples, is_local=True),
            callback=_nothing,
            invoke_without_command=True,
            no_args_is_help=False,
            subcommand_metavar="COMMAND [ARGS]...",
            context_settings=SETTINGS,
            add_help_option=False,
        )
        self.words = words

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the words in the order of the help."""
        return list(self.words)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command of a word."""
        return load(f"{self.name} {cmd_name}").command if cmd_name in self.words else None

    def summary(self, word: str) -> str:
        """Return the first sentence of the help about a word."""
        return TABLE[f"{self.name} {word}"][1]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the words with their summaries."""
        with formatter.section("Commands"):
            formatter.write_dl([(word, self.summary(word)) for word in self.words])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; its messages carry its full name from here on."""
        app: App = ctx.obj
        typed = args[0]
        found = self.get_command(ctx, typed)
        if found is None:
            raise UsageProblem(no_such("command", typed, self.words))
        app.name = f"{app.name} {typed}"
        app.command = found
        ctx.default_map = {typed: app.defaults(f"{self.name} {typed}", found)}
        return typed, found, args[1:]


def group(name: str, help_text: str, words: Sequence[str], *, examples: Examples) -> Main:
    """Return the command that has these words; `rtkit.cli.table` knows their modules."""
    return Main(name, CommandGroup(name, words, help_text, examples), examples=examples)


@click.pass_context
def _nothing(context: click.Context) -> None:
    if context.invoked_subcommand is None:
        raise WrongArguments("No command specified.")
