"""Reports the error that ended a command, and finds its exit status; imported on failure only."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rtkit.cli.shared.app import WrongArguments
from rtkit.errors import BUG_EXIT, Impossible, InvalidDocument, Partial, RtkitError

if TYPE_CHECKING:
    from rtkit.cli.shared.app import App


def failed(command: click.Command, app: App, error: Exception) -> int:
    """Report an error on stderr, and return the exit status that stands for it."""
    if app.is_verbose and not isinstance(error, click.UsageError | Impossible):
        import traceback

        app.report("".join(traceback.format_exception(error)).rstrip())
    if isinstance(error, click.UsageError | WrongArguments):
        meant = app.command or command
        app.report(meant.get_usage(click.Context(meant, info_name=app.name)))
    if isinstance(error, click.ClickException):
        app.fail(error.format_message())
        return 1 if _lacks_argument(error) else error.exit_code
    if isinstance(error, RtkitError):
        _show(app, error)
        return app.status(error)
    if isinstance(error, OSError):
        place = f": {error.filename}" if error.filename else ""
        app.fail(f"{error.strerror or error}{place}")
        return 1
    hint = "" if app.is_verbose else "; -v shows where"
    app.fail(f"{type(error).__name__}: {error}; this is a bug in rtkit{hint}")
    return BUG_EXIT if app.has_exit_detail else 1


def _lacks_argument(error: click.ClickException) -> bool:
    """Return whether the error is the number of arguments, as with `WrongArguments`."""
    return isinstance(error, click.MissingParameter) and isinstance(error.param, click.Argument)


def _show(app: App, error: RtkitError) -> None:
    if isinstance(error, Partial):
        for _, failure in error.failures:
            app.fail(str(failure))
    # A document may have many faults, a line each; any other message is one line.
    lines = str(error).split("\n") if isinstance(error, InvalidDocument) else [str(error)]
    for line in filter(None, lines):
        app.fail(line)
