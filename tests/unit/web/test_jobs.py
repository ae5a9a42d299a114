"""Jobs: real command lines, whose rows come in order, and which end as their commands promise."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from rtkit.errors import LimitReached, NotFound
from rtkit.web.jobs.jobs import Jobs
from rtkit.web.pages import Pages


def with_jobs(body: Callable[[Jobs], Awaitable[None]]) -> None:
    async def main() -> None:
        jobs = Jobs(Pages(1))
        try:
            await body(jobs)
        finally:
            await jobs.close()

    asyncio.run(main())


def test_a_job_that_ends_keeps_its_rows_and_its_status() -> None:
    async def body(jobs: Jobs) -> None:
        job = await jobs.start("help", "Tell the commands", ("rtls", "--version"))
        ended = await jobs.ended(job.id)
        assert ended.status == 0
        assert [set(row) for row in ended.rows] == [{"text"}]
        assert ended.record()["count"] == 1
        assert ended.record()["command"] == "rtls --version"

    with_jobs(body)


def test_a_job_that_fails_tells_why() -> None:
    async def body(jobs: Jobs) -> None:
        job = await jobs.start("plan", "Plan", ("rtplan", "--json", "/nowhere/a.xml"))
        ended = await jobs.ended(job.id)
        assert ended.status not in (0, None)
        assert "/nowhere/a.xml" in ended.error
        assert "rtkit rtplan:" not in ended.error

    with_jobs(body)


def test_a_job_that_is_stopped_ends_as_by_ctrl_c(monkeypatch: pytest.MonkeyPatch) -> None:
    waiting = "import threading; print('{}', flush=True); threading.Event().wait()"
    monkeypatch.setattr("rtkit.web.jobs.running._MAIN", waiting)

    async def body(jobs: Jobs) -> None:
        job = await jobs.start("wait", "Wait", ("wait",))
        while not job.count:  # an interpreter that has not begun ends otherwise
            await asyncio.sleep(0)
        jobs.stop(job.id)
        assert (await jobs.ended(job.id)).status == -2
        jobs.stop(job.id)
        with pytest.raises(NotFound, match="No such job: 7"):
            jobs.stop("7")

    with_jobs(body)


def test_there_are_not_more_than_may_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rtkit.web.jobs.jobs._MOST_RUNNING", 0)

    async def body(jobs: Jobs) -> None:
        with pytest.raises(LimitReached, match="stop one"):
            await jobs.start("wait", "Wait", ("rtls", "--version"))

    with_jobs(body)
