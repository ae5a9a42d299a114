"""Jobs: command lines that go on for some time, whose JSON lines all pages see as they come.

A page that comes later asks for the rows that were kept. A job is stopped as by Ctrl-C, so it ends
as its command promises.
"""

from __future__ import annotations

import asyncio
import json
import shlex
import signal
from asyncio.subprocess import DEVNULL, PIPE, Process
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import suppress
from itertools import count

from rtkit.api.live_records import Record
from rtkit.errors import LimitReached, NotFound
from rtkit.web.jobs.running import message_of, started
from rtkit.web.pages import Pages

JOB = "job"
"""The event that tells a job: that it began, has new rows, or has ended."""
_MOST_RUNNING = 16
_MOST_KEPT = 32
_MOST_ROWS = 10_000
_BYTES = 1 << 16
_AT_ONCE = 200
"""So many rows are sent in one event at most."""


class Job:
    """One command line at work, or ended.

    Attributes:
        id: Its number, as a text.
        kind: What it is for; pages know what to show of it.
        text: What it does, as a sentence.
        line: The command line.
        typed: The same as a user types it.
        status: Its exit status; None while it runs.
        error: What it wrote to stderr when it failed.
        rows: The last rows that it told.
        count: The number of rows that it has told.
    """

    def __init__(self, id: str, kind: str, text: str, line: Sequence[str], typed: str = "") -> None:
        """Have a job that is not started."""
        self.id = id
        self.kind = kind
        self.text = text
        self.line = tuple(line)
        self.typed = typed or shlex.join(line)
        self.status: int | None = None
        self.error = ""
        self.rows: deque[Record] = deque(maxlen=_MOST_ROWS)
        self.count = 0

    def record(self) -> Record:
        """Return what pages get of it, without its rows."""
        return {
            "id": self.id, "kind": self.kind, "text": self.text, "command": self.typed,
            "status": self.status, "error": self.error, "count": self.count,
        }  # fmt: skip


class Jobs:
    """The jobs of one server."""

    def __init__(self, pages: Pages) -> None:
        """Have none; their news is sent to `pages`."""
        self._pages = pages
        self._jobs: dict[str, Job] = {}
        self._processes: dict[str, Process] = {}
        self._tasks: dict[str, asyncio.Task[None]] = {}
        self._numbers = count(1)

    def records(self) -> list[Record]:
        """Return those that run and the last that have ended, in the order of their beginning."""
        return [each.record() for each in self._jobs.values()]

    async def start(
        self,
        kind: str,
        text: str,
        line: Sequence[str],
        *,
        typed: str = "",
        about: Record | None = None,
        given: bytes | None = None,
        follows_stderr: bool = False,
    ) -> Job:
        """Start a command line that tells JSON objects, one a line.

        Args:
            kind: What the job is for, as the page names it.
            text: What it does, as a sentence.
            line: The command line.
            typed: The same as a user types it, where that is more: with what it reads.
            about: The first row: what pages that come later need to know, too.
            given: What the command reads from stdin.
            follows_stderr: Lines of stderr are rows, too, ``{"stderr": LINE}``.

        Raises:
            LimitReached: As many run as may.
        """
        if len(self._processes) >= _MOST_RUNNING:
            raise LimitReached(f"{_MOST_RUNNING} jobs run already: stop one")
        job = Job(str(next(self._numbers)), kind, text, line, typed)
        self._processes[job.id] = await started(job.line, DEVNULL if given is None else PIPE)
        self._jobs[job.id] = job
        ended = [id for id, each in self._jobs.items() if each.status is not None]
        for id in ended[: max(0, len(self._jobs) - _MOST_KEPT)]:
            del self._jobs[id]
        self._pages.send(JOB, job.record())
        if about is not None:
            self._send(job, [about])
        self._tasks[job.id] = asyncio.create_task(self._follow(job, given or b"", follows_stderr))
        return job

    def found(self, id: str) -> Job:
        """Return a job.

        Raises:
            NotFound: There is none of that number.
        """
        if id not in self._jobs:
            raise NotFound(f"No such job: {id}")
        return self._jobs[id]

    def stop(self, id: str) -> None:
        """Have a job end, as Ctrl-C does; one that has ended is left as it is.

        Raises:
            NotFound: There is none of that number.
        """
        self.found(id)
        process = self._processes.get(id)
        if process is not None and process.returncode is None:
            process.send_signal(signal.SIGINT)

    async def close(self) -> None:
        """Stop all jobs, and return when they have ended."""
        for id in tuple(self._processes):
            self.stop(id)
        await asyncio.gather(*self._tasks.values())

    async def ended(self, id: str) -> Job:
        """Return a job when it has ended.

        Raises:
            NotFound: There is none of that number.
        """
        job = self.found(id)
        if id in self._tasks:
            await asyncio.shield(self._tasks[id])
        return job

    async def _follow(self, job: Job, given: bytes, follows_stderr: bool) -> None:
        process = self._processes[job.id]
        assert process.stdout is not None
        assert process.stderr is not None
        errors: deque[str] = deque(maxlen=_MOST_ROWS)

        def error_row(line: bytes) -> Record | None:
            errors.append(line.decode(errors="replace"))
            return {"stderr": message_of(errors[-1], job.line)} if follows_stderr else None

        await asyncio.gather(
            _give(process, given),
            self._send_lines(job, process.stdout, _row),
            self._send_lines(job, process.stderr, error_row),
        )
        status = await process.wait()
        job.status, job.error = status, message_of("\n".join(errors), job.line) if status else ""
        del self._processes[job.id], self._tasks[job.id]
        self._pages.send(JOB, job.record())

    async def _send_lines(
        self, job: Job, stream: asyncio.StreamReader, row_of: Callable[[bytes], Record | None]
    ) -> None:
        """Send the rows that the lines of a stream stand for, as they come."""
        waiting: list[Record] = []
        async for line in _lines(stream):
            row = row_of(line) if line else None
            if row is not None:
                waiting.append(row)
            if waiting and (not line or len(waiting) >= _AT_ONCE):
                self._send(job, waiting)
                waiting = []

    def _send(self, job: Job, rows: list[Record]) -> None:
        first = job.count
        job.rows.extend(rows)
        job.count += len(rows)
        self._pages.send(JOB, {**job.record(), "first": first, "rows": rows})


async def _give(process: Process, data: bytes) -> None:
    """Have a process read data as its stdin; one that ends before has no use for the rest."""
    if process.stdin is not None:
        process.stdin.write(data)
        with suppress(ConnectionError):
            await process.stdin.drain()
        process.stdin.close()


def _row(line: bytes) -> Record:
    """Return what a line tells; one that is no JSON object is a text."""
    try:
        row = json.loads(line)
    except ValueError:
        row = None
    return row if isinstance(row, dict) else {"text": line.decode(errors="replace")}


async def _lines(stream: asyncio.StreamReader) -> AsyncIterator[bytes]:
    """Yield lines as they come, and an empty one whenever no further line is there already."""
    rest = b""
    while data := await stream.read(_BYTES):
        *lines, rest = (rest + data).split(b"\n")
        for line in lines:
            yield line.strip()
        yield b""
    yield rest.strip()
    yield b""
