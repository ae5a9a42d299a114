"""Turns functions into commands: what they declare, common options, errors to exit statuses.

A command file declares its options and calls one room. It is a console script (``rtls``), a verb
of the unified tool (``rtkit ls``) and a function: ``main(["-l"], tree=some_tree)``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn, TypeGuard

import click

from rtkit.cli.shared import console_process
from rtkit.cli.shared.app import App
from rtkit.cli.shared.options import NumberChoice, flag, gathered, made_of, option, setting

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

SETTINGS = {"max_content_width": 100}
_SHOWN_EXAMPLES = 2
_WIDEST_EXAMPLE = 48

Examples = Sequence[tuple[str, str]]
"""Command lines, each with what it does."""


class Main(NamedTuple):
    """A command as console script and as function, with what it declares of itself.

    Attributes:
        name: Name of the console script; of a subcommand its word.
        command: Its options and what it does.
        examples: Lines for manual page and tests; ``-h`` ends with the first two.
        json: Kinds of the records that ``--json`` writes.
        arguments: Types of the arguments for TAB, the last one for all that follow; None for
            what their names say. `rtkit.cli.completion.argument_types` lists them.
        values: Types of values, by the first name of the option, where its metavar says none.
        words: The words of an argument that is one of a few.
        statuses: Meanings of exit statuses, where they differ from those of all commands.
    """

    name: str
    command: click.Command
    examples: Examples = ()
    json: Sequence[str] = ()
    arguments: Sequence[str] | None = None
    values: Mapping[str, str] = MappingProxyType({})
    words: Iterable[str] = ()
    statuses: Mapping[str, str] = MappingProxyType({})

    def __call__(
        self, argv: Sequence[str] | None = None, tree: Tree | None = None, name: str = ""
    ) -> int:
        """Run with these arguments and return the exit status.

        Without arguments this is the console script: those of the process are taken.
        """
        if argv is None:
            return self.as_script(sys.argv[1:], os.path.basename(sys.argv[0]))
        return _run(self.command, App(name or self.name, tree), list(argv))

    def as_script(self, arguments: Sequence[str], name: str) -> NoReturn:
        """Run as the only purpose of this process, and end the process."""
        console_process.prepare()
        try:
            console_process.enable_interrupts()
            status = _run(self.command, App(name), list(arguments), is_script=True)
            if status != console_process.INTERRUPTED:
                console_process.end(status)
        except KeyboardInterrupt:
            pass  # the error is already reported
        console_process.die_interrupted()


def command(
    name: str,
    *,
    examples: Examples = (),
    is_local: bool = False,
    cls: type[click.Command] = click.Command,
    help: str | None = None,
    **declared: Any,
) -> Callable[[Callable[..., int | None]], Main]:
    """Turn a function that takes an `App` and its options into a command.

    The default of each other parameter is an option (`rtkit.cli.shared.options`). A command that
    `is_local` asks no manager. `Main` explains the fields of `declared`; the settings between are
    those of click. The first sentence of the docstring is the summary.
    """

    def decorate(function: Callable[..., int | None]) -> Main:
        names = function.__code__.co_varnames[1 : function.__code__.co_argcount]
        parameters = dict(zip(names, function.__defaults__ or (), strict=True))

        def called(**values: Any) -> int | None:
            app = click.get_current_context().obj
            return function(app, **gathered(parameters, values))

        made = cls(
            name,
            context_settings=SETTINGS,
            add_help_option=False,
            params=list(made_of(parameters)),
            callback=called,
            help=help or function.__doc__,
        )
        own = {text for each in made.params for text in each.opts}
        offered = common_options(examples, is_local=is_local)
        for common in offered:
            common.opts = [each for each in common.opts if each not in own]
        made.params += [common for common in offered if common.opts]
        for each in filter(_is_repeatable, made.params):
            each.help = f"{(each.help or '').removesuffix('.')}; repeatable."
        # Click's mark of text that must not be re-wrapped, as a raw docstring has it.
        made.help = made.help and made.help.replace("\\b\n", "\b\n")
        return Main(name, made, examples=examples, **declared)

    return decorate


def _is_repeatable(parameter: click.Parameter) -> TypeGuard[click.Option]:
    """Return whether an option may be given several times, and does not say so itself."""
    is_option = isinstance(parameter, click.Option) and not parameter.is_flag
    return is_option and parameter.multiple and "repeatable" not in (parameter.help or "")


def common_options(examples: Examples, *, is_local: bool = False) -> list[click.Parameter]:
    """Return the options that every command has; one that asks nobody needs no time-out."""
    timeout = option(
        "--timeout SECONDS",
        "Bound on every call (default 10); what was not begun by then is not done later.",
        NumberChoice(min=0.01),
        **setting("timeout_s"),
    )
    shown = {"is_eager": True, "expose_value": False}
    options = {
        **({} if is_local else {"timeout": timeout}),
        "exit_detail": flag(
            "--exit-detail",
            "Tell kinds of failure apart by exit status.",
            **setting("has_exit_detail"),
        ),
        "verbose": flag(
            "-v --verbose",
            "Tell progress on stderr; on failure also a traceback.",
            **setting("is_verbose"),
        ),
        "version": flag("--version", "Show the version and exit.", callback=_show_version, **shown),
        # Click's own option looks up a translation of this text at each start of a command.
        "help": flag(
            "-h --help",
            "Show this message and exit.",
            callback=partial(_show_help, examples),
            **shown,
        ),
    }
    return list(made_of(options))


def _show_version(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        from rtkit import __version__

        click.echo(f"rtkit {__version__}")
        context.exit(0)


def _show_help(
    examples: Examples, context: click.Context, _parameter: click.Parameter, value: bool
) -> None:
    if value and not context.resilient_parsing:
        formatter = context.make_formatter()
        context.command.format_help(context, formatter)
        if examples:
            with formatter.section("Examples"):
                formatter.write_dl(examples[:_SHOWN_EXAMPLES], col_max=_WIDEST_EXAMPLE)
        click.echo(formatter.getvalue().rstrip("\n"), color=context.color)
        context.exit(0)


def _run(command: click.Command, app: App, arguments: list[str], *, is_script: bool = False) -> int:
    try:
        return _guarded(command, app, arguments, is_script)
    except KeyboardInterrupt as error:
        app.fail(f"interrupted; {error}" if str(error) else "interrupted")
        return console_process.INTERRUPTED


def _guarded(command: click.Command, app: App, arguments: list[str], is_script: bool) -> int:
    try:
        try:
            if is_script:
                app.read_settings()
            status = _invoke(command, app, arguments)
        finally:
            app.close()
        sys.stdout.flush()
    except BrokenPipeError:
        console_process.leave_pipe()
        return console_process.BROKEN_PIPE
    except Exception as error:
        from rtkit.cli.shared.failures import failed

        status = failed(command, app, error)
        console_process.give_up()
    return status


def _invoke(command: click.Command, app: App, arguments: list[str]) -> int:
    # Not Command.main: that one swallows a broken pipe and writes a line of its own on Ctrl-C.
    try:
        defaults = app.defaults(command.name or "", command)
        with command.make_context(app.name, arguments, obj=app, default_map=defaults) as context:
            status = int(command.invoke(context) or 0)
            return app.missed or status
    except click.exceptions.Exit as leaving:
        return leaving.exit_code
