"""The panel of a whole service in a real browser: live in both directions, and safe."""

from __future__ import annotations

import json
import math
import os
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Annotated, Final, Literal

import browser
import cv2
import numpy
import pytest

import rtkit
from rtkit.link import secret
from rtkit.wires.http.server_connection import HttpConnection
from rtkit.wires.serve import ServedObject

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
HOSTILE = "<img src=x onerror=\"window.troubles.push('run')\"><script>troubles.push('run')</script>"


class Arm:
    angle: Annotated[float, rtkit.Unit("rad"), rtkit.Range(-1.5, 1.5)] = 0.0


class Robot:
    type: Final = ("mobilerobot",)
    speed: Annotated[float, rtkit.Unit("m/s"), rtkit.Range(-1, 1, 0.05)] = 0.25
    is_on = True
    mode: Literal["idle", "drive"] = "idle"
    title: str = "two words"
    note: Final[str] = HOSTILE
    location: tuple[float, float, float] = (1.0, 2.0, 0.0)

    def __init__(self) -> None:
        self.arm = Arm()
        self.rows = [[1, HOSTILE], ["<b>2</b>", math.inf]]
        self.go_on = threading.Event()

    def wave(self, times: int = 1, how: Literal["up", "down"] = "up") -> Iterator[float]:
        """<b>Waves</b> the arm."""
        while not self.go_on.wait(0.02):
            yield 0.5
        self.speed = -0.5 if (times, how) == (3, "down") else 0.0


@contextmanager
def shown(thing: object, place: str, path: str) -> Iterator[tuple[ServedObject, browser.Browser]]:
    """Serve something, and show a page of it."""
    with rtkit.serve(thing, "robots/r1", http=0, is_on_zenoh=False) as served:
        known = secret.read()
        with browser.opened(place, known.user, known.password) as page:
            page.go(f"http://localhost:{served.http}{path}")
            page.wait_for("document.getElementById('state')?.textContent === 'live'")
            yield served, page


def widget(name: str, inner: str = "") -> str:
    return f"document.querySelector('[data-name=\"{name}\"] {inner}')"


def test_a_panel_and_its_service_follow_each_other(place: str) -> None:
    robot = Robot()
    with shown(robot, place, "/ps/robots/r1") as (served, page):
        page.wait_for(widget("speed", "input") + "?.value === '0.25'")
        # With the mouse, with keys, and by the service.
        left, top, width, height = page.place('[data-name="speed"] input')
        page.mouse("mousePressed", left + width * 0.62, top + height / 2)
        page.mouse("mouseMoved", left + width * 0.9, top + height / 2)
        page.mouse("mouseReleased", left + width * 0.9, top + height / 2)
        page.wait_for(widget("speed", "output") + ".textContent === '0.85'")
        page.key("ArrowRight")
        page.wait_for(widget("speed", "output") + ".textContent === '0.9'")
        page.wait_for(widget("speed") + ".isSending === false")
        served.owned(lambda: None)
        assert robot.speed == 0.9
        robot.speed = -0.3
        page.wait_for(widget("speed", "input") + ".value === '-0.3'")
        page.click('[data-name="is_on"] input')
        page.wait_for(widget("is_on", "output") + ".textContent === 'off'")
        page.evaluate(f"{widget('mode', 'select')}.focus()")
        page.key("ArrowDown")
        page.wait_for(widget("mode", "select") + ".selectedOptions[0].text === 'drive'")
        page.evaluate(f"{widget('location', 'input')}.focus()")
        page.evaluate("document.activeElement.select()")
        page.key("7")
        page.key("Tab")
        page.wait_for("document.activeElement.getAttribute('aria-label') === 'location y'")
        robot.arm.angle = 0.5
        page.wait_for(widget("arm.angle", "output") + ".textContent === '0.5'")
        page.evaluate(f"{widget('title', 'input')}.focus()")
        page.evaluate("document.activeElement.select()")
        for each in 'a "b':
            page.key(each)
        page.key("Enter")
        page.wait_for(widget("title") + ".isSending === false")
        assert page.evaluate(widget("title", "input") + ".value") == 'a "b'
        served.owned(lambda: None)
        assert (robot.is_on, robot.mode, robot.location, robot.title) == (
            False, "drive", (7.0, 2.0, 0.0), 'a "b')  # fmt: skip
        assert page.troubles() == []


def test_a_widget_is_seen_once_it_has_a_value(place: str) -> None:
    with shown(Robot(), place, "/ps/robots/r1") as (_, page):
        page.wait_for(widget("speed", "input") + "?.value === '0.25'")
        page.evaluate("""import("/static/widgets.js").then(({widgetOf}) => {
            window.made = ["rw", "w"].map((access) => {
                const attributes = {kind: "slider", name: "height", access, min: 0, max: 1};
                const made = widgetOf({attributes, children: []});
                document.querySelector("rt-panel").append(made);
                made.begin({attributes, children: []}, {});
                return made;
            });
        })""")
        page.wait_for("window.made")
        seen = "made.map((each) => getComputedStyle(each.body).opacity).join(' ')"
        assert page.evaluate(seen) == "0 1"
        page.evaluate("made[0].show('1')")
        assert page.evaluate(seen) == "1 1"
        waiting = "document.querySelectorAll('[data-waits]').length"
        page.wait_for(f"{waiting} === 0")
        assert page.troubles() == []


def test_no_press_of_a_key_is_lost_while_older_values_come_back(place: str) -> None:
    robot = Robot()
    with shown(robot, place, "/ps/robots/r1") as (served, page):
        page.wait_for(widget("speed", "input") + "?.value === '0.25'")
        page.evaluate(f"{widget('speed', 'input')}.focus()")
        for _ in range(15):
            page.key("ArrowRight")
        page.wait_for(widget("speed") + ".isSettling === false")
        served.owned(lambda: None)
        assert robot.speed == 1.0
        assert page.evaluate(widget("speed", "output") + ".textContent") == "1"


def test_an_action_takes_arguments_shows_how_far_it_is_and_stops(place: str) -> None:
    robot = Robot()
    with shown(robot, place, "/#robots/r1") as (_, page):
        page.evaluate(f"{widget('wave', '[data-name=times] input')}.focus()")
        page.evaluate("document.activeElement.select()")
        page.key("3")
        page.key("Tab")
        page.key("d")
        page.click('[data-name="wave"] > .body > button')
        page.wait_for(widget("wave", "progress") + ".value === 0.5")
        robot.go_on.set()
        page.wait_for(widget("speed", "input") + ".value === '-0.5'")
        robot.go_on.clear()
        page.wait_for(widget("wave", "> .body > output") + ".textContent === 'done 0.5'")
        page.click('[data-name="wave"] > .body > button')
        page.wait_for(f"!{widget('wave', '> .body > button + button')}.hidden")
        page.click('[data-name="wave"] > .body > button + button')
        page.wait_for(widget("wave", "> .body > output") + ".textContent.startsWith('stopped')")
        # A wrong value is refused in words, and what is in force is shown again.
        page.evaluate(f"{widget('speed')}.send('5')")
        page.wait_for(widget("speed", ".problem") + ".textContent.includes('5 is above 1')")
        page.wait_for(widget("speed", "input") + ".value === '-0.5'")
        assert page.troubles() == []


def test_text_of_strangers_is_only_shown(place: str) -> None:
    with shown(Robot(), place, "/ps/robots/r1") as (_, page):
        page.wait_for(widget("rows", "td") + " !== null")
        assert page.evaluate(widget("note", "output") + ".textContent") == HOSTILE
        assert page.evaluate(widget("wave") + ".title") == "<b>Waves</b> the arm."
        strange = "document.querySelectorAll('main img, main script, main b').length"
        assert page.evaluate(strange) == 0
        assert page.troubles() == []
        # And the policy would not run it if it were more.
        page.evaluate("document.body.insertAdjacentHTML('beforeend', '<p onclick=\"1\">')")
        page.evaluate("document.querySelector('body > p').click()")
        page.wait_for("window.troubles.length > 0")
        assert page.troubles()[0].startswith("script-src")


def test_what_is_lost_looks_so_and_comes_back(place: str) -> None:
    robot = Robot()
    with shown(robot, place, "/ps/robots/r1#arm.angle") as (served, page):
        assert page.evaluate("document.querySelectorAll('[data-kind]').length") == 1
        robot.arm.angle = 1.0
        page.wait_for(widget("arm.angle", "output") + ".textContent === '1'")

        def hang_up() -> None:
            for each in list(served._host._handlers.values()):
                if isinstance(each, HttpConnection) and each.is_stream:
                    each.close()

        served.owned(hang_up)
        page.wait_for("document.getElementById('state').dataset.lost === 'true'")
        assert page.evaluate(widget("arm.angle", "input") + ".disabled") is True
        robot.arm.angle = -1.0
        page.wait_for(widget("arm.angle", "output") + ".textContent === '-1'")
        page.wait_for("document.getElementById('state').textContent === 'live'")
        assert page.evaluate(widget("arm.angle", "input") + ".disabled") is False
        # Who hangs ends no stream, but does not answer.
        go_on = threading.Event()
        hangs = threading.Thread(target=lambda: served.owned(lambda: go_on.wait(30)))
        hangs.start()
        page.wait_for("document.getElementById('state').textContent.includes('no answer')")
        go_on.set()
        hangs.join()
        page.wait_for("document.getElementById('state').textContent === 'live'")
        known = secret.read()
        page.go(f"http://{known.user}:{known.password}@localhost:{served.http}/#robots/r1/speed")
        page.wait_for(f"{widget('speed', 'output')}?.textContent === '0.25'")
        served.owned(lambda: served.service.add("later", 3, "number"))
        page.go(f"http://localhost:{served.http}/#robots/r1")
        page.wait_for(f"{widget('later', 'input')}?.value === '3'")
        served.owned(lambda: served.service.add("more", 4, "number"))
        page.wait_for(f"{widget('more', 'input')}?.value === '4'")
        served.owned(lambda: served.service.remove("more"))
        page.wait_for(f"{widget('more')} === null")
        assert page.troubles() == []


STRANGER = """<p id=out></p><script>
const told = [];
const note = (text) => told.push(text);
setInterval(() => parent.postMessage({id: 0, method: "SET", name: "title",
    value: JSON.stringify(JSON.stringify(told))}, "*"), 200);
const asks = {1: ["GET", ""], 2: ["GET", "gui"], 3: ["GET", "../speed"], 4: ["CALL", "x"]};
onmessage = ({data}) => { if (data.id) note(`${data.id} ${data.value ?? data.error}`); };
for (const [id, [method, name]] of Object.entries(asks))
    parent.postMessage({id: Number(id), method, name}, "*");
try { note("parent " + parent.document.title); } catch (error) { note("parent " + error.name); }
try { note("storage " + localStorage.length); } catch (error) { note("storage " + error.name); }
fetch("/ps/robots/r1/speed").then(() => note("fetched"), () => note("fetch failed"));
new Image().src = "http://localhost:1/leak";
</script>"""


def test_a_component_of_a_stranger_is_shut_in(place: str) -> None:
    """It reaches what lies below its property, and neither the page, the network nor the rest."""
    robot = Robot()
    with shown(robot, place, "/ps/robots/r1") as (served, page):
        served.owned(lambda: served.service.add("lamp.html", STRANGER, "text"))
        served.owned(lambda: served.service.add("lamp.title", "", "string"))
        page.wait_for(f"{widget('lamp.title', 'input')}")  # what comes late moves the button
        page.wait_for(f"{widget('lamp.html', 'textarea')}?.value")
        page.evaluate("""(() => {
            const frame = document.createElement("rt-frame");
            document.querySelector("main").append(frame);
            const set = (target, body) => fetch(`/ps/robots/r1/${target}`, {method: "PUT", body});
            const source = {get: async (target) => `value of ${target}`, set};
            frame.begin({attributes: {name: "lamp"}}, source, "/ps/robots/r1/lamp.html");
        })()""")
        assert page.evaluate("document.querySelector('iframe')") is None, "not before it is wanted"
        page.click("rt-frame button")
        page.wait_for(f"{widget('lamp.title', 'input')}?.value.includes('fetch failed')")
        page.wait_for(f"{widget('lamp.title', 'input')}?.value.includes('4 denied')")
        told = json.loads(page.evaluate(f"{widget('lamp.title', 'input')}.value"))
        assert sorted(told) == [
            "1 value of lamp", "2 denied only what lies below", "3 denied only what lies below",
            "4 denied GET and SET only", "fetch failed", "parent SecurityError",
            "storage SecurityError"]  # fmt: skip
        assert page.troubles() == []


class Drawn:
    """Thing that brings along a page of its own for all of it, and takes what nobody can get."""

    def gui(self) -> rtkit.Gui:
        return rtkit.Gui(html="<title>all of it</title>")

    def set_event(self, name: str) -> None:
        """Take an event."""


def test_a_service_has_a_page_for_all_of_it_and_fields_that_are_only_set(place: str) -> None:
    with shown(Drawn(), place, "/ps/robots/r1") as (_, page):
        page.wait_for(f"{widget('event', 'input')}")
        page.click('rt-frame[data-of=""] button')
        page.wait_for("document.querySelector('iframe')?.src.endsWith('/ps/robots/r1/gui.html')")
        assert page.evaluate(f"{widget('event', 'input')}.value") == ""
        assert page.troubles() == []


def test_a_text_keeps_its_lines_when_it_is_edited(place: str) -> None:
    class Notes:
        title: str = "one line"
        body: rtkit.Text = rtkit.Text("a\nb")

    with shown(Notes(), place, "/ps/robots/r1") as (_, page):
        page.wait_for(f"{widget('body', 'textarea')}?.value === 'a\\nb'")
        page.wait_for(f"{widget('title', 'input')}?.value === 'one line'")
        page.click('[data-name="body"] textarea')
        page.key("x")
        page.key("Tab")
        page.wait_for(f"{widget('body', 'textarea')}.value.includes('x')")
        with rtkit.Client() as client:
            page.wait_for(f"!{widget('body')}.isSettling")
            text = client.get("robots/r1.body")
            assert "x" in text.replace("\n", "", 1)
            assert len(text.splitlines()) == 2
            client.set("robots/r1.title", '"now\\ntwo"')
        page.wait_for(f"{widget('title', 'textarea')}?.value === 'now\\ntwo'")
        assert page.troubles() == []


class Rover:
    velocity: Annotated[
        tuple[float, float, float, float, float, float], rtkit.Range(-2, 2), rtkit.Returns(0.4)
    ] = (0.0,) * 6

    def __init__(self) -> None:
        self.image = picture((0, 0, 255))
        self.seen: list[rtkit.Marker] = [rtkit.Marker((1.0, 2.0, 0.0), name=HOSTILE)]


def picture(colour: tuple[int, int, int]) -> bytes:
    pixels = numpy.full((20, 30, 3), colour, numpy.uint8)
    return bytes(cv2.imencode(".png", pixels)[1].tobytes())


def test_a_joystick_goes_back_when_it_is_let_go(place: str) -> None:
    rover = Rover()
    at = widget("velocity", "output") + ".textContent"
    zero = f"{at} === '0  0  0  0  0  0'"
    with shown(rover, place, "/ps/robots/r1") as (served, page):
        page.wait_for(zero)
        left, top, width, _ = page.place('[data-name="velocity"] .pad')
        page.mouse("mousePressed", left + width / 2, top + 1)
        page.wait_for(f"{at}.startsWith('1.9')")
        page._do("Runtime.evaluate", awaitPromise=True,
                 expression="new Promise((done) => setTimeout(done, 700))")  # fmt: skip
        assert rover.velocity[0] > 1.9, "it is sent again and again while it is held"
        page.mouse("mouseReleased", left + width / 2, top + 1)
        page.wait_for(zero)
        page.evaluate(f"{widget('velocity', '.pad')}.focus()")
        page.key("ArrowLeft", ["keyDown"])
        page.wait_for(f"{at} === '0  0  0  0  0  2'")
        page.evaluate("document.activeElement.blur()")
        page.wait_for(zero)
        assert page.evaluate(f"{widget('velocity')}.timer") is None
        # And where the connection goes, nothing is held that would go on when it returns.
        page.evaluate(f"{widget('velocity', '.pad')}.focus()")
        page.key("ArrowUp", ["keyDown"])
        page.wait_for(f"{at}.startsWith('2')")

        def hang_up() -> None:
            for each in list(served._host._handlers.values()):
                if isinstance(each, HttpConnection) and each.is_stream:
                    each.close()

        served.owned(hang_up)
        page.wait_for(f"{widget('velocity')}.timer === null")
        page.wait_for(zero)
        assert page.troubles() == []


COLOR = """(() => {
    const canvas = document.createElement("canvas");
    const found = document.querySelector("rt-image img");
    if (!found?.naturalWidth) return "";
    const context = canvas.getContext("2d");
    context.drawImage(found, 0, 0);
    return context.getImageData(3, 3, 1, 1).data.slice(0, 3).join(" ");
})()"""


def test_a_picture_is_a_stream_while_it_is_seen_and_places_are_drawn(place: str) -> None:
    rover = Rover()
    streamed = "document.querySelector('rt-image img').src.includes('?stream')"
    with shown(rover, place, "/ps/robots/r1") as (_, page):
        page.wait_for("document.querySelector('rt-map text') !== null")
        page.place("rt-image")
        page.wait_for(f"{COLOR} === '255 0 0'")
        assert page.evaluate(streamed)
        for colour, seen in (((0, 255, 0), "0 255 0"), ((255, 0, 0), "0 0 255")):
            rover.image = picture(colour)
            page.wait_for(f"{COLOR} === '{seen}'")
        page.wait_for("document.querySelector('rt-image img').alt === 'image, 30 by 20'")
        # What is no picture is said, and the next one is a stream again.
        rover.image = b"no picture"
        page.wait_for(widget("image", ".problem") + ".textContent === 'no picture: 10 bytes'")
        rover.image = picture((0, 0, 255))
        page.wait_for(f"{COLOR} === '255 0 0' && {streamed}")
        page.wait_for(widget("image", ".problem") + ".textContent === ''")
        # Nobody looks at it: no connection is held for it.
        page.evaluate("document.querySelector('main').style.paddingBottom = '500vh'")
        page.evaluate("window.scrollTo(0, document.body.scrollHeight)")
        page.wait_for(f"!{streamed}")
        page.place("rt-image")
        page.wait_for(f"{COLOR} === '255 0 0' && {streamed}")
        # A label that is longer than the map ends in dots, and stays a text.
        assert page.evaluate(widget("seen", "text > title") + ".textContent") == HOSTILE
        label = widget("seen", "text") + ".firstChild.textContent"
        assert page.evaluate(label).endswith("…")
        assert HOSTILE.startswith(page.evaluate(label)[:-1])
        assert page.evaluate(widget("seen", "li") + ".textContent") == f"{HOSTILE}: 1 2 0"
        assert page.troubles() == []


def test_many_pictures_leave_connections_for_what_is_asked_and_set(place: str) -> None:
    colours = [picture((0, 0, each)) for each in range(0, 240, 30)]
    many = {f"c{at}": {"image": each} for at, each in enumerate(colours)}
    with shown({"lamp": True, **many}, place, "/ps/robots/r1") as (_, page):
        page.wait_for("document.querySelectorAll('rt-image').length === 8")
        page.evaluate("document.querySelector('rt-group').style.zoom = 0.2")
        page.wait_for("[...document.images].every((each) => each.naturalWidth === 30)")
        sources = "[...document.images].filter((each) => each.src.includes('?stream')).length"
        assert page.evaluate(sources) == 3
        many["c7"]["image"] = picture((0, 255, 0))
        page.wait_for("!document.images[7].src.includes('?stream')")
        page.evaluate(widget("lamp", "input") + ".click()")
        page.wait_for(widget("lamp", "output") + ".textContent === 'off'")
        assert page.troubles() == []


def test_a_mounted_place_has_its_widgets_also_when_its_owner_comes_later(place: str) -> None:
    robot = Robot()
    group = {"lamp": True, "far": rtkit.Mount("far")}
    with shown(group, place, "/ps/robots/r1") as (_, page):
        page.wait_for(widget("far") + "?.textContent.includes('no-service')")
        for title in ("first", "second"):
            robot = Robot()
            robot.title = title
            with rtkit.serve(robot, "far", is_on_zenoh=False) as far:
                page.wait_for(widget("far.title", "input") + f"?.value === '{title}'")
                page.wait_for(widget("far.arm.angle", "input") + ".disabled === false")
                page.evaluate(widget("far.arm.angle", "input") + ".focus()")
                page.key("ArrowRight")
                page.wait_for(widget("far.arm.angle") + ".isSending === false")
                far.owned(lambda: None)
                assert robot.arm.angle > 0
            page.wait_for(widget("far.title") + ".dataset.state !== ''")
        assert page.troubles() == []


def test_what_leads_back_says_so_and_what_is_away_is_gone(place: str) -> None:
    with rtkit.serve({"w": 2.0, "back": rtkit.Mount("robots/r1")}, "peer", is_on_zenoh=False):  # type: ignore[arg-type]
        thing = {"v": 1.5, "peer": rtkit.Mount("peer"), "lost": rtkit.Mount("nobody")}
        with shown(thing, place, "/ps/robots/r1") as (_, page):
            page.wait_for(widget("peer.w", "input") + "?.value === '2.0'")
            back, lost = widget("peer.back", ".state"), widget("lost", ".state")
            page.wait_for(f"{back}.textContent === '↻ above'")
            page.wait_for(f"{lost}.textContent === '⊘ gone'")
            assert "no-service" in page.evaluate(widget("lost", ".problem") + ".textContent")
            assert page.troubles() == []


def test_who_is_not_known_any_more_is_told_so_and_asked_once(
    place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = "document.getElementById('state').textContent"
    with ExitStack() as ends:
        served = ends.enter_context(rtkit.serve(Robot(), "robots/r1", http=0, is_on_zenoh=False))
        known = secret.read()
        page = ends.enter_context(browser.opened(place, known.user, known.password))
        address = f"http://localhost:{served.http}/ps/robots/r1"
        page.is_known = False
        page.go(address)
        page.wait_for("document.body?.innerText.startsWith('denied user and password are those')")
        page.is_known = True
        page.go(address)
        page.wait_for(f"{state} === 'live'")
        port, page.is_known, page.asked = served.http, False, 0
        served.close()
        os.mkdir(f"{place}/other", 0o700)
        monkeypatch.setenv("RTKIT_STATE_DIR", f"{place}/other")
        ends.enter_context(rtkit.serve(Robot(), "robots/r1", http=port, is_on_zenoh=False))
        page.wait_for(f"{state}.includes('denied user and password')")
        assert "Reload the page to be asked again." in page.evaluate(state)
        page.evaluate("window.looks = 0; setInterval(() => window.looks++, 100)")
        page.wait_for("window.looks > 40")  # longer than any look at what has gone
        assert page.asked == 1
        assert page.evaluate(widget("speed", "input") + ".disabled") is True
