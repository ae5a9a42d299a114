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
_SETTLED = """document.querySelector('.react-flow__node') !== null
    || document.querySelector('.stage .empty')?.textContent.includes('No component')"""
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
        still_ms = _frames(page, _press, _move)
        with _serving(line) as (_, address):
            alone_s = _first_s(page, address)
        _at_work(tree)
        with _serving(line) as (pid, address):
            first_s = _first_s(page, address)
            name = f"rtkit web, {_COMPONENTS} components, {_WIRES} wires at 10 Hz"
            floor = "the same page without a component"
            yield Row(f"{name}: first picture", "s", alone(first_s, alone_s), 3.0, False, floor)
            floor = "a page without anything"
            for what, begin, end in (("panning", _press, _move), ("zooming", _aim, _zoom)):
                move_ms = _frames(page, begin, end)
                yield Row(f"{name}: frame while {what}", "ms", alone(move_ms, still_ms), 20.0,
                          False, floor)  # fmt: skip
            share = _share(pid)
            floor = "one processor"
            yield Row(f"{name}: its server", "%", alone(share, 100.0), 50.0, False, floor)


def _first_s(page: browser.Browser, address: str) -> float:
    """Return how long a page takes from its address to its first picture [s]."""
    began = time.perf_counter()
    page.go(address)
    page.wait_for(_SETTLED)
    return time.perf_counter() - began


Hand = Callable[[browser.Browser, int], object]
"""Moves the picture: the step that it is at is told."""
_X, _Y = _WINDOW[0] / 2, _WINDOW[1] / 3


def _frames(page: browser.Browser, begin: Hand, move: Hand) -> float:
    """Return the median time from one frame to the next while the picture is moved [ms]."""
    begin(page, 0)
    page.evaluate(_COUNT_FRAMES)
    for step in range(_MOVES):
        move(page, step)
    times: list[float] = json.loads(page.evaluate(_FRAMES_SO_FAR))
    page.mouse("mouseReleased", _X, _Y)
    return statistics.median(times)


def _press(page: browser.Browser, _step: int) -> None:
    page.mouse("mousePressed", _X, _Y)


def _move(page: browser.Browser, step: int) -> None:
    page.mouse("mouseMoved", _X + 3 * (step % 60), _Y + step % 60)


def _aim(page: browser.Browser, _step: int) -> None:
    page.mouse("mouseReleased", _X, _Y)


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
