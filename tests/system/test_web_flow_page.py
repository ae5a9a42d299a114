"""What flows and what happened, in a real browser: values, plots, the past, logs, pictures."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import browser
import pytest
from shells import Shell
from webkit import served

pytestmark = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
OUT, IN, GOAL = "/localhost/SeqOut0.rtc", "/localhost/SeqIn0.rtc", "/localhost/Motor0.rtc"
AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
NODE = ".react-flow__node"


def is_there(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)}) !== null"


def has_text(selector: str, text: str) -> str:
    shown = f"(document.querySelector({json.dumps(selector)})?.textContent ?? '')"
    return f"{shown}.includes({json.dumps(text)})"


@pytest.fixture(scope="module")
def flow(shared_shell: Shell) -> Iterator[Shell]:
    shared_shell.ok("rtmgr start")
    shared_shell.ok("rtmgr -c 'SeqOut?manager_name=eyes' -c SeqIn -c Motor /localhost/manager.mgr")
    shared_shell.ok(f"rtcon -i one {OUT}:Long {IN}:Long")
    shared_shell.ok(f"rtact {OUT}")
    yield shared_shell
    shared_shell.ok("rtmgr stop")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("granted")


@pytest.fixture(scope="module")
def page(flow: Shell, folder: Path) -> Iterator[browser.Browser]:
    """One page for all tests; each goes to its view first."""
    with served(flow, f"--root {folder}") as client, browser.opened(str(folder), "", "") as page:
        page.picture("/dev/null", 1440, 900)  # sets the size of the window
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.wait_for(is_there(NODE))
        yield page
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


def show(page: browser.Browser, fragment: str, selector: str) -> None:
    page.evaluate(f"location.hash = {fragment!r}")
    page.wait_for(is_there(selector))


def test_a_wire_tells_its_value_and_its_plot(page: browser.Browser) -> None:
    show(page, "#", ".wire text.value")
    # Nobody reads: the sign of a buffer that drops values stands beside the rate.
    page.wait_for(has_text(".wire text.is-tight", "▼"))
    show(page, "#select=one", ".plot canvas")
    page.wait_for("document.querySelectorAll('.last-values tbody tr').length === 8")
    page.wait_for(has_text(".port-values", "8 of 8"))
    first = page.evaluate("document.querySelector('.last-values td:last-child').textContent")
    page.wait_for(f"document.querySelector('.last-values td:last-child').textContent !== {first!r}")
    page.press("Hold the plot")
    page.wait_for(is_there(".port-values button[aria-pressed=true]"))
    page.press("Go on")


def test_a_port_is_recorded_by_keyboard(page: browser.Browser, flow: Shell, folder: Path) -> None:
    show(page, "#select=one", ".recorder button")
    page.evaluate("document.querySelector('.recorder button').focus()")
    page.key("Enter")
    page.wait_for(is_there(".recorder form"))
    page.type(".recorder input[type=text]", "wire.mcap")
    page.key("Enter")
    page.wait_for(has_text(".recorder", f"rtlog --filename={folder}/wire.mcap"))
    while "SeqOut0_Long" not in flow.run(f"rtlog -d -f {folder}/wire.mcap").out:
        page.wait_for(is_there(".recorder .dot"))
    page.press("Stop the recording")
    page.wait_for(has_text(".recorder", "Recorded in wire.mcap"))


def test_a_value_is_checked_while_it_is_typed_and_written(page: browser.Browser) -> None:
    show(page, f"#select={GOAL}", ".ports button[aria-expanded]")
    page.click(".ports button[aria-expanded]")
    page.press("Write a value …")
    page.wait_for(is_there("dialog.inject .row input"))
    page.type("dialog.inject .row input", "fast")
    page.wait_for(has_text("dialog.inject .bad", "fast"))
    page.wait_for(is_there("dialog.inject button.primary[disabled]"))
    page.type("dialog.inject .row input", "0.25")
    page.wait_for(has_text("dialog.inject [role=status]", "It fits."))
    page.key("Enter")
    page.wait_for(has_text(".toasts", "rtinject"))
    page.wait_for(has_text(".port-values .value", "vx=0.25"))


def test_the_time_line_leads_to_a_past_moment_and_back(
    page: browser.Browser, flow: Shell, folder: Path
) -> None:
    brief = f'{NODE}[data-id="/localhost/Brief0.rtc"]'
    show(page, "#", ".time-line input")
    flow.ok("rtmgr -c 'ConfigSample?instance_name=Brief0' /localhost/manager.mgr")
    page.wait_for(is_there(brief))
    flow.ok("rtexit /localhost/Brief0.rtc")
    page.wait_for(f"!({is_there(brief)})")
    page.wait_for(is_there(".time-line rect"))
    page.evaluate("document.querySelector('.time-line input').focus()")
    page.key("ArrowLeft")
    page.wait_for(has_text(".banner-past", "As it was at"))
    page.wait_for(is_there(brief))
    page.wait_for(is_there(".is-past .stage"))
    # Nothing flows in the past, and nothing of it is changed.
    assert page.evaluate("document.querySelector('.wire text.value')") is None
    page.save_to(str(folder))
    page.press("Export …")
    page.wait_for(has_text("dialog", "The system as it was at"))
    page.press("dot")
    page.saved()
    (saved,) = folder.glob("*.dot")
    assert "Brief0" in saved.read_text("utf-8")
    show(page, "#select=/localhost/Brief0.rtc", ".inspector .buttons button")
    assert page.evaluate(
        "[...document.querySelectorAll('.inspector .buttons button')]"
        ".filter((e) => ['Activate', 'Deactivate', 'End'].includes(e.textContent))"
        ".every((e) => e.disabled)"
    )
    page.key("Escape")
    page.wait_for(f"!({is_there('.banner-past')}) && !({is_there(brief)})")
    page.wait_for(is_there(".wire text.value"))


def test_logs_are_followed_and_filtered(page: browser.Browser, folder: Path) -> None:
    show(page, "#view=log", ".room.log")
    page.press("Start")
    page.wait_for("document.querySelectorAll('.log tbody tr').length > 2")
    page.type(".log-group input[type=text]", "[")
    page.evaluate("""(() => { const how = document.querySelectorAll('.log-group .row select')[2];
        how.value = 'matches'; how.dispatchEvent(new Event('change', {bubbles: true})); })()""")
    page.wait_for(has_text(".log-filter .bad", "no regular expression"))
    page.type(".log-group input[type=text]", "^re.dy$")
    page.wait_for(
        "[...document.querySelectorAll('.log .message')].every((e) => e.textContent === 'ready')"
        " && document.querySelector('.log .message') !== null"
    )
    page.save_to(str(folder))
    page.press("Save as text …")
    page.saved()
    (saved,) = folder.glob("*-log.txt")
    assert all(line.endswith("ready") for line in saved.read_text("utf-8").splitlines())
    page.press("Save …")
    page.saved()
    page.press("Clear")
    page.wait_for(has_text(".log [role=status]", "0 of 0"))
    page.press("Stop")
    page.wait_for(has_text(".log header", "Start"))
    (saved,) = folder.glob("*-log.jsonl")
    count = len(saved.read_text("utf-8").splitlines())
    open_file(page, "mine.jsonl", saved.read_text("utf-8") + "cut of\n")
    page.wait_for(has_text(".log", "Records of mine.jsonl. One line is no record."))
    page.wait_for(has_text(".log [role=status]", f"{count} of {count}"))
    open_file(page, "other.jsonl", "hello\n")
    page.wait_for(has_text(".log [role=alert]", "no records of a log"))


def open_file(page: browser.Browser, name: str, text: str) -> None:
    """Have the user choose a file."""
    page.evaluate(f"""(() => {{
        const data = new DataTransfer(), field = document.querySelector('.log input[type=file]');
        data.items.add(new File([{json.dumps(text)}], {json.dumps(name)}));
        field.files = data.files;
        field.dispatchEvent(new Event('change', {{bubbles: true}}));
    }})()""")


def test_the_picture_is_saved_as_png(page: browser.Browser, folder: Path) -> None:
    show(page, "#", NODE)
    page.save_to(str(folder))
    page.press("Export …")
    page.press("PNG")
    page.wait_for(f"!({is_there('dialog[open]')})")
    page.saved()
    (saved,) = folder.glob("*.png")
    assert saved.read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(not AXE.exists(), reason="node has not installed axe-core")
def test_axe_finds_no_barrier(page: browser.Browser) -> None:
    axe = AXE.read_text(encoding="utf-8")
    found = []
    for is_dark in (False, True):
        page.look(is_dark=is_dark)
        for fragment, part in (("#select=one", ".plot canvas"), ("#view=log", ".room.log")):
            show(page, fragment, part)
            found += page.violations(axe)
        show(page, f"#select={GOAL}", ".ports button[aria-expanded]")
        page.click(".ports button[aria-expanded]")
        page.press("Write a value …")
        page.wait_for(has_text("dialog.inject [role=status]", "It fits."))
        found += page.violations(axe)
        page.key("Escape")
        page.evaluate("document.querySelector('.time-line input').focus()")
        page.key("Home")
        page.wait_for(is_there(".is-past"))
        found += page.violations(axe)
        page.key("Escape")
        page.wait_for(f"!({is_there('.is-past')})")
    assert found == []
