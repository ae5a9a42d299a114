"""Property pages in a real browser: the home of standard services, and a service that is a foe."""

from __future__ import annotations

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import NamedTuple

import browser
import pytest
from pagekit import ROOT
from shells import Shell
from waiting import until
from webkit import WebClient, served

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
HOME = ROOT / "examples" / "home"
AXE = ROOT / "web/node_modules/axe-core/axe.min.js"
DRIVE = "robots/r1.velocity"
REST = "(0.0 0.0 0.0 0.0 0.0 0.0)"

LAB = """
from pathlib import Path
from typing import Annotated

import rtkit


class Part:
    value: float = 1.0
    report: str = ""

    def gui(self) -> rtkit.Gui:
        return rtkit.Gui(html=Path("hostile.html").read_text())


class Lab:
    level: Annotated[float, rtkit.Range(0, 10, 1)] = 4.0
    secret: str = "none of its business"

    def __init__(self) -> None:
        self.part = Part()
"""
HOSTILE = (ROOT / "tests" / "support" / "hostile.html").read_text(encoding="utf-8")


class Site(NamedTuple):
    """The home and the lab, the page of them, and whoever listens where nobody should call."""

    shell: Shell
    web: WebClient
    page: browser.Browser
    callers: list[str]

    def go(self, of: str) -> None:
        """Show the page of a property."""
        self.page.evaluate(f"location.hash = {json.dumps('#view=properties&of=' + of)}")

    def come_back(self) -> None:
        """Leave the page, and return to it in the same tab."""
        address = self.page.evaluate("location.href")
        self.page.go("about:blank")
        self.page.go(address)

    def get(self, target: str) -> str:
        return self.shell.ok(f"rtget {target}").strip()


@contextmanager
def canary(callers: list[str]) -> Iterator[int]:
    """Listen at a port that the hostile component knows, and note who calls."""
    with (
        socket.create_server(("127.0.0.1", 0)) as listener,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as datagrams,
    ):
        port = listener.getsockname()[1]
        datagrams.bind(("127.0.0.1", port))
        datagrams.setblocking(False)

        def listen() -> None:
            while True:
                try:
                    end, _ = listener.accept()
                except OSError:
                    return
                with end:
                    callers.append(end.recv(200).decode(errors="replace"))

        thread = threading.Thread(target=listen, daemon=True)
        thread.start()
        yield port
        with suppress(BlockingIOError):
            callers.append(f"datagram {datagrams.recv(200)!r}")
        listener.shutdown(socket.SHUT_RDWR)
        thread.join()


@pytest.fixture(scope="module")
def home(shared_shell: Shell, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    """The home without its butler: its robots stand until somebody drives them."""
    shell, callers = shared_shell, list[str]()
    shell.environment["RTKIT_MODULE_PATH"] += f":{ROOT / 'examples'}"
    (shell.folder / "files").mkdir()
    (shell.folder / "lab.py").write_text(LAB)
    shell.ok("rtmgr start")
    given = f"--set files={shell.folder}/files --set home={HOME}/home.json"
    applied = shell.run(f"rtapply --without butler {given} {HOME}/system.yaml")
    assert applied.status == 0, applied.err
    with canary(callers) as port:
        (shell.folder / "hostile.html").write_text(HOSTILE.replace("CANARY", str(port)))
        lab = shell.open("rtserve ./lab.py:Lab lab")
        place = str(tmp_path_factory.mktemp("browser"))
        with served(shell) as web, browser.opened(place, "", "") as page:
            page.picture("/dev/null", 1440, 900)  # sets the size of the window
            page.go(f"http://127.0.0.1:{web.port}/#token={web.token}")
            page.wait_for("document.querySelector('.counts li') !== null")
            yield Site(shell, web, page, callers)
            troubles = [each for each in page.troubles() if "ResizeObserver loop" not in each]
            assert troubles == []
        assert callers == []
        lab.send_signal(2)
        shell.end_of(lab)
    shell.ok("rtmgr stop")


def widget(name: str, inner: str = "") -> str:
    return f"document.querySelector('rt-panel [data-name=\"{name}\"] {inner}')"


PAGE = (
    '<gui kind="group" label="Drive"><gui name="robots/r1.velocity.x" kind="slider" min="-0.5"'
    ' max="0.5"/><gui name="robots/r1.location" kind="map"/></gui>'
)


def test_a_slider_drives_a_robot_and_the_map_follows_and_the_page_is_stored(home: Site) -> None:
    page = home.page
    line = home.web.post("/api/properties/set", {"target": "home/files.drive.page", "value": PAGE})[
        "command"
    ]
    assert line == f"rtset home/files.drive.page '{PAGE}'"
    assert (home.shell.folder / "files" / "drive.page").read_text() == PAGE
    home.go("page:home/files.drive.page")
    before = home.get("robots/r1.location")
    place = "[...document.querySelectorAll('rt-map li')].map((e) => e.textContent)"
    page.wait_for(f"{place}.some((text) => text.startsWith('r1: '))")
    page.wait_for(f"{place}.some((text) => text.startsWith('r2: '))")  # what is known around it
    seen = page.evaluate(f"{place}.find((text) => text.startsWith('r1: '))")
    page.wait_for(widget("robots/r1.velocity.x", "input") + "?.value === '0'")
    page.evaluate(widget("robots/r1.velocity.x", "input") + ".focus()")
    page.key("ArrowRight")
    page.wait_for(f"{place}.every((text) => text !== {seen!r})")
    page.wait_for(
        "document.querySelector('.last-command code').textContent"
        " === 'rtset robots/r1.velocity.x 0.005'"
    )
    assert home.get("robots/r1.location") != before


def test_a_moved_slider_is_undone_in_one_step_unless_somebody_else_has_set_it(home: Site) -> None:
    page, shell = home.page, home.shell
    shell.ok("rtset lab.level 4")
    home.go("lab")
    field = widget("lab.level", "input")
    page.wait_for(field + "?.value === '4'")
    events = "['input', 'change'].forEach((kind) => field.dispatchEvent(new Event(kind)))"
    moves = f"for (const value of [5, 6, 7]) {{ field.value = value; {events}; }}"
    page.evaluate(f"(() => {{ const field = {field}; field.focus(); {moves} }})()")
    page.wait_for(widget("lab.level", "output") + ".textContent === '7'")
    page.wait_for(
        "document.querySelector('.last-command code').textContent === 'rtset lab.level 7'"
    )
    page.key("z", is_control=True)
    page.wait_for(widget("lab.level", "output") + ".textContent === '4'")
    page.wait_for("document.querySelector('.toast')?.textContent.includes('Undo: Set lab.level')")
    page.key("z", is_control=True, is_shift=True)
    page.wait_for(widget("lab.level", "output") + ".textContent === '7'")
    shell.ok("rtset lab.level 1")
    page.wait_for(widget("lab.level", "output") + ".textContent === '1'")
    page.key("z", is_control=True)
    page.wait_for(
        "document.querySelector('.toast-error')?.textContent"
        ".includes('lab.level has been changed since: it is 1.0, not 7')"
    )
    assert home.get("lab.level") == "1.0"
    page.press("Jobs")
    rows = "[...document.querySelectorAll('.changes tbody tr')].map((row) => row.innerText)"
    page.wait_for(f"{rows}.length >= 3")
    page.wait_for(f"{rows}.some((row) => row.includes('Set lab.level') && row.includes('4'))")
    moved = next(
        each for each in home.web.ask("GET", "/api/changes").body["changes"] if each["count"] > 1
    )
    assert (moved["text"], moved["old"], moved["new"]) == ("Set lab.level", "4.0", "7.0")
    shell.ok("rtset lab.level 4")


def test_a_page_is_put_together_saved_and_loaded(home: Site) -> None:
    page = home.page
    home.go("lab.level")
    page.press("Add to my page")
    page.wait_for("document.querySelector('.own-page form') !== null")
    names = "[...document.querySelectorAll('.items code')].map((each) => each.textContent).join()"
    page.wait_for(f"{names}.endsWith('lab.level')")
    page.type(".own-page form input", "home/lights/hall.on")
    page.key("Enter")
    page.wait_for(f"{names}.endsWith('lab.level,home/lights/hall.on')")
    page.wait_for(widget("home/lights/hall.on", "input") + " !== null")
    page.type(".own-page form:nth-of-type(2) input", "bench")
    page.press("Save")
    page.press("bench")
    page.wait_for("location.hash.endsWith('of=page:home/files.bench.page')")
    page.evaluate("sessionStorage.removeItem('rtkit.page')")
    home.come_back()
    page.wait_for(widget("home/lights/hall.on", "input") + "?.disabled === false")
    page.click('[data-name="home/lights/hall.on"] input')
    page.wait_for(widget("home/lights/hall.on", "output") + ".textContent === 'on'")
    assert home.get("home/lights/hall.on") == "true"


def test_what_a_shell_sets_is_seen_and_a_new_description_changes_its_widget_only(
    home: Site,
) -> None:
    page, shell = home.page, home.shell
    home.go("lab")
    page.wait_for(widget("lab.level", "input") + "?.value === '4'")
    shell.ok("rtset lab.level 7")
    page.wait_for(widget("lab.level", "output") + ".textContent === '7'")
    page.evaluate("window.kept = " + widget("lab.secret"))
    gui = shell.open("rtserve rtkit.services.gui:GuiService gui")
    try:
        page.wait_for(
            "[...document.querySelectorAll('[role=treeitem]')].some((e) => e.title === 'gui')"
        )
        shell.ok("rtset gui.number.text '<gui kind=\"knob\"/>'")
        page.wait_for(f"{widget('lab.level', '.dial')} !== null")
        shell.ok("rtset gui.number.text '<gui kind=\"plot\"/>'")
        page.wait_for("document.querySelector('rt-plot[data-name=\"lab.level\"]') !== null")
        assert page.evaluate("window.kept.isConnected")
    finally:
        gui.send_signal(2)
        shell.end_of(gui)


def test_a_point_and_a_region_on_the_map_lead_the_robot(home: Site) -> None:
    page = home.page
    home.go("robots/r2")
    page.wait_for("document.querySelector('rt-map polygon.area') !== null")
    tools = "document.querySelector('rt-map .tools:not([hidden])')"
    page.wait_for(f"{tools} !== null && {tools}.querySelector('button:not([disabled])') !== null")
    page.press("Point")
    page.key("ArrowRight")
    page.key("Enter")
    line = "(document.querySelector('.last-command code')?.textContent ?? '')"
    page.wait_for(f"{line}.startsWith('rtset robots/r2.behaviors.moveto')")
    page.wait_for("document.querySelector('rt-map .goal') !== null")
    page.wait_for("document.querySelector('.last-command .note')?.textContent.includes('undone')")
    page.press("Region")
    for number, (x, y) in enumerate(((0.6, 0.4), (0.7, 0.4), (0.7, 0.6)), 1):
        left, top, width, height = page.place("rt-map svg")  # it may have moved meanwhile
        page.mouse("mousePressed", left + width * x, top + height * y)
        page.evaluate("document.querySelector('rt-map').paint()")  # as when a robot drives on
        page.mouse("mouseReleased", left + width * x, top + height * y)
        page.wait_for(f"document.querySelectorAll('rt-map .corner').length === {number}")
    page.press("Done")
    page.wait_for(f"{line}.includes('<region>')")
    goal = home.get("robots/r2.behaviors.moveto")
    assert "<region>" in goal
    assert "<size>" in goal
    assert 'state="running"' in goal
    home.shell.ok("rtset robots/r2.behaviors.stop true")


def velocity_of(home: Site) -> str:
    return home.get(DRIVE)


def held(home: Site) -> None:
    """Show the joystick and hold it by a key; the property, which returns by itself, is slow to."""
    page = home.page
    home.shell.ok("rtset robots/r1.velocity.timeout 60")
    home.go("robots/r1.velocity")
    pad = widget("robots/r1.velocity", ".pad")
    page.wait_for(f"{pad} !== null && {widget('robots/r1.velocity')}.text !== undefined")
    page.evaluate(f"{pad}.focus()")
    page.key("ArrowLeft", ("keyDown",))
    page.wait_for(f"{widget('robots/r1.velocity', 'output')}.textContent.endsWith(' 1')")


def test_a_joystick_that_is_let_go_sets_its_rest(home: Site) -> None:
    held(home)
    home.page.key("ArrowLeft", ("keyUp",))
    home.page.wait_for(
        f"{widget('robots/r1.velocity', 'output')}.textContent === '0  0  0  0  0  0'"
    )
    assert velocity_of(home) == REST


def test_a_page_that_goes_lets_go(home: Site) -> None:
    held(home)
    home.come_back()
    home.page.wait_for("document.querySelector('.counts li') !== null")
    until(lambda: velocity_of(home) == REST, "the robot rests")
    home.page.key("ArrowLeft", ("keyUp",))


@pytest.mark.parametrize("ending", ["silence", "stream"])
def test_the_server_lets_go_for_a_page_that_cannot(home: Site, ending: str) -> None:
    home.shell.ok("rtset robots/r1.velocity.timeout 60")
    moving = "(0.0 0.0 0.0 0.0 0.0 0.5)"
    rest = {"rest": REST, "after": 2.0 if ending == "stream" else 0.1}
    given = {"page": "held", "target": DRIVE, "value": moving, **rest}
    with home.web.stream("held") as stream:
        stream.next("picture")
        home.web.post("/api/properties/set", given)
        if ending == "silence":
            until(lambda: velocity_of(home) == REST, "the robot rests")
        else:
            assert velocity_of(home) == moving
    until(lambda: velocity_of(home) == REST, "the robot rests")
    answer = home.web.ask("POST", "/api/properties/set", given)
    assert answer.status == 404  # nobody would let it go


def test_the_camera_is_seen(home: Site) -> None:
    home.go("robots/r1.sensors.camera.image")
    home.page.wait_for("document.querySelector('rt-image img')?.naturalWidth > 0")


def test_a_component_of_a_service_has_its_property_and_nothing_else(home: Site) -> None:
    page, shell = home.page, home.shell
    shell.ok("rtset lab.part.value 1")
    home.go("lab.part")
    page.wait_for("document.querySelector('rt-frame button') !== null")
    page.evaluate("document.querySelector('rt-frame button').click()")
    page.wait_for(f"({widget('lab.part.report')}.text ?? '').length > 20")
    found = dict(
        each.rsplit(" ", 1) for each in json.loads(json.loads(home.get("lab.part.report")))
    )
    assert int(found.pop("violations")) >= 8
    assert found == {
        **dict.fromkeys(("parent", "top", "storage", "cookie"), "SecurityError"),
        "open": "NullError", "fetch": "TypeError", "own server": "TypeError",
        "set below": "done", "get below": "2.5",
        **dict.fromkeys(("above", "listen", "call"), "denied"),
        # These begin, and come to nothing: see who has called.
        **dict.fromkeys(("beacon", "socket", "worker", "form", "peer"), "done"),
    }  # fmt: skip
    page.wait_for("window.troubles.some((each) => each.startsWith('frame-src'))")
    page.evaluate("window.troubles = []")  # it was led away, which the page's policy has stopped
    assert home.get("lab.secret") == '"none of its business"'


def test_a_page_that_is_read_only_sets_nothing(home: Site) -> None:
    with served(home.shell, "--read-only") as web:
        body = {"target": "home/lights/hall.on", "value": "true"}
        answer = web.ask("POST", "/api/properties/set", body)
        assert (answer.status, answer.body["error"]["kind"]) == (403, "denied")
        page = home.page
        address = page.evaluate("location.href")
        page.go(f"http://127.0.0.1:{web.port}/#token={web.token}&view=properties&of=robots/r1")
        page.wait_for("document.querySelector('rt-map polygon') !== null")
        able = "rt-panel :is(input, select, textarea, button):not(:disabled), rt-panel .tools"
        assert page.evaluate(f"document.querySelectorAll({able!r}).length") == 0
        assert page.evaluate("document.querySelector('rt-joystick .pad').tabIndex") == -1
        page.go(address)


@pytest.mark.skipif(not AXE.exists(), reason="node has not installed axe-core")
def test_axe_finds_no_barrier(home: Site) -> None:
    page, axe, found = home.page, AXE.read_text(encoding="utf-8"), []
    for is_dark in (False, True):
        page.look(is_dark=is_dark)
        for of, part in (
            ("robots/r1", "rt-map polygon"),
            ("/localhost/r1.rtc", "rt-choice"),
            ("page:home/files.drive.page", "rt-slider"),
        ):
            home.go(of)
            page.wait_for(f"document.querySelector('{part}') !== null")
            found += page.violations(axe)
    assert found == []
