"""States that were brought about: the page tells them by word, shape and colour, as rtls does."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser
import pytest
from shells import Shell
from webkit import WebClient, served

from rtkit.tree.client import Tree

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
MANAGER = "/localhost/manager.mgr"
BAD = '''
from rtkit.component import Component


class Bad(Component):
    """Fail."""

    rate = 100.0

    def on_execute(self, context):
        raise ValueError("no hand")


def BadInit(manager):
    manager.register_factory(Bad)
'''
LOOKS = {
    "On0": "active", "In0": "inactive", "Bad0": "error", "Z0": "zombie", "S0": "stuck",
    "R0": "restarting", "U0": "unknown",
}  # fmt: skip
BOXES = "[...document.querySelectorAll('.react-flow__node .component')]"
SEEN = f"""JSON.stringify({BOXES}.map((box) => {{
    const icon = box.querySelector('.state-icon');
    return [box.querySelector('strong').textContent, [
        box.className.match(/look-(\\w+)/)[1], box.querySelector('.word').textContent,
        icon.innerHTML, getComputedStyle(icon).getPropertyValue('--look'),
        box.querySelector('.remark')?.textContent ?? '']];
}}))"""


@pytest.fixture
def client(manager: Shell) -> Iterator[WebClient]:
    (manager.folder / "Bad.py").write_text(BAD, encoding="utf-8")
    made = ["Bad", "ConsoleIn?instance_name=In0", "ConsoleIn?instance_name=On0",
            "ConsoleIn?instance_name=U0&execution_contexts=none",
            "ConsoleOut?instance_name=Z0&manager_name=z",
            "ConsoleOut?instance_name=S0&manager_name=s",
            "ConsoleOut?instance_name=R0&manager_name=r"
            "&rtkit.restart=on-failure&rtkit.restart.delay=10"]  # fmt: skip
    manager.ok(f"rtmgr -l ./Bad.py:BadInit {' '.join(f'-c {each!r}' for each in made)} {MANAGER}")
    with served(manager) as client:
        yield client


@pytest.fixture
def page(client: WebClient, tmp_path: Path) -> Iterator[browser.Browser]:
    with browser.opened(str(tmp_path), "", "") as page:
        page.picture("/dev/null", 1440, 900)
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.wait_for("document.querySelectorAll('.react-flow__node .component').length === 7")
        yield page


def seen(page: browser.Browser) -> dict[str, list[str]]:
    """Return look, word, shape, colour and remark of each component, by its name."""
    found: dict[str, list[str]] = dict(json.loads(page.evaluate(SEEN)))
    return found


def is_look(name: str, look: str) -> str:
    return (f"[...document.querySelectorAll('.react-flow__node .component.look-{look} strong')]"
            f".some((each) => each.textContent === '{name}')")  # fmt: skip


def listed(shell: Shell) -> dict[str, str]:
    """Return the lines of ``rtls -l`` by the names of components."""
    lines = shell.ok("rtls -l /localhost").splitlines()
    return {each.partition(".rtc")[0].split()[-1].lstrip("*"): each for each in lines}


@pytest.fixture
def slaves(tree: Tree) -> Iterator[dict[str, int]]:
    pids = {each.name: each.pid for each in tree.snapshot().processes if each.is_slave}
    yield pids
    os.kill(pids["s"], signal.SIGCONT)


def test_each_state_is_told_by_word_shape_and_colour(
    page: browser.Browser, manager: Shell, client: WebClient, slaves: dict[str, int]
) -> None:
    manager.ok("rtact /localhost/On0.rtc")
    manager.ok("rtact /localhost/Bad0.rtc")
    os.kill(slaves["z"], signal.SIGKILL)
    os.kill(slaves["r"], signal.SIGKILL)
    os.kill(slaves["s"], signal.SIGSTOP)
    for name, look in LOOKS.items():
        page.wait_for(is_look(name, look))
    boxes, lines = seen(page), listed(manager)
    assert {name: box[0] for name, box in boxes.items()} == LOOKS
    for name, (look, word, _, _, remark) in boxes.items():
        told = lines[name]
        if look in ("zombie", "restarting"):  # of whom rtls tells no state, but a mark
            assert told.split()[-2].startswith("*") or f"*{name}.rtc" in told
            assert word == look
        else:
            assert told.split()[0] == word
        if look != "restarting":  # which counts down
            assert f"({remark})" in told if remark else "(" not in told
    shapes, colours = ({box[at] for box in boxes.values()} for at in (2, 3))
    assert len(shapes) == len(colours) == len(LOOKS)

    # All lists and the tree say the same.
    page.evaluate("location.hash = '#view=table'")
    page.wait_for("document.querySelector('.tables tbody tr') !== null")
    for name, look in LOOKS.items():
        word = json.dumps(boxes[name][1])
        page.wait_for(f"[...document.querySelectorAll('.tables tbody tr')].some((row) =>"
                      f" row.querySelector('th')?.textContent === '{name}' &&"
                      f" row.querySelector('td.look-{look}')?.textContent.trim()"
                      f" === {word})")  # fmt: skip


def test_what_was_lost_looks_lost_and_comes_back(
    page: browser.Browser, manager: Shell, tree: Tree
) -> None:
    os.kill(tree.snapshot().pid, signal.SIGKILL)
    page.wait_for("document.querySelector('.banner')?.textContent.includes('manager')")
    page.wait_for("document.querySelectorAll('.component.look-unreachable').length === 7")
    boxes = seen(page)
    assert {box[0] for box in boxes.values()} == {"unreachable"}
    assert {box[1] for box in boxes.values()} == {"unreachable"}
    manager.ok("rtmgr start")
    page.wait_for("document.querySelector('.banner') === null")
    page.wait_for("document.querySelector('.component.look-unreachable') === null")


def test_a_page_without_its_server_looks_alive_no_more(manager: Shell, tmp_path: Path) -> None:
    process: Any = manager.open("rtweb --no-browser")
    address = process.stdout.readline().strip()
    with browser.opened(str(tmp_path), "", "") as page:
        page.go(address)
        page.wait_for("document.querySelector('[role=treeitem]') !== null")
        process.kill()
        page.wait_for("document.querySelector('.page.is-stale') !== null")
        page.wait_for("document.querySelector('.banner-lost') !== null")
        assert page.evaluate("document.querySelector('.undo, .group button:disabled') !== null")
    process.communicate()
