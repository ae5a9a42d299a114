"""The GUI service: components by type, in the terminal and in the browser, kept in a storage."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path
from typing import Annotated, Final

import browser
import pytest

import rtkit
from rtkit.link import secret
from rtkit.panel.live import LiveService
from rtkit.panel.terminal import PanelApp
from rtkit.services.gui import GuiService
from rtkit.services.storage import Storage


class Robot:
    type: Final = ("mobilerobot",)
    velocity: Annotated[tuple[float, float, float, float, float, float], rtkit.Returns(0.5)] = (
        0.0,
    ) * 6
    location: tuple[float, float, float, float, float, float] = (1.0, 2.0, 0.0, 0.0, 0.0, 0.0)
    secret: str = "not chosen by the component"


class Probe:
    own: Annotated[
        tuple[float, float, float], rtkit.Gui("vector", text='<gui label="its own"/>')
    ] = (1.0, 2.0, 3.0)
    place: tuple[float, float, float] = (1.0, 2.0, 3.0)
    lamp: bool = True


def until(condition: Callable[[], object]) -> None:
    end = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_it_is_a_component_under_the_name_of_its_class() -> None:
    found = {each.value: each.name for each in entry_points(group="rtkit.components")}
    assert found["rtkit.services.gui:GuiServiceInit"] == GuiService.__name__


def test_components_are_kept_by_type_and_in_a_storage(place: str, tmp_path: Path) -> None:
    with (
        rtkit.serve(Storage(str(tmp_path)), "files", is_on_zenoh=False),
        rtkit.serve(GuiService("files"), "gui", is_on_zenoh=False),
        rtkit.Client() as client,
    ):
        names = client.get("gui.properties", all=1)
        assert {"vector.html", "vector.text", "marker.html", "mobilerobot.text"} <= set(names)
        assert client.get("gui.vector.html").startswith("<!DOCTYPE html>")
        revision = client.get("gui.vector.text.meta.revision")
        client.set("gui.vector.text", '<gui kind="vector" step="2"/>')
        assert (tmp_path / "vector.text").read_text() == '<gui kind="vector" step="2"/>'
        until(lambda: client.get("gui.vector.text.meta.revision") > revision)
        client.set("gui.lamp.html", "<p>lamp</p>")
        assert (tmp_path / "lamp.html").read_text() == "<p>lamp</p>"
        until(lambda: "lamp.html" in client.get("gui.properties", all=1))
        client.set("gui.lamp.html", "")
        until(lambda: not (tmp_path / "lamp.html").exists())
        for name, text, code in (
            ("lamp.text", "<script/>", "bad-value"), ("lamp.exe", "x", "unknown"),
            ("lamp.html", "x" * 70_000, "too-large"),
        ):  # fmt: skip
            with pytest.raises(rtkit.PropertyError) as raised:
                client.set(f"gui.{name}", text)
            assert raised.value.code == code


def test_a_component_that_is_added_changed_and_taken_away_is_told_to_an_open_panel(
    place: str,
) -> None:
    """A property's own component stands before that of its type, which one may come later."""

    def labels() -> list[str | None]:
        live.refresh()
        found = {each.name: each.attributes.get("label") for each in live.panel.all()}
        return [found["own"], found["place"], found["lamp"]]

    with (
        rtkit.serve(Probe(), "probe", is_on_zenoh=False),
        rtkit.serve(GuiService(), "gui", is_on_zenoh=False),
        rtkit.Client() as client,
        LiveService("probe", 5.0) as live,
    ):
        assert labels() == ["its own", None, None]
        client.set("gui.vector.text", '<gui label="by type"/>')
        until(lambda: live.is_outdated)
        assert labels() == ["its own", "by type", None]
        for label in ("first", "second", None):
            client.set("gui.boolean.text", f'<gui label="{label}"/>' if label else "")
            until(lambda: live.is_outdated)
            assert labels() == ["its own", "by type", label]


def test_a_terminal_draws_a_type_as_its_component_says_also_a_new_version(place: str) -> None:
    def kinds(live: LiveService) -> dict[str, str]:
        return {each.name: each.kind for each in live.panel.all()}

    with (
        rtkit.serve(Robot(), "robots/r1", is_on_zenoh=False),
        rtkit.serve(GuiService(), "gui", is_on_zenoh=False),
        LiveService("robots/r1", 5.0) as live,
    ):
        assert kinds(live) == {
            "": "group", "velocity": "joystick", "velocity.timeout": "number",
            "location": "vector"}  # fmt: skip
        with rtkit.Client() as client:
            client.set("gui.mobilerobot.text", '<gui><gui name="velocity" kind="vector"/></gui>')
        until(lambda: live.is_outdated)

        async def driven() -> None:
            app = PanelApp(live)
            async with app.run_test():
                end = time.monotonic() + 10.0
                while "location" in app._rows:
                    assert time.monotonic() < end
                    await asyncio.sleep(0.01)
                assert app._rows["velocity"].panel.kind == "vector"

        asyncio.run(driven())


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_a_browser_draws_a_type_as_its_component_says_and_shuts_its_page_in(place: str) -> None:
    home = {"r1": Robot(), "components": GuiService()}
    with rtkit.serve(home, "home", http=0, is_on_zenoh=False) as served:
        known = secret.read()
        with browser.opened(place, known.user, known.password) as page:
            page.go(f"http://localhost:{served.http}/ps/home")
            page.wait_for("document.querySelector('rt-joystick[data-name=\"r1.velocity\"]')")
            assert page.evaluate("document.querySelector('[data-name=\"r1.secret\"]')") is None
            page.click('rt-frame[data-of="r1.location"] button')
            page.wait_for("document.querySelector('iframe')?.src.endsWith('vector.html')")
            with rtkit.Client() as client:
                client.set("home.components.mobilerobot.text",
                           '<gui><gui name="secret"/></gui>')  # fmt: skip
            page.wait_for("document.querySelector('[data-name=\"r1.secret\"]')")
            # A type that had no component gets one, whose words are text and nothing else.
            with rtkit.Client() as client:
                client.set("home.components.string.text",
                           '<gui label="&lt;img src=x onerror=troubles.push(1)&gt;"/>')  # fmt: skip
            shown = "document.querySelector('[data-name=\"r1.secret\"] .name').textContent"
            page.wait_for(f"{shown} === '<img src=x onerror=troubles.push(1)>'")
            assert page.troubles() == []
