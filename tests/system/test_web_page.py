"""The page of the system editor in a real browser, beside a real manager and its commands."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import browser
import pytest
from shells import Shell
from webkit import served

from rtkit.tree.client import Tree

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
IN, OUT, CONFIG = "/localhost/In0.rtc", "/localhost/Out0.rtc", "/localhost/C0.rtc"
AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"


def node(id: str) -> str:
    return f'.react-flow__node[data-id="{id}"]'


def port(id: str, name: str) -> str:
    return f'{node(id)} [data-handleid="{name}"]'


def is_there(selector: str) -> str:
    return f"document.querySelector('{selector}') !== null"


def has_text(selector: str, text: str) -> str:
    return f"(document.querySelector('{selector}')?.textContent ?? '').includes({text!r})"


EDGE = ".react-flow__edge"


@pytest.fixture
def page(manager: Shell, tmp_path: Path) -> Iterator[browser.Browser]:
    """The page of a system with two components that may be connected."""
    manager.ok(
        "rtmgr -c 'ConsoleIn?instance_name=In0' -c 'ConsoleOut?instance_name=Out0&manager_name=s1'"
        " -c 'ConfigSample?instance_name=C0' /localhost/manager.mgr"
    )
    with served(manager) as client, browser.opened(str(tmp_path), "", "") as page:
        page.picture("/dev/null", 1440, 900)  # sets the size of the window
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.wait_for(is_there(node(OUT)))
        assert page.evaluate("location.hash") == ""
        yield page
        # A note of the browser that sizes are settled in the next frame; React Flow knows it.
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


def test_what_a_shell_does_appears(page: browser.Browser, manager: Shell) -> None:
    page.wait_for(has_text(node(IN), "Inactive"))
    manager.ok(f"rtcon {IN}:out {OUT}:in")
    page.wait_for(is_there(EDGE))
    manager.ok(f"rtact {IN}")
    page.wait_for(has_text(node(IN), "Active"))
    page.wait_for(is_there(f"{node(IN)} .look-active"))
    manager.ok(f"rtdis {IN}")
    page.wait_for(f"!({is_there(EDGE)})")
    manager.ok(f"rtexit {IN}")
    page.wait_for(f"!({is_there(node(IN))})")


def test_wires_between_two_ports_are_apart_and_each_is_picked(
    page: browser.Browser, manager: Shell
) -> None:
    address = page.evaluate("location.href")
    page.go("about:blank")
    for id in ("one", "two"):
        manager.ok(f"rtcon -i {id} {IN}:out {OUT}:in")
    page.go(address)  # now both are there from the first layout on
    page.wait_for(f"document.querySelectorAll('{EDGE} .react-flow__edge-path').length === 2")
    look = f"""JSON.stringify([...document.querySelectorAll('{EDGE}')].map((edge) => {{
        const path = edge.querySelector('.react-flow__edge-path');
        const seen = path.getBoundingClientRect(), box = path.getBBox();
        const at = path.getPointAtLength(path.getTotalLength() / 2);
        const scale = seen.width / box.width;
        return [seen.y + (at.y - box.y) * scale, seen.x + (at.x - box.x) * scale,
            edge.dataset.id];
    }}))"""
    page.place(node(OUT))  # which waits until the picture rests
    for which, aside, zooms in ((0, -9, 0), (1, 9, 0), (0, -9, 3), (1, 9, 0)):
        for _ in range(zooms):
            page.evaluate("""document.querySelector('[aria-label="Zoom out"]').click()""")
        page.place(node(OUT))
        places = sorted(json.loads(page.evaluate(look)))
        assert 1 < places[1][0] - places[0][0] < 10
        # The areas of both lie over each other: the nearer wire is meant, also by who misses it.
        y, x, id = places[which]
        page.hover(x, y + aside)
        page.wait_for(is_there(f'{EDGE}[data-aimed][data-id="{id}"]'))
        for kind in ("mousePressed", "mouseReleased"):
            page.mouse(kind, x, y + aside)
        page.wait_for(is_there(f'{EDGE}[data-id="{id}"] .wire.is-selected'))


def test_the_dead_are_told_by_word_and_shape(page: browser.Browser, tree: Tree) -> None:
    (slave,) = (each.pid for each in tree.snapshot().processes if each.is_slave)
    os.kill(slave, signal.SIGKILL)
    page.wait_for(is_there(f"{node(OUT)} .look-zombie"))
    page.wait_for(has_text(node(OUT), "zombie"))


def test_ports_are_connected_by_mouse_and_it_is_undone(
    page: browser.Browser, manager: Shell
) -> None:
    start, end = page.middle(port(IN, "out")), page.middle(port(OUT, "in"))
    page.mouse("mouseMoved", *start)
    page.mouse("mousePressed", *start)
    for part in (0.3, 0.6, 1.0):
        page.mouse("mouseMoved", *(a + part * (b - a) for a, b in zip(start, end, strict=True)))
    page.wait_for(is_there(".hint[role=status]"))
    page.mouse("mouseReleased", *end)
    page.wait_for(is_there("dialog.connect[open] button.primary:not([disabled])"))
    page.key("Enter")
    page.wait_for(is_there(EDGE))
    assert "Out0.rtc:in" in manager.ok(f"rtcat -l {IN}")
    page.wait_for(has_text(".toasts", "rtcon"))
    page.key("z", is_control=True)
    page.wait_for(f"!({is_there(EDGE)})")
    assert "Out0.rtc:in" not in manager.ok(f"rtcat -l {IN}")


def test_a_wire_ends_with_its_finger_though_its_box_was_scrolled_out_of_sight(
    page: browser.Browser,
) -> None:
    page.finger("touchStart", *page.middle(port(IN, "out")))
    left, top, width, height = page.place(".react-flow")
    for part in (0.5, 0.8, 1.0):
        page.finger("touchMove", left + part * (width - 4), top + height / 2)
    page.wait_for(is_there(".hint[role=status]"))
    page.wait_for(f"!({is_there(node(IN))})")
    page.finger("touchEnd")
    page.wait_for(f"!({is_there('.hint[role=status]')})")
    page.wait_for(f"!({is_there('.react-flow__connection')})")


def test_connect_tells_that_its_source_has_gone(page: browser.Browser, manager: Shell) -> None:
    page.evaluate(f"location.hash = '#select={IN}'")
    page.wait_for(has_text(".inspector h2", "In0"))
    page.key("c")
    page.wait_for(is_there("dialog.connect[open] select"))
    manager.ok(f"rtexit {IN}")
    page.wait_for(has_text("dialog.connect[open]", "In0 has gone"))
    page.wait_for(f"!({is_there('dialog.connect select')})")


def test_connect_and_activate_by_keyboard_alone(page: browser.Browser, manager: Shell) -> None:
    page.evaluate(f"document.querySelector('{node(IN)}').focus()")
    page.key("Enter")
    page.wait_for(has_text("body", "ConsoleIn"))
    page.key("c")
    page.wait_for(is_there("dialog.connect input[type=radio]"))
    page.evaluate("document.querySelector('dialog.connect input[type=radio]').focus()")
    page.key(" ")
    page.key("Enter")
    page.wait_for(is_there(EDGE))
    page.key("k", is_control=True)
    page.wait_for(is_there("dialog[open] input"))


def shown(page: browser.Browser, id: str) -> None:
    """Select what the tree shows under this path."""
    row = f"document.querySelector('[role=treeitem][title={json.dumps(id)}]')"
    page.wait_for(f"{row} !== null")
    page.evaluate(f"{row}.click()")


NAME, MARKUP = "<s>N", "<img src=x onerror=alert()>"


def test_components_are_made_and_ended_by_forms_and_markup_stays_text(
    page: browser.Browser, manager: Shell
) -> None:
    made = f"/localhost/{NAME}.rtc"
    shown(page, "/localhost/manager.mgr/s1.mgr")
    page.press("Create a component …")
    page.wait_for(is_there("dialog[open] .options input"))
    page.type("dialog input[type=search]", "consolein")
    page.wait_for("document.querySelectorAll('dialog .options input').length === 1")
    page.click("dialog .options input")
    page.type("dialog .grid input", NAME)
    page.press("Create")
    shown(page, made)
    page.wait_for(has_text(".inspector h2", NAME))
    assert f"{NAME}.rtc" in manager.ok("rtls /localhost")
    manager.ok(f"rtcon '{made}:out' {OUT}:in")
    page.wait_for(is_there(EDGE))
    page.evaluate("location.hash = '#view=table&filter=%3Cs%3E'")
    page.wait_for(has_text(".tables", NAME))
    page.press("End")
    page.wait_for(has_text("dialog.plan", f"with it the connector from {made}:out to {OUT}:in"))
    page.press("Do it")
    page.wait_for(f"!({has_text('.tables', NAME)})")
    assert page.evaluate("document.querySelector('s')") is None


def test_values_are_set_by_widgets_and_rates_stand_on_wires(
    page: browser.Browser, manager: Shell
) -> None:
    manager.ok(f"rtconf {CONFIG} set str_param1 '{MARKUP}'")
    manager.ok("rtmgr -c SeqOut -c SeqIn /localhost/manager.mgr")
    manager.ok("rtcon /localhost/SeqOut0.rtc:Long /localhost/SeqIn0.rtc:Long")
    manager.ok("rtact /localhost/SeqOut0.rtc")
    page.wait_for(has_text(EDGE, "Hz"))
    shown(page, CONFIG)
    page.wait_for(f"[...document.querySelectorAll('input')].some((e) => e.value === {MARKUP!r})")
    page.type(".inspector .slider input[type=text]", "7")
    page.press("Apply (1)")
    page.wait_for(has_text(".toasts", "rtconf"))
    assert manager.ok(f"rtconf {CONFIG} get int_param0") == "7\n"
    assert page.evaluate("document.querySelector('img[src=x]')") is None


def test_a_link_opens_the_same_view_and_the_picture_is_saved(
    page: browser.Browser, tmp_path: Path
) -> None:
    shown(page, OUT)
    page.wait_for(f"location.hash === '#select={OUT}'")
    page.evaluate("location.hash = '#view=table&filter=Out0&state=inactive'")
    page.wait_for(has_text(".tables", "Out0") + f" && !{has_text('.tables', 'In0')}")
    page.save_to(str(tmp_path))
    page.press("Export …")
    page.press("SVG")
    page.saved()
    (saved,) = tmp_path.glob("*.svg")
    assert "Out0" in saved.read_text(encoding="utf-8")


@pytest.mark.skipif(not AXE.exists(), reason="node has not installed axe-core")
def test_axe_finds_no_barrier(page: browser.Browser, manager: Shell) -> None:
    manager.ok(f"rtcon {IN}:out {OUT}:in")
    page.wait_for(is_there(EDGE))
    axe = AXE.read_text(encoding="utf-8")
    found = []
    for is_dark in (False, True):
        page.look(is_dark=is_dark)
        for view, part in (
            ("#view=table", ".tables"),
            (f"#select={CONFIG}", ".inspector .parameter"),
            (f"#select={IN}", ".inspector .ports"),
        ):
            page.evaluate(f"location.hash = '{view}'")
            page.wait_for(is_there(part))
            found += page.violations(axe)
        for key in ("c", "/"):
            page.key(key)
            page.wait_for(is_there("dialog[open]"))
            found += page.violations(axe)
            page.key("Escape")
            page.wait_for(f"!({is_there('dialog[open]')})")
    assert found == []
