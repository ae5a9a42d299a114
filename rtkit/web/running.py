"""Runs the command line of a step, as a process of its own with the rights of this one."""

from __future__ import annotations

import asyncio
import os
import shlex
import sys
from asyncio.subprocess import DEVNULL, PIPE

from rtkit.web.actions import CommandStep
from rtkit.web.records import Record

_MAIN = "import sys; sys.argv[0] = 'rtkit'; from rtkit.cli import main; main()"
_BOUND_S = 60.0
"""Bound on a command; each has a time-out of its own below that [s]."""


async def carried_out(step: CommandStep) -> Record:
    """Run the command of a step; return the step with its outcome."""
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-P", "-c", _MAIN, *step.line,
        stdin=DEVNULL, stdout=DEVNULL, stderr=PIPE, env={**os.environ, "NO_COLOR": "1"},
    )  # fmt: skip
    try:
        async with asyncio.timeout(_BOUND_S):
            _, stderr = await process.communicate()
    except TimeoutError:
        process.kill()
        await process.wait()
        return shown(step, is_done=False, error=f"{step.line[0]} did not end in {_BOUND_S:g} s")
    text = stderr.decode(errors="replace").strip()
    error = text.replace(f"rtkit {step.line[0]}: ", "")
    is_done = process.returncode == 0
    return shown(step, is_done=is_done, error="" if is_done else error or "it failed")


def shown(step: CommandStep, *, is_done: bool | None = None, error: str = "") -> Record:
    """Return a step as pages get it; of one that was not tried `is_done` is None."""
    return {"text": step.text, "command": shlex.join(step.line), "ok": is_done, "error": error}
