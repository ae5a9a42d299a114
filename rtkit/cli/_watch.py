"""``--watch``: show the same again and again."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import click

from rtkit.cli import _out

CLEAR = "\x1b[H\x1b[2J"
"""What a terminal takes to show nothing."""


class MayWatch(click.Command):
    """Takes ``--watch`` with or without ``=SECONDS``, never the next argument."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        end = args.index("--") if "--" in args else len(args)
        options = ["--watch=1" if each == "--watch" else each for each in args[:end]]
        return super().parse_args(ctx, options + args[end:])


def watch(look: Callable[[], Iterable[str]], period_s: float, gap: str) -> None:
    """Show again and again: on a terminal in place of the last time, else what is new."""
    import sys
    import time

    before = None
    while True:
        lines = list(look())
        if _out.is_terminal():
            sys.stdout.write(CLEAR)
            _out.write(lines)
        elif lines != before:
            sys.stdout.write(gap if before is not None else "")
            _out.write(lines)
        before = lines
        sys.stdout.flush()
        time.sleep(period_s)
