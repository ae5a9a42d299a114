"""The option ``-t``: bounds the duration of a command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

from rtkit.cli.shared.choice import NumberChoice

F = TypeVar("F", bound=Callable[..., Any])


def lasting(text: str = "Stop after this time.", long: str = "--timeout") -> Callable[[F], F]:
    """Add ``-t``, as `duration_s`: a time above zero [s], None if it was not given."""
    return click.option(
        "-t",
        long,
        "duration_s",
        type=NumberChoice(min=0.0, min_open=True),
        metavar="SECONDS",
        help=text,
    )
