"""Values that a page holds: what is set when it holds them no longer."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from rtkit.errors import Unreachable
from rtkit.web.properties.rest_values import ResettingValues, Rest

LONG, SOON = Rest("(0 0)", 60.0), Rest("(0 0)", 0.01)


class Robot:
    """Notes what it is set to; each SET takes a while."""

    def __init__(self) -> None:
        self.told: list[str] = []
        self.changed = asyncio.Event()
        self.is_away = False

    async def set(self, target: str, text: str, _is_echoed: bool) -> None:
        await asyncio.sleep(0)
        if self.is_away:
            raise Unreachable(f"{target}: away")
        self.told.append(text)
        self.changed.set()

    async def until(self, *told: str) -> None:
        while tuple(self.told) != told:
            self.changed.clear()
            await self.changed.wait()


def run(body: Callable[[Robot, ResettingValues, list[str]], Awaitable[None]]) -> None:
    async def main() -> None:
        robot, failed = Robot(), []  # type: tuple[Robot, list[str]]
        async with asyncio.timeout(10):
            await body(robot, ResettingValues(robot.set, failed.append), failed)

    asyncio.run(main())


def test_the_end_of_a_page_lets_go_what_it_holds_and_nothing_else() -> None:
    async def body(robot: Robot, held: ResettingValues, _failed: list[str]) -> None:
        await held.set("one", "robot.velocity", "(1 0)", LONG)
        held.page_ended("another")
        held.page_ended("one")
        await robot.until("(1 0)", "(0 0)")
        held.page_ended("one")
        await held.close()
        assert robot.told == ["(1 0)", "(0 0)"]

    run(body)


def test_silence_lets_go_and_renewing_does_not() -> None:
    async def body(robot: Robot, held: ResettingValues, _failed: list[str]) -> None:
        await held.set("one", "robot.velocity", "(1 0)", SOON)
        await held.set("one", "robot.velocity", "(2 0)", LONG)
        await asyncio.sleep(0.03)
        assert robot.told == ["(1 0)", "(2 0)"]
        await held.set("one", "robot.velocity", "(3 0)", SOON)
        await robot.until("(1 0)", "(2 0)", "(3 0)", "(0 0)")

    run(body)


def test_a_value_that_is_not_held_is_left_as_it_is() -> None:
    async def body(robot: Robot, held: ResettingValues, _failed: list[str]) -> None:
        await held.set("one", "robot.velocity", "(1 0)", LONG)
        await held.set("one", "robot.velocity", "(0 0)", None)
        held.page_ended("one")
        await held.close()
        assert robot.told == ["(1 0)", "(0 0)"]

    run(body)


def test_the_rest_comes_behind_a_set_that_is_under_way() -> None:
    async def body(robot: Robot, held: ResettingValues, _failed: list[str]) -> None:
        setting = asyncio.create_task(held.set("one", "robot.velocity", "(1 0)", LONG))
        await asyncio.sleep(0)
        held.page_ended("one")
        await setting
        await robot.until("(1 0)", "(0 0)")

    run(body)


def test_the_end_of_the_server_lets_go_everything_and_tells_what_failed() -> None:
    async def body(robot: Robot, held: ResettingValues, failed: list[str]) -> None:
        await held.set("one", "robot.velocity", "(1 0)", LONG)
        await held.close()
        assert robot.told == ["(1 0)", "(0 0)"]
        await held.set("one", "robot.velocity", "(1 0)", LONG)
        robot.is_away = True
        await held.close()
        assert failed == ["robot.velocity: away"]

    run(body)
