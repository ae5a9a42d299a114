"""What every command shares: common options, the connection to the tree, errors to exit statuses.

A command file declares its options and calls one room. It is a console script (``rtls``), a verb
of the unified tool (``rtkit ls``) and a function: ``main(["-l"], tree=some_tree)``.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import click

from rtkit.errors import Malformed, Partial, RtkitError

if TYPE_CHECKING:
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree

INTERRUPTED = 130
_SETTINGS = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


class App:
    """One run of a command.

    Attributes:
        timeout_s: Bound on every call [s].
        is_verbose: Tell progress on stderr, and tracebacks.
    """

    def __init__(self, name: str, tree: Tree | None = None) -> None:
        self.name = name
        self.timeout_s = 10.0
        self.is_verbose = False
        self.has_exit_detail = bool(os.environ.get("RTKIT_EXIT_DETAIL"))
        self._tree = tree
        self._is_own_tree = tree is None

    @property
    def tree(self) -> Tree:
        """The connection to the manager, made at first use."""
        if self._tree is None:
            from rtkit.tree.client import connect

            self._tree = connect(timeout_s=self.timeout_s)
        return self._tree

    def path(self, typed: str) -> Path:
        """Read a path as typed, relative to the working directory in the tree."""
        from rtkit.rtc.names import parse_path

        cwd = os.environ.get("RTKIT_CWD") or os.environ.get("RTCSH_CWD") or "/"
        return parse_path(typed, cwd)

    def say(self, text: str) -> None:
        """Write one line on stderr."""
        click.echo(text, err=True)

    def fail(self, text: str) -> None:
        """Write one line on stderr behind the command's name."""
        self.say(f"{self.name}: {text}")

    def tell(self, text: str) -> None:
        """Write progress on stderr when asked to be verbose."""
        if self.is_verbose:
            self.say(text)

    def close(self) -> None:
        """End the connection that this run made."""
        if self._is_own_tree and self._tree is not None:
            self._tree.close()
            self._tree = None


class WrongArguments(Malformed):
    """The number of arguments is wrong: the usage is shown, the exit status is 1."""


pass_app = click.make_pass_decorator(App)


class Main:
    """A command as console script and as function."""

    def __init__(self, name: str, command: click.Command) -> None:
        self.name = name
        self.command = command

    def __call__(
        self, argv: Sequence[str] | None = None, tree: Tree | None = None, name: str = ""
    ) -> int:
        """Run with these arguments and return the exit status."""
        typed = name or (os.path.basename(sys.argv[0]) if argv is None else self.name)
        app = App(typed, tree)
        arguments = list(sys.argv[1:] if argv is None else argv)
        try:
            return _run(self.command, app, arguments)
        finally:
            app.close()


def command(
    name: str, **settings: Any
) -> Callable[[Callable[..., int | None]], Main]:
    """Turn a function that takes an `App` and its options into a command."""

    def decorate(function: Callable[..., int | None]) -> Main:
        wrapped = pass_app(function)
        for option in _common_options():
            wrapped = option(wrapped)
        made = click.command(name=name, context_settings=_SETTINGS, **settings)(wrapped)
        return Main(name, made)

    return decorate


def _common_options() -> list[Callable[[Any], Any]]:
    return [
        click.option(
            "--exit-detail",
            is_flag=True,
            expose_value=False,
            callback=_set("has_exit_detail"),
            help="Tell kinds of failure apart by exit status.",
        ),
        click.option(
            "--timeout",
            type=click.FloatRange(min=0.01),
            metavar="SECONDS",
            expose_value=False,
            callback=_set("timeout_s"),
            help="Bound on every call (default 10).",
        ),
        click.option(
            "-v",
            "--verbose",
            is_flag=True,
            expose_value=False,
            callback=_set("is_verbose"),
            help="Tell progress on stderr; on failure also a traceback.",
        ),
        click.option(
            "--version",
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_show_version,
            help="Show the version and exit.",
        ),
    ]


def _set(attribute: str) -> Callable[[click.Context, click.Parameter, Any], None]:
    def store(context: click.Context, _parameter: click.Parameter, value: Any) -> None:
        if value:
            setattr(context.obj, attribute, value)

    return store


def _show_version(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        from rtkit import __version__

        click.echo(f"rtkit {__version__}")
        context.exit(0)


def _run(command: click.Command, app: App, arguments: list[str]) -> int:
    try:
        status = command.main(arguments, prog_name=app.name, standalone_mode=False, obj=app)
        sys.stdout.flush()
        return int(status or 0)
    except click.UsageError as error:
        error.show()
        return error.exit_code
    except WrongArguments as error:
        _show_usage(command, app, error)
        return error.detail if app.has_exit_detail else error.exit_code
    except RtkitError as error:
        _show(app, error)
        return error.detail if app.has_exit_detail else error.exit_code
    except (click.Abort, KeyboardInterrupt):
        app.fail("interrupted")
        return INTERRUPTED
    except BrokenPipeError:
        _leave_pipe()
        return 128 + 13


def _show(app: App, error: RtkitError) -> None:
    if app.is_verbose:
        import traceback

        traceback.print_exception(error)
    app.fail(str(error))
    if isinstance(error, Partial):
        for _, failure in error.failures:
            app.fail(str(failure))


def _show_usage(command: click.Command, app: App, error: WrongArguments) -> None:
    context = click.Context(command, info_name=app.name)
    app.say(command.get_usage(context))
    if str(error):
        app.fail(str(error))


def _leave_pipe() -> None:
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
