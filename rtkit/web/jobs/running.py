"""Runs the command line of a step, as a process of its own with the rights of this one."""

from __future__ import annotations

import asyncio
import json
import os
import shlex
import sys
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections.abc import Container, Sequence
from typing import NamedTuple

from rtkit.api.live_records import Record
from rtkit.errors import Refused, Unreachable
from rtkit.web.live.steps import CommandStep

_MAIN = "import sys; sys.argv[0] = 'rtkit'; from rtkit.cli import main; sys.exit(main())"
_BOUND_S = 60.0
"""Bound on a command; each has a time-out of its own below that [s]."""


class Outcome(NamedTuple):
    """The outcome of a command.

    Attributes:
        status: Exit status.
        out: What it wrote to stdout.
        error: What it wrote to stderr, without its own name.
    """

    status: int
    out: str
    error: str


async def started(line: Sequence[str], stdin: int = DEVNULL) -> Process:
    """Start a command line as a process, whose output is read through pipes."""
    return await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-c", _MAIN, *line,
        stdin=stdin, stdout=PIPE, stderr=PIPE, env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip


def message_of(text: str, line: Sequence[str]) -> str:
    """Return what a command wrote to stderr, without its own name."""
    return text.strip().replace(f"rtkit {line[0]}: ", "")


async def outcome_of(line: Sequence[str], given: bytes | None = None) -> Outcome:
    """Run a command line and return how it ended.

    Args:
        line: The command line.
        given: What it reads from stdin, if it reads that.

    Raises:
        Unreachable: It did not end in time.
    """
    process = await started(line, DEVNULL if given is None else PIPE)
    try:
        async with asyncio.timeout(_BOUND_S):
            out, err = await process.communicate(given)
    except TimeoutError:
        process.kill()
        await process.wait()
        raise Unreachable(f"{line[0]} did not end in {_BOUND_S:g} s") from None
    text = message_of(err.decode(errors="replace"), line)
    return Outcome(process.returncode or 0, out.decode(errors="replace"), text)


async def records_from(line: Sequence[str], good: Container[int] = (0,)) -> list[Record]:
    """Run a command line that tells JSON objects, one a line, and return them.

    Args:
        line: The command line.
        good: Its exit statuses with which its output is an answer.

    Raises:
        Refused: It failed; says what it said.
        Unreachable: It did not end in time.
    """
    outcome = await outcome_of(line)
    rows = [json.loads(each) for each in outcome.out.splitlines()]
    if outcome.status and (outcome.status not in good or not rows):
        raise Refused(outcome.error or f"{line[0]} failed")
    return rows


async def carried_out(step: CommandStep) -> Record:
    """Run the command of a step; return the step with its outcome."""
    try:
        outcome = await outcome_of(step.line, step.stdin.encode() or None)
    except Unreachable as error:
        return shown(step, is_done=False, error=str(error))
    is_done = outcome.status == 0
    return shown(step, is_done=is_done, error="" if is_done else outcome.error or "it failed")


def shown(step: CommandStep, *, is_done: bool | None = None, error: str = "") -> Record:
    """Return a step as pages get it; of one that was not tried `is_done` is None."""
    return {"text": step.text, "command": shlex.join(step.line), "ok": is_done, "error": error}
