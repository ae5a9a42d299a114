"""The page of the system editor in a real browser, beside a real manager and its commands."""

from __future__ import annotations

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
IN, OUT = "/localhost/In0.rtc", "/localhost/Out0.rtc"


def node(id: str) -> str:
    return f'.react-flow__node[data-id="{id}"]'


def port(id: str, name: str) -> str:
    return f'{node(id)} [data-handleid="{name}"]'


def is_there(selector: str) -> str:
    return f"document.querySelector('{selector}') !== null"


def has_text(selector: str, text: str) -> str:
    return f"(document.querySelector('{selector}')?.textContent ?? '').includes({text!r})"


EDGE = ".react-flow__edge"


def middle(page: browser.Browser, selector: str) -> tuple[float, float]:
    """Return the middle of an element of the diagram, which is moved and not scrolled."""
    box = f"document.querySelector('{selector}').getBoundingClientRect()"
    found = page.evaluate(f"[{box}.x + {box}.width / 2, {box}.y + {box}.height / 2].join()")
    x, y = map(float, found.split(","))
    return x, y


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


def test_the_dead_are_told_by_word_and_shape(page: browser.Browser, tree: Tree) -> None:
    (slave,) = (each.pid for each in tree.snapshot().processes if each.is_slave)
    os.kill(slave, signal.SIGKILL)
    page.wait_for(is_there(f"{node(OUT)} .look-zombie"))
    page.wait_for(has_text(node(OUT), "zombie"))


def test_ports_are_connected_by_mouse_and_it_is_undone(
    page: browser.Browser, manager: Shell
) -> None:
    start, end = middle(page, port(IN, "out")), middle(page, port(OUT, "in"))
    page.mouse("mouseMoved", *start)
    page.mouse("mousePressed", *start)
    for part in (0.3, 0.6, 1.0):
        page.mouse("mouseMoved", *(a + part * (b - a) for a, b in zip(start, end, strict=True)))
    page.wait_for(is_there(".hint[role=status]"))
    page.mouse("mouseReleased", *end)
    page.wait_for(is_there("dialog.connect[open] button.primary:not([disabled])"))
    page.click("dialog.connect button.primary")
    page.wait_for(is_there(EDGE))
    assert "Out0.rtc:in" in manager.ok(f"rtcat -l {IN}")
    page.wait_for(has_text(".toasts", "rtcon"))
    page.key("z", is_control=True)
    page.wait_for(f"!({is_there(EDGE)})")
    assert "Out0.rtc:in" not in manager.ok(f"rtcat -l {IN}")


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
