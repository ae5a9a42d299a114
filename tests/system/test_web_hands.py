"""The page in a real browser, by mouse and by keys alone: several at once, parts of a system."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import browser
import pytest
from shells import Shell
from webkit import served

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
MANAGER = "/localhost/manager.mgr"
IN, OUT, CONFIG = "/localhost/In0.rtc", "/localhost/Out0.rtc", "/localhost/C0.rtc"
AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
EDGE = ".react-flow__edge"
DIALOG = "dialog[open]"


def node(id: str) -> str:
    return f'.react-flow__node[data-id="{id}"]'


def has(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)}) !== null"


def tells(selector: str, text: str) -> str:
    """Return whether one of some elements has a text in it."""
    found = f"[...document.querySelectorAll({json.dumps(selector)})]"
    return f"{found}.some((each) => each.textContent.includes({json.dumps(text)}))"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path.resolve()


@pytest.fixture
def page(manager: Shell, folder: Path) -> Iterator[browser.Browser]:
    manager.ok(
        "rtmgr -c 'ConsoleIn?instance_name=In0' -c 'ConsoleOut?instance_name=Out0'"
        f" -c 'ConfigSample?instance_name=C0' {MANAGER}"
    )
    with served(manager, f"--root {folder}") as client, browser.opened(str(folder), "", "") as page:
        page.picture("/dev/null", 1440, 900)
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.wait_for(has(node(OUT)))
        yield page
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


def search(page: browser.Browser, text: str) -> None:
    """Go where, or do what, the palette finds by some letters."""
    page.key("k", is_control=True)
    page.wait_for(has(f"{DIALOG} [role=combobox]"))
    page.type(f"{DIALOG} [role=combobox]", text)
    page.wait_for(tells(f"{DIALOG} [role=option][aria-selected=true]", text))
    page.key("Enter")


def tab_to(page: browser.Browser, selector: str) -> None:
    """Press Tab until something has the focus."""
    for _ in range(200):
        if page.evaluate(f"document.activeElement?.matches({json.dumps(selector)})"):
            return
        page.key("Tab")
    raise AssertionError(f"Tab does not reach {selector}")


def test_connect_configure_activate_and_save_by_keys_alone(
    page: browser.Browser, manager: Shell, folder: Path
) -> None:
    search(page, "In0")
    page.wait_for(tells(".inspector h2", "In0"))
    page.key("c")
    page.wait_for(has(f"{DIALOG} .options input[type=radio]"))
    tab_to(page, f"{DIALOG} .options input[type=radio]")
    page.key(" ")
    page.key("Enter")
    page.wait_for(has(EDGE))

    search(page, "C0")
    page.wait_for(tells(".inspector h2", "C0"))
    tab_to(page, ".inspector .slider input[type=text]")
    page.key("a", is_control=True)
    page.key("8")
    page.key("Enter")
    page.wait_for(tells(".toasts", "rtconf"))
    assert manager.ok(f"rtconf {CONFIG} get int_param0") == "8\n"

    search(page, "In0")
    page.wait_for(tells(".inspector h2", "In0"))
    search(page, "Activate")
    page.wait_for(has(f"{node(IN)} .look-active"))

    search(page, "Plans")
    page.wait_for(has(".plans input[type=text]"))
    tab_to(page, ".plans input[type=text]")
    page.wait_for(f"document.activeElement.value.startsWith({json.dumps(str(folder))})")
    page.key("Enter")
    page.wait_for(tells(".toasts", "rtcryo"))
    assert "Out0" in (folder / "system.yaml").read_text(encoding="utf-8")


def test_what_was_undone_is_done_again(page: browser.Browser, manager: Shell) -> None:
    search(page, "In0")
    page.wait_for(tells(".inspector h2", "In0"))
    search(page, "Activate")
    for key, is_shift, look in (
        ("z", False, "inactive"), ("z", True, "active"),
        ("z", False, "inactive"), ("y", False, "active"),
    ):  # fmt: skip
        page.key(key, is_control=True, is_shift=is_shift)
        page.wait_for(has(f"{node(IN)} .look-{look}"))
    assert "Active" in manager.ok(f"rtls -l {IN}")


def middle(page: browser.Browser, selector: str) -> tuple[float, float]:
    """Return the middle of the head of a box, when the box rests."""
    left, top, width, _ = page.place(selector)
    return left + width / 2, top + 12


def test_several_are_selected_and_become_a_composite(page: browser.Browser, manager: Shell) -> None:
    manager.ok(f"rtcon -i w {IN}:out {OUT}:in")
    page.wait_for(has(EDGE))
    for id, is_control in ((IN, False), (OUT, True)):
        for kind in ("mousePressed", "mouseReleased"):
            page.mouse(kind, *middle(page, node(id)), is_control=is_control)
    page.wait_for("document.querySelectorAll('.component.is-selected').length === 2")
    for kind in ("mousePressed", "mouseReleased"):
        page.mouse(kind, *middle(page, node(OUT)), is_control=True)
    page.wait_for("document.querySelectorAll('.component.is-selected').length === 1")
    page.key("ArrowRight", is_shift=True)
    page.key("ArrowLeft", is_shift=True)
    page.wait_for("document.querySelectorAll('.component.is-selected').length >= 2")
    page.key("a", is_control=True)
    page.wait_for("document.querySelectorAll('.component.is-selected').length === 3")
    page.evaluate(f"location.hash = '#select={IN}&select={OUT}'")

    page.press("Make a composite …")
    page.wait_for(has(f"{DIALOG} .grid input"))
    page.type(f"{DIALOG} .grid input", "Both")
    page.press("Create")
    page.wait_for(tells(".react-flow__node-frame", "Both"))
    assert "Both.rtc" in manager.ok("rtls /localhost")
    page.evaluate("location.hash = '#select=/localhost/Both.rtc'")
    page.press("Look inside")
    page.wait_for(tells(".scope-bar [aria-current=page]", "Both"))
    page.wait_for(f"!({has(node(CONFIG))})")
    page.press("Show all")
    page.wait_for(has(node(CONFIG)))
    page.press("Dissolve")
    page.wait_for(f"!({tells('.react-flow__node-frame', 'Both')})")
    page.key("z", is_control=True)
    page.wait_for(tells(".react-flow__node-frame", "Both"))
    assert "Both.rtc" in manager.ok("rtls /localhost")


def test_only_what_is_connected_is_shown(page: browser.Browser, manager: Shell) -> None:
    manager.ok(f"rtcon -i w {IN}:out {OUT}:in")
    page.wait_for(has(EDGE))
    page.evaluate(f"location.hash = '#select={IN}'")
    page.press("Only what is connected")
    page.wait_for(tells(".scope-bar", "2 of 3 components"))
    page.wait_for(f"!({has(node(CONFIG))}) && {has(node(OUT))}")
    assert f"near={IN}" in page.evaluate("location.hash")
    assert not page.evaluate(tells("[role=treeitem]", "C0"))


@pytest.mark.skipif(not AXE.exists(), reason="node has not installed axe-core")
def test_axe_finds_no_barrier_in_any_view(page: browser.Browser, manager: Shell) -> None:
    manager.ok(f"rtcon -i w {IN}:out {OUT}:in")
    manager.ok(f"rtcomp -a {IN}:out -a {OUT} {MANAGER}:Both")
    page.wait_for(has(EDGE))
    axe = AXE.read_text(encoding="utf-8")
    both = "/localhost/Both.rtc"
    found: list[str] = []

    def look(name: str) -> None:
        found.extend(f"{name}: {each}" for each in page.violations(axe))

    for is_dark in (False, True):
        page.look(is_dark=is_dark)
        for view, part, opens in (
            (f"select={both}", ".composite-parts", ["Make a composite …", "End"]),
            (f"select={both}&inside={both}", ".scope-bar", ["?"]),
            (f"select={IN}&select={OUT}&near={IN}", ".scope-bar", ["Make a composite …"]),
            (f"select={CONFIG}", ".configuration .buttons", ["Copy …"]),
            (f"select={MANAGER}", ".inspector .danger", ["Loaded modules …", "Stop", "k"]),
            ("kind=composite", ".tree .more[open]", ["Start a manager …", "Export …"]),
            ("select=w", ".inspector .fields", []),
        ):
            page.evaluate(f"location.hash = '#{view}'")
            page.wait_for(has(part))
            look(view)
            for each in opens:
                if each == "Make a composite …" and view.startswith(f"select={both}"):
                    continue  # one that is a composite offers it not
                if len(each) == 1:
                    page.key(each, is_control=each == "k")
                else:
                    page.press(each)
                page.wait_for(has(DIALOG))
                look(f"{view}, {each}")
                page.key("Escape")
                page.wait_for(f"!({has(DIALOG)})")
    assert found == []


@pytest.mark.skipif(not AXE.exists(), reason="node has not installed axe-core")
def test_axe_finds_no_barrier_where_the_page_is_locked_or_lost(
    manager: Shell, folder: Path
) -> None:
    axe = AXE.read_text(encoding="utf-8")
    process = manager.open("rtweb --no-browser")
    assert process.stdout is not None
    address = process.stdout.readline().strip()
    with browser.opened(str(folder), "", "") as page:
        for is_dark in (False, True):
            page.look(is_dark=is_dark)
            page.go("about:blank")
            page.go(f"{address.partition('#')[0]}#token=wrong")
            page.wait_for(has(".locked [role=alert]"))
            assert page.violations(axe) == []
        page.go("about:blank")
        page.go(address)
        page.wait_for(has("[role=treeitem]"))
        process.kill()
        process.communicate()
        page.wait_for(has(".banner-lost"))
        for is_dark in (False, True):
            page.look(is_dark=is_dark)
            assert page.violations(axe) == []
