"""Measures ``rtkit web``: how soon it answers, and how it bears a thousand components.

Its page is looked at by a real browser, and its server by the processor time that it takes.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from bench.harness import Lines, Missing, Row, command, create, manager, remove, until_listed
from bench.pairs import alone, paired
from rtkit.deployment.actions import Action, ChangeState, Connect
from rtkit.rtc.enums import Transition
from rtkit.rtc.profiles import ConnectorProfile, PortRef
from rtkit.tree.client import Tree

sys.path.append(str(Path(__file__).parents[1] / "tests" / "support"))
import browser  # type: ignore[import-not-found]

_COMPONENTS, _WIRES, _SLAVES = 1000, 200, 10
_MODULES = str(Path(__file__).parent / "components")
_MOVES = 180
_WATCHED_S = 5.0
_BARE = [sys.executable, "-m", "bench.bare_web"]
_WINDOW = (1280, 800)
_BOXES = "document.querySelector('.react-flow__node') !== null"
_NO_BOXES = "document.querySelector('.stage .empty')?.textContent.includes('No component')"
_PANE, _BOX = ".react-flow__pane", ".speck, .component"
_PLACE = """((selector) => {
    for (let y = %d; y < %d; y += 4) for (let x = %d; x < %d; x += 4)
        if (document.elementFromPoint(x, y)?.matches(selector)) return JSON.stringify([x, y]);
})(%s)"""
_COUNT_FRAMES = """(() => {
    const frames = window.frameTimes = [];
    let last = performance.now();
    const next = (now) => { frames.push(now - last); last = now; window.frameId =
        requestAnimationFrame(next); };
    window.frameId = requestAnimationFrame(next);
})()"""
_FRAMES_SO_FAR = "cancelAnimationFrame(window.frameId), JSON.stringify(window.frameTimes)"


@contextmanager
def _serving(line: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Run what prints an address or a port; yield its process and that."""
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    with subprocess.Popen(
        line, stdout=subprocess.PIPE, text=True, env=environment, stderr=subprocess.DEVNULL
    ) as process:
        assert process.stdout is not None
        try:
            yield process.pid, process.stdout.readline().strip()
        finally:
            process.terminate()


def _ready_s(line: Sequence[str]) -> float:
    """Return how long it is from the start of a server to its first answer [s]."""
    began = time.perf_counter()
    with _serving(line) as (_, said):
        address = f"http://127.0.0.1:{said}/" if said.isdigit() else said.partition("#")[0]
        with urllib.request.urlopen(address) as answer:
            answer.read()
        return time.perf_counter() - began


def _ready() -> Lines:
    ours = [command("rtweb"), "--no-browser"]
    with manager():
        measured = paired(lambda: _ready_s(ours), lambda: _ready_s(_BARE), 7)
    what = "rtkit web, from its start to its first answer"
    yield Row(what, "s", measured, 0.6, False, "Starlette and uvicorn that serve one text")


def _at_work(tree: Tree) -> None:
    """Have so many components, with so many wires at work."""
    texts = [f"Tick?instance_name=N{i}&manager_name=n{i % _SLAVES}" for i in range(_COMPONENTS)]
    create(tree, texts)
    until_listed(tree, _COMPONENTS)
    pairs = [(f"N{2 * n}", f"N{2 * n + 1}") for n in range(_WIRES)]
    ends = ((PortRef(one, "out"), PortRef(other, "into")) for one, other in pairs)
    wires = (ConnectorProfile(f"w{n}", f"w{n}", pair) for n, pair in enumerate(ends))
    actions: list[Action] = [Connect(each) for each in wires]
    actions += [ChangeState(name, "0", Transition.ACTIVATE) for pair in pairs for name in pair]
    for result in tree.apply(actions, timeout_s=60.0):
        result.raise_for_error()


def _many() -> Lines:
    if browser.NAME is None:
        yield Missing("rtkit web, 1,000 components", "no chromium on this machine")
        return
    with manager(_MODULES) as tree:
        with tempfile.TemporaryDirectory(prefix="rtb") as folder:
            yield from _looked_at(tree, folder)
        remove(tree, _COMPONENTS)


def _looked_at(tree: Tree, folder: str) -> Lines:
    line = [command("rtweb"), "--no-browser"]
    with browser.opened(folder, "", "") as page:
        page.picture(os.devnull, *_WINDOW)
        still_ms = _dragged(page, _X, _Y)
        with _serving(line) as (_, address):
            alone_s = _first_s(page, address, _NO_BOXES)
        _at_work(tree)
        with _serving(line) as (pid, address):
            first_s = _first_s(page, address, _BOXES)
            name = f"rtkit web, {_COMPONENTS} components, {_WIRES} wires at 10 Hz"
            floor = "the same page without a component"
            yield Row(f"{name}: first picture", "s", alone(first_s, alone_s), 3.0, False, floor)
            floor = "a page without anything"
            moves: dict[str, Callable[[], float]] = {
                "panning": lambda: _dragged(page, *_place(page, _PANE)),
                "dragging a box": lambda: _dragged(page, *_place(page, _BOX)),
                "zooming": lambda: _frames(page, _zoom),
            }
            for what, move in moves.items():
                move_ms = move()
                yield Row(f"{name}: frame while {what}", "ms", alone(move_ms, still_ms), 20.0,
                          False, floor)  # fmt: skip
            share = _share(pid)
            floor = "one processor"
            yield Row(f"{name}: its server", "%", alone(share, 100.0), 50.0, False, floor)


def _first_s(page: browser.Browser, address: str, is_shown: str) -> float:
    """Return how long a page takes from its address to its first picture [s].

    Before the server knows the components it shows that there are none.
    """
    began = time.perf_counter()
    page.go(address)
    page.wait_for(is_shown)
    return time.perf_counter() - began


Hand = Callable[[browser.Browser, int], object]
"""Moves the picture: the step that it is at is told."""
_X, _Y = _WINDOW[0] / 2, _WINDOW[1] / 3


def _place(page: browser.Browser, selector: str) -> tuple[float, float]:
    """Return where the mouse meets such an element, and may go on to the right and down [px]."""
    area = int(_Y), int(_Y) + 200, int(_X) - 300, int(_X) + 100
    x, y = json.loads(page.evaluate(_PLACE % (*area, json.dumps(selector))))
    return x, y


def _dragged(page: browser.Browser, x: float, y: float) -> float:
    """Return the median time from one frame to the next while what is at a place is drawn [ms]."""
    page.mouse("mousePressed", x, y)
    frame_ms = _frames(
        page, lambda page, at: page.mouse("mouseMoved", x + 3 * (at % 60), y + at % 60)
    )
    page.mouse("mouseReleased", x, y)
    return frame_ms


def _frames(page: browser.Browser, move: Hand) -> float:
    """Return the median time from one frame to the next while the mouse is at work [ms]."""
    page.evaluate(_COUNT_FRAMES)
    for step in range(_MOVES):
        move(page, step)
    times: list[float] = json.loads(page.evaluate(_FRAMES_SO_FAR))
    return statistics.median(times)


def _zoom(page: browser.Browser, step: int) -> None:
    """Zoom in until names are read, out until boxes are specks, and so on."""
    page.wheel(_X, _Y, -100 if step % 60 < 30 else 100)


def _share(pid: int) -> float:
    """Return how much of a processor a process takes while nothing is done [%]."""
    began, used = time.monotonic(), _used_s(pid)
    time.sleep(_WATCHED_S)
    return (_used_s(pid) - used) / (time.monotonic() - began) * 100


def _used_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


PARTS: dict[str, Callable[[], Lines]] = {"ready": _ready, "many": _many}
