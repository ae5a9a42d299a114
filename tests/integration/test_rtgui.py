"""The panel in a terminal, driven by textual's own pilot, against services that are served."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable
from typing import Annotated, Final, Literal

import pytest
from textual import events
from textual.widgets import Input, Static
from waiting import until as awaited

import rtkit
from rtkit.panel.live import LiveService
from rtkit.panel.terminal import PanelApp
from rtkit.property.codes import PropertyError


class Arm:
    angle: Annotated[float, rtkit.Unit("rad"), rtkit.Range(-1.5, 1.5, 0.1)] = 0.0


class Robot:
    type: Final = ("mobilerobot",)
    speed: Annotated[float, rtkit.Unit("m/s"), rtkit.Range(-1, 1, 0.25)] = 0.25
    is_on = True
    mode: Literal["idle", "drive"] = "idle"
    title: str = "two words"
    velocity: Annotated[tuple[float, float, float, float, float, float], rtkit.Returns(0.3)] = (
        0.0,
    ) * 6

    def __init__(self) -> None:
        self.arm = Arm()
        self.seen: list[tuple[float, ...]] = []

    def wave(self, times: int = 1, how: str = "up"):  # type: ignore[no-untyped-def]
        """Waves."""
        self.title = f"{times} {how}"
        while True:
            yield 0.5
            time.sleep(0.01)


def run(work: Callable[[PanelApp], Awaitable[None]], name: str = "") -> None:
    """Drive the panel of ``robots/r1``."""

    async def driven() -> None:
        with LiveService("robots/r1", 5.0) as live:
            app = PanelApp(live, name)
            async with app.run_test(size=(100, 40)):
                await work(app)

    asyncio.run(driven())


async def until(condition: Callable[[], object]) -> None:
    """Let the panel go on until something is so."""
    end = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < end
        await asyncio.sleep(0.01)


def press(app: PanelApp, *keys: str) -> None:
    """Press keys; pilot.press would wait until the whole process is idle after each."""
    assert app._driver is not None
    for key in keys:
        app._driver.send_message(events.Key(key, None))


def click(app: PanelApp, name: str, column: int) -> None:
    """Press and release the mouse on a column of what a widget shows."""
    assert app._driver is not None
    place = app._rows[name].region
    at = (place.x + 19 + column, place.y)
    for kind in (events.MouseDown, events.MouseUp):
        app._driver.send_message(kind(None, *at, 0, 0, 1, False, False, False, *at))


def row(app: PanelApp, name: str) -> str:
    return app._rows[name].render().plain


def test_keys_set_and_changes_show(place: str) -> None:
    robot = Robot()

    async def work(app: PanelApp) -> None:
        await until(lambda: "0.25 m/s" in row(app, "speed"))
        app._rows["speed"].focus()
        press(app, "right", "right")
        await until(lambda: robot.speed == 0.75)
        robot.speed = -1.0
        await until(lambda: "-1 m/s" in row(app, "speed"))
        press(app, "tab")
        await until(lambda: app.focused is app._rows["is_on"])
        press(app, "space")
        await until(lambda: robot.is_on is False)
        press(app, "down")
        await until(lambda: app.focused is app._rows["mode"])
        press(app, "right")
        await until(lambda: robot.mode == "drive")
        press(app, "down")
        await until(lambda: app.focused is app._rows["title"])
        press(app, "enter")
        await until(lambda: len(app.screen.query(Input)) == 1)
        app.screen.query_one(Input).value = 'a "b'
        press(app, "enter")
        await until(lambda: robot.title == 'a "b')
        app._rows["arm.angle"].focus()
        press(app, "end")
        await until(lambda: robot.arm.angle == 1.5)
        press(app, "enter")
        await until(lambda: len(app.screen.query(Input)) == 1)
        app.screen.query_one(Input).value = "9"
        press(app, "enter")
        await until(lambda: "bad-value: 9 is above 1.5" in row(app, "arm.angle"))
        assert robot.arm.angle == 1.5

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_an_action_is_started_with_arguments_and_stopped(place: str) -> None:
    robot = Robot()

    async def work(app: PanelApp) -> None:
        app._rows["wave"].focus()
        press(app, "enter")
        await until(lambda: len(app.screen.query(Input)) == 2)
        first, second = app.screen.query(Input)
        first.value, second.value = "3", "two words"
        second.focus()
        press(app, "enter")
        await until(lambda: "running █████░░░░░ 50%" in row(app, "wave"))
        assert robot.title == "3 two words"
        press(app, "s")
        await until(lambda: "stopped" in row(app, "wave"))

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_a_joystick_returns_when_it_is_left(place: str) -> None:
    robot = Robot()

    async def work(app: PanelApp) -> None:
        stick = app._rows["velocity"]
        assert stick.panel.kind == "joystick"
        await until(lambda: stick.shown.value is not None)
        stick.focus()
        press(app, "up")
        await until(lambda: robot.velocity[0] == 1.0)
        app._rows["speed"].focus()
        await until(lambda: robot.velocity == (0.0,) * 6)

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_the_panel_is_a_service(place: str) -> None:
    robot = Robot()
    heard: list[object] = []

    async def work(app: PanelApp) -> None:
        with rtkit.Client() as client:
            await until(lambda: "0.25" in row(app, "speed"))
            listening = client.listen("panel.input", lambda change: heard.append(change.value))
            app._rows["speed"].focus()
            press(app, "right")
            await until(lambda: heard[-1:] == [("speed", 0.5)])
            assert client.get("panel.focus") == "speed"
            assert client.get("panel.type") == ("gui", "sensor")
            client.set("panel.speed", -0.5)
            assert robot.speed == -0.5
            with pytest.raises(PropertyError, match="above"):
                client.set("panel.speed", 5)
            listening.close()

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work, "panel")


def test_what_is_on_the_screen_is_served(place: str) -> None:
    is_let = threading.Event()

    class Slow:
        def get_level(self) -> Annotated[float, rtkit.Range(0, 1, 0.25)]:
            return 0.25

        def set_level(self, level: float) -> None:
            assert is_let.wait(10)

    async def work(app: PanelApp) -> None:
        with rtkit.Client() as client:
            await until(lambda: "0.25" in row(app, "level"))
            assert client.get("panel.level") == 0.25
            app._rows["level"].focus()
            press(app, "right")
            await until(lambda: " 0.5" in row(app, "level"))
            assert client.get("panel.level") == 0.5
            is_let.set()
            served.owned(lambda: served.service.add("later", 3, "number"))
            await until(lambda: "later" in app._rows and "3" in row(app, "later"))
            assert client.get("panel.later") == 3
            served.owned(lambda: served.service.remove("later"))
            await until(lambda: "later" not in app._rows)
            assert "later" not in client.get("panel.properties")

    with rtkit.serve(Slow(), "robots/r1", is_on_zenoh=False) as served:
        run(work, "panel")


def test_what_a_service_refuses_its_panel_refuses(place: str) -> None:
    class Lock:
        def get_code(self) -> int:
            return 5

        def set_code(self, code: int) -> None:
            raise ValueError(f"not {code}")

    async def work(app: PanelApp) -> None:
        with rtkit.Client() as client:
            await until(lambda: "5" in row(app, "code"))
            with pytest.raises(PropertyError, match="not 7"):
                client.set("panel.code", 7)
            assert client.get("panel.code") == 5

    with rtkit.serve(Lock(), "robots/r1", is_on_zenoh=False):
        run(work, "panel")


def test_values_that_do_not_fit_what_is_declared_are_shown_all_the_same(place: str) -> None:
    robot = Robot()
    robot.speed = 7.0  # beyond its range
    robot.photo = b"ab"  # type: ignore[attr-defined]  # bytes that are a text, too

    async def work(app: PanelApp) -> None:
        with rtkit.Client() as client:
            await until(lambda: "photo" in app._rows and "7" in row(app, "speed"))
            await until(lambda: "speed" in client.get("panel.properties"))
            assert client.get("panel.speed") == 7.0

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work, "panel")


def test_arrows_go_through_a_panel_longer_than_the_screen_and_no_key_is_lost(place: str) -> None:
    robot = Robot()
    robot.speed = -1.0
    vars(robot).update({f"n{each}": each for each in range(60)})

    async def work(app: PanelApp) -> None:
        await until(lambda: "-1" in row(app, "speed"))
        app._rows["speed"].focus()
        press(app, *["right"] * 8)
        await until(lambda: robot.speed == 1.0)
        press(app, "down")
        await until(lambda: app._rows["is_on"].has_focus)
        press(app, "up")
        await until(lambda: app._rows["speed"].has_focus)

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_keys_that_come_at_once_go_where_those_before_them_have_led(place: str) -> None:
    robot = Robot()

    async def work(app: PanelApp) -> None:
        await until(lambda: "off" in row(app, "arm.angle") or "0 rad" in row(app, "arm.angle"))
        app._rows["speed"].focus()
        press(
            app, "right", "down", "space", "tab", "right", "j", "enter", "home", "delete", "enter"
        )
        await until(lambda: (robot.speed, robot.is_on, robot.mode) == (0.5, False, "drive"))
        await until(lambda: robot.title == "wo words")
        press(app, "up", "k", "shift+tab", "left")
        await until(lambda: robot.speed == 0.25)
        assert (robot.is_on, robot.mode) == (False, "drive")

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_what_is_only_shown_is_seen_too(place: str) -> None:
    class Log:
        a: Final[str] = "x\n" * 12
        b: Final[str] = "x\n" * 12
        is_on: bool = False
        c: Final[str] = "y\n" * 12
        d: Final[str] = "y\n" * 12

    async def work(app: PanelApp) -> None:
        await until(lambda: app._box.max_scroll_y > 10 and app._rows["is_on"].has_focus)
        assert app._box.scroll_y == 0, "what stands above the first that can be changed"
        press(app, *["ctrl+down"] * 40)
        await until(lambda: app._box.scroll_y == app._box.max_scroll_y)
        press(app, "space", *["ctrl+up"] * 40)
        await until(lambda: app._box.scroll_y == 0)

    with rtkit.serve(Log(), "robots/r1", is_on_zenoh=False):
        run(work)


def test_a_text_of_several_lines_is_not_put_into_one(place: str) -> None:
    robot = Robot()
    robot.title = "two\nlines"

    async def work(app: PanelApp) -> None:
        await until(lambda: "lines" in row(app, "title"))
        app._rows["title"].focus()
        press(app, "enter", "enter")
        await until(lambda: "several lines: rtset with --file" in row(app, "title"))
        assert robot.title == "two\nlines"

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_what_is_clicked_is_set(place: str) -> None:
    robot = Robot()

    async def work(app: PanelApp) -> None:
        await until(lambda: "drive" in row(app, "mode") and app._rows["mode"].region.y)
        click(app, "mode", row(app, "mode").index("drive") - 18)
        await until(lambda: robot.mode == "drive")
        click(app, "mode", 1)
        await until(lambda: robot.mode == "idle")
        click(app, "is_on", 2)
        await until(lambda: robot.is_on is False)
        click(app, "speed", 0)
        await until(lambda: robot.speed == -1.0)
        click(app, "wave", 2)
        await until(lambda: len(app.screen.query(Input)) == 2)

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)


def test_what_goes_looks_so_and_names_come_and_go(place: str) -> None:
    async def work(app: PanelApp) -> None:
        def state() -> str:
            return str(app.query_one("#state", Static).render())

        await until(lambda: "● live" in state())
        first.owned(lambda: first.service.add("later", 3, "number"))
        await until(lambda: "later" in app._rows)
        first.close()
        await until(lambda: "⊘ not there" in state())
        assert "0.25" in row(app, "speed")
        assert "⊘ gone" in row(app, "speed")
        robot = Robot()
        robot.speed = 0.5
        with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
            await until(lambda: "● live" in state() and "0.5 m/s" in row(app, "speed"))
            await until(lambda: "later" not in app._rows)

    first = rtkit.serve(Robot(), "robots/r1", is_on_zenoh=False)
    run(work)


def test_a_mounted_place_has_its_widgets_also_when_its_owner_comes_later(place: str) -> None:
    async def work(app: PanelApp) -> None:
        await until(lambda: "⊘ gone" in row(app, "far"))
        for angle in (0.25, 0.75):
            robot = Robot()
            robot.arm.angle = angle
            with rtkit.serve(robot, "far", is_on_zenoh=False):
                await until(lambda: "far.arm.angle" in app._rows)
                await until(
                    lambda angle=angle: f" {angle} rad\n" in row(app, "far.arm.angle") + "\n"
                )

                def is_set(robot: Robot = robot) -> bool:
                    # A row that is just drawn anew, as others have come, takes no key.
                    if "far.arm.angle" in app._rows:
                        app._rows["far.arm.angle"].focus()
                        press(app, "end")
                    return robot.arm.angle == 1.5

                await until(is_set)
            # At the next look of the panel the place itself stands there again.
            names = ("far.arm.angle", "far")
            await until(lambda: any("⊘ gone" in row(app, n) for n in names if n in app._rows))  # noqa: B023

    with rtkit.serve({"lamp": True, "far": rtkit.Mount("far")}, "robots/r1", is_on_zenoh=False):
        run(work)


def test_what_leads_back_says_so_and_is_not_asked_again(place: str) -> None:
    async def work(app: PanelApp) -> None:
        await until(lambda: "2.5" in row(app, "peer.w"))
        await until(lambda: row(app, "peer.back").split() == ["back", "↻", "above"])
        assert not app.live.is_partial

    back = {"w": 2.5, "back": rtkit.Mount("robots/r1")}
    with (
        rtkit.serve(back, "peer", is_on_zenoh=False),  # type: ignore[arg-type]
        rtkit.serve({"v": 1, "peer": rtkit.Mount("peer")}, "robots/r1", is_on_zenoh=False),  # type: ignore[arg-type]
    ):
        with rtkit.Client(timeout_s=10.0) as client:
            there = [rtkit.Ask("robots/r1.peer.back.v")]
            awaited(lambda: client.ask_all(there, 5.0) == [1], "both are connected")
        run(work)


def test_long_lines_go_on_under_their_column(place: str) -> None:
    robot = Robot()
    robot.title = "many words " * 20

    async def work(app: PanelApp) -> None:
        await until(lambda: "many" in row(app, "title"))
        rows = row(app, "title").splitlines()
        assert len(rows) > 2
        assert all(each.startswith(" " * 18 + "many") for each in rows[1:])
        assert all(len(each) <= app._rows["title"].size.width for each in rows)

    with rtkit.serve(robot, "robots/r1", is_on_zenoh=False):
        run(work)
