"""Makes docs/web/walk.webp: a minute with the demo robot in ``rtkit web``, by a real browser.

Run it in the virtual environment, with chromium on the PATH, and pillow, which nothing else needs:
``python -m pip install pillow; python tools/web_walk.py``.
"""

from __future__ import annotations

import os
import re
import signal
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))

import browser  # noqa: E402 (found by the line above)
from web_pictures import served, shell  # noqa: E402 (beside this file)

OUT = ROOT / "docs" / "web" / "walk.webp"
SYSTEM = "sensor-controller-motor.xml"
PATROL = ROOT / "tests" / "unit" / "services" / "statemachine" / "patrol.ttl"
SENSOR, CONTROLLER, MOTOR = (f"/localhost/{n}0.rtc" for n in ("Sensor", "Controller", "Motor"))
SIZE = (1200, 800)
_SHOWN_S = 2.4
_CAPTION = """(text => {
    const bar = document.getElementById('walk') ?? document.createElement('div');
    document.body.append(bar);
    bar.id = 'walk';
    bar.textContent = text;
    Object.assign(bar.style, {position: 'fixed', left: '50%', bottom: '18px', zIndex: 99,
        transform: 'translateX(-50%)', padding: '8px 18px', borderRadius: '8px', color: '#fff',
        font: '600 17px system-ui', background: '#14202bee', width: 'max-content',
        maxWidth: '90%', pointerEvents: 'none'});
})"""
"""Shows a caption above the page; the place of the text is filled in."""


class Walk:
    """The page on a walk: each step is brought about, told in a caption, and taken."""

    def __init__(self, page: browser.Browser, folder: Path) -> None:
        self.page = page
        self._folder = folder
        self._taken: list[Path] = []

    def take(self, caption: str, shown_s: float = _SHOWN_S, *, is_dark: bool = False) -> None:
        """Take the page as it is, with a caption."""
        self.page.evaluate(f"{_CAPTION}({caption!r})")
        self.page.rest()
        file = self._folder / f"{len(self._taken):03}-{round(shown_s * 1000)}.png"
        self.page.picture(str(file), *SIZE, is_dark=is_dark)
        self._taken.append(file)
        print(f"{len(self._taken):2}  {caption}", flush=True)

    def until(self, condition: str) -> None:
        """Wait until something is so on the page."""
        self.page.wait_for(condition)

    def go(self, fragment: str, condition: str) -> None:
        """Go to a view and wait until it is there."""
        self.page.evaluate(f"location.hash = {fragment!r}")
        self.page.wait_for(condition)

    def save(self) -> None:
        """Write all that was taken as one moving picture."""
        first, *more = [Image.open(each).convert("RGB") for each in self._taken]
        lengths = [int(each.stem.partition("-")[2]) for each in self._taken]
        first.save(  # lossless: texts stay sharp, and nothing shines through
            OUT,
            save_all=True,
            append_images=more,
            duration=lengths,
            loop=0,
            lossless=True,
            method=4,
        )
        total_s = sum(lengths) / 1000
        print(f"{OUT.relative_to(ROOT)}: {total_s:.0f} s, {OUT.stat().st_size >> 10} KiB")


def node(component: str) -> str:
    """Return the selector of a component in the diagram."""
    return f'.react-flow__node[data-id="{component}"]'


def there(selector: str) -> str:
    """Return the condition that something is on the page."""
    return f"document.querySelector({selector!r}) !== null"


def shows(selector: str, text: str) -> str:
    """Return the condition that an element has a text."""
    return f"(document.querySelector({selector!r})?.textContent ?? '').includes({text!r})"


def look(component: str, word: str) -> str:
    """Return the condition that a component of the diagram has a look."""
    return there(f"{node(component)} .look-{word}")


def bring_up(walk: Walk, file: str) -> None:
    """Plan the robot, and apply the plan."""
    walk.until(there(".stage .empty"))
    walk.take("rtkit web shows what runs: nothing yet")
    walk.go(f"#view=plan&of=do:{file}", there(".deeds"))
    walk.page.press("Show the plan")
    walk.until("document.querySelectorAll('.steps .layer').length > 2")
    walk.take("Plans: what rtapply would do to bring up a robot, layer by layer")
    walk.page.press("Apply now")
    walk.until(shows(".plans-main", "17 of 17"))
    walk.take("Each step is told as it is done, in all pages that are open")


def watch(walk: Walk, file: str) -> None:
    """Look at the robot while it drives."""
    page = walk.page
    shell(f"rtstart {file}")
    walk.go("#view=diagram", look(MOTOR, "active"))
    walk.until(there(".wire text.value"))
    walk.take("In a shell: rtstart. The page follows: states, rates and values on the wires")
    page.key("k", is_control=True)
    walk.until(there("dialog[open] input"))
    page.type("dialog input", "contr")
    walk.take("Ctrl K finds components, ports, types and actions")
    page.key("Enter")
    walk.until(there(".inspector .ports"))
    walk.take("The inspector: state, execution contexts, ports, configuration")
    page.click(".ports button[aria-expanded]")
    walk.until("document.querySelectorAll('.last-values tbody tr').length > 3")
    page.awaited("new Promise((done) => setTimeout(done, 4000))")  # so that the plot has a line
    walk.take("Any port is plotted, recorded, or given a value")


def change(walk: Walk) -> None:
    """Connect something by keyboard, and take it back."""
    page = walk.page
    shell("rtmgr -c ConsoleOut -c ConsoleIn /localhost/manager.mgr")
    source = "/localhost/ConsoleIn0.rtc"
    walk.until(there(node(source)))
    walk.go(f"#select={source}", there(".inspector .ports"))
    page.key("c")
    walk.until(there("dialog .far-ports input[type=radio]"))
    walk.take("C connects: the ports that fit, and why others do not")
    page.click("dialog .far-ports input[type=radio]")
    page.click("dialog button.primary")
    walk.until(there(".toasts pre"))
    walk.take("Every action is a command line: copy it, or take it back by Ctrl Z")
    page.key("z", is_control=True)
    walk.until(shows(".toasts", "Undo: Connect"))
    walk.take("Undone: the same, the other way round")
    page.evaluate("document.querySelectorAll('.toast .close').forEach((each) => each.click())")


def breaks(walk: Walk) -> None:
    """Kill a process, and look at what was."""
    page = walk.page
    (pid,) = re.findall(r"Process ID: (\d+)", shell("rtcat /localhost/manager.mgr/motor.mgr"))
    os.kill(int(pid), signal.SIGKILL)
    walk.until(look(MOTOR, "zombie"))
    walk.go(f"#select={MOTOR}", there(".inspector .remark"))
    walk.take("kill -9: the page says at once what has died, and of what")
    page.evaluate("document.querySelector('.time-line input').focus()")
    for _ in range(3):
        page.key("ArrowLeft")
    walk.until(there(".banner-past"))
    walk.take("The time line leads back to any moment before")
    page.key("Escape")
    walk.until(f"!({there('.banner-past')})")


def rooms(walk: Walk, home: str, file: str) -> None:
    """Look into the other rooms."""
    page = walk.page
    walk.go(f"#view=plan&of=compare:{file}", there(".facts li"))
    walk.take("Compare: what lives beside what the profile says")
    walk.go("#view=log", there(".log"))
    page.press("Start")
    walk.until("document.querySelectorAll('.log tbody tr').length > 2")
    walk.take("Log: of a component, a process or everything, filtered by conditions")
    walk.go(f"#view=document&of={file}", there(".document .react-flow__node"))
    walk.until(there(".document-types .rows button"))
    walk.take("Offline: system profiles are drawn with nothing running, and checked at each edit")
    walk.go("#view=builder", there("#builder-name"))
    page.type("#builder-name", "Gain")
    page.key("Enter")
    walk.until(shows(".code", "class Gain"))
    page.press("Data ports")
    page.press("Add an out port")
    walk.until(shows(".code", "OutPort"))
    walk.take("Builder: a component by forms; its code is there as you type")
    create = "StateMachine?instance_name=Patrol&conf.default.service=patrol"
    shell(f"rtmgr -c '{create}' /localhost/manager.mgr")
    shell("rtact /localhost/Patrol.rtc")
    shell(f"rtset patrol.machine --file {PATROL}")
    shell("rtset patrol.run start")
    shell("rtset patrol.event go")
    walk.go("#view=machine&of=patrol", there(".state.is-active"))
    walk.take("State machines: lit while they run, and edited while they run")
    walk.go("#view=properties&of=patrol", there("main"))
    walk.until("document.querySelectorAll('main button, main input').length > 3")
    walk.until("document.querySelector('.room.properties')?.innerText.includes('running')")
    walk.take("Properties: everything can be got, set and listened to, by widgets")


def play(walk: Walk, home: str) -> None:
    """Play all scenes."""
    file = f"{home}/robots/{SYSTEM}"
    bring_up(walk, file)
    watch(walk, file)
    change(walk)
    breaks(walk)
    rooms(walk, home, file)
    walk.page.look(is_dark=True)
    walk.go("#view=diagram", there(node(SENSOR)))
    walk.take("Light and dark, English and Japanese, by mouse or by keys alone", is_dark=True)


def main() -> None:
    """Walk with a robot of its own, in a folder of its own."""
    with TemporaryDirectory(prefix="rtkit-", dir="/tmp") as home:
        os.environ |= {"HOME": home, "XDG_RUNTIME_DIR": f"{home}/run", "TMPDIR": home}
        for name in ("run", "robots", "frames"):
            os.makedirs(f"{home}/{name}", 0o700)
        profiles = [ROOT / "profiles" / "systems" / SYSTEM]
        profiles += (ROOT / "profiles").glob("*.xml")
        for each in profiles:
            Path(home, "robots", each.name).write_bytes(each.read_bytes())
        shell("rtmgr start")
        try:
            with served(f"{home}/robots") as address, browser.opened(home, "", "") as page:
                page.picture(os.devnull, *SIZE)
                page.go(address)
                walk = Walk(page, Path(home, "frames"))
                play(walk, home)
                walk.save()
        finally:
            shell("rtmgr stop")


if __name__ == "__main__":
    main()
