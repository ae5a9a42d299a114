"""Offline diagrams of the page: system profiles, edited with nothing running."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser
import pytest
from shells import Shell
from webkit import WebClient, served

from rtkit.profile.read import read_file
from rtkit.profile.rts_model import RtsProfile
from rtkit.resources import resource

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
NAME = "sensor-controller-motor.xml"
NODE = ".document .react-flow__node"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A granted folder with a system profile."""
    granted = tmp_path / "granted"
    granted.mkdir()
    (granted / NAME).write_bytes(Path(resource("profiles"), "systems", NAME).read_bytes())
    return granted


@pytest.fixture
def client(shell: Shell, folder: Path) -> Iterator[WebClient]:
    with served(shell, f"--root {folder}") as client:
        yield client


def profile_in(file: Path) -> RtsProfile:
    profile = read_file(str(file)).profile
    assert isinstance(profile, RtsProfile)
    return profile


def test_an_edit_is_told_to_all_pages_and_saved_when_asked(client: WebClient, folder: Path) -> None:
    file = folder / NAME
    before = file.read_bytes()
    with client.stream() as other:
        other.next("picture")
        picture = client.post("/api/documents/open", {"file": str(file)})
        path = f"/api/documents/{picture['id']}"
        assert client.post("/api/documents/open", {"file": str(file)})["id"] == picture["id"]
        edit = {"do": "rename", "component": "Motor0", "name": "Wheels"}
        changed = client.post(f"{path}/edit", {"edit": edit})
        news = other.next("document")
        assert news == {"id": picture["id"], "revision": changed["revision"]}
        assert client.post(path, {})["components"] == changed["components"]
        assert file.read_bytes() == before
        file.write_bytes(before + b"\n")
        answer = client.ask("POST", f"{path}/save", {})
        assert answer.status == 409
        assert "changed by somebody else" in answer.body["error"]["text"]
        assert not client.post(f"{path}/save", {"replace": True})["is_changed"]
    assert "Wheels" in {each.instance_name for each in profile_in(file).components}


def test_files_outside_of_the_granted_folders_are_refused(
    client: WebClient, folder: Path, tmp_path: Path
) -> None:
    outside = tmp_path / "outside.xml"
    outside.write_bytes((folder / NAME).read_bytes())
    (folder / "link.xml").symlink_to(outside)
    for file in (outside, folder / ".." / "outside.xml", folder / "link.xml"):
        answer = client.ask("POST", "/api/documents/open", {"file": str(file)})
        assert answer.status == 409, answer
    picture = client.post("/api/documents/new", {"name": "New"})
    for file in (tmp_path / "made.xml", folder / "link.xml", folder / "made.txt"):
        save = {"file": str(file), "replace": True}
        answer = client.ask("POST", f"/api/documents/{picture['id']}/save", save)
        assert answer.status == 409, answer
    assert outside.read_bytes() == (folder / NAME).read_bytes()


def test_a_page_that_only_reads_opens_and_changes_nothing(shell: Shell, folder: Path) -> None:
    with served(shell, f"--read-only --root {folder}") as client:
        picture = client.post("/api/documents/open", {"file": str(folder / NAME)})
        path = f"/api/documents/{picture['id']}"
        asked: list[tuple[str, Any]] = [
            (f"{path}/edit", {"edit": {"do": "arrange"}}), (f"{path}/move", {"way": "undo"}),
            (f"{path}/save", {}), ("/api/documents/new", {"name": "New"}),
        ]  # fmt: skip
        for at, body in asked:
            assert client.ask("POST", at, body).status == 403, at


def test_what_was_not_saved_outlives_the_server(shell: Shell, folder: Path) -> None:
    file = folder / NAME
    rename = {"edit": {"do": "rename", "component": "Motor0", "name": "Wheels"}}
    process = shell.open(f"rtweb --no-browser --root {folder}")
    assert process.stdout is not None
    port, token = process.stdout.readline().split("127.0.0.1:")[1].split("/#token=")
    first = WebClient(int(port), token.strip())
    picture = first.post("/api/documents/open", {"file": str(file)})
    first.post(f"/api/documents/{picture['id']}/edit", rename)
    made = first.post("/api/documents/new", {"name": "Fresh"})
    type = first.ask("GET", "/api/documents/types").body["types"][0]["file"]
    add = {"edit": {"do": "add", "type": type}}
    first.post(f"/api/documents/{made['id']}/edit", add)
    assert first.ask("GET", "/api/documents").body["drafts"] == []
    with served(shell, f"--root {folder}") as other:  # the first one lives, and has them open
        assert other.ask("GET", "/api/documents").body["drafts"] == []
    process.kill()
    process.wait()
    with served(shell, f"--root {folder}") as client:
        drafts = {each["name"]: each for each in client.ask("GET", "/api/documents").body["drafts"]}
        assert set(drafts) == {"Fresh", picture["name"]}
        draft = {"draft": drafts[picture["name"]]["id"]}
        back = client.post("/api/documents/drafts/take", draft)
        assert "Wheels" in {each["name"] for each in back["components"]}
        assert (back["file"], back["is_changed"]) == (str(file), True)
        assert client.ask("POST", "/api/documents/drafts/take", draft).status == 404
        client.post("/api/documents/drafts/drop", {"draft": drafts["Fresh"]["id"]})
        assert client.ask("GET", "/api/documents").body["drafts"] == []
    # Ended in order, it leaves what was not saved; what the file became meanwhile is not lost.
    file.write_bytes(file.read_bytes() + b"\n")
    with served(shell, f"--root {folder}") as client:
        (draft,) = client.ask("GET", "/api/documents").body["drafts"]
        back = client.post("/api/documents/drafts/take", {"draft": draft["id"]})
        assert client.ask("POST", f"/api/documents/{back['id']}/save", {}).status == 409
        client.post(f"/api/documents/{back['id']}/save", {"replace": True})
        assert client.ask("GET", "/api/files").body["files"] == [str(file)]
    with served(shell, f"--root {folder}") as client:
        assert client.ask("GET", "/api/documents").body["drafts"] == []


def test_only_system_profiles_are_listed(client: WebClient, folder: Path) -> None:
    texts = {"a.json": "{}", "b.yaml": "a: 1", "c.xml": "<x/>", "d.xml": "<rtc:RtcProfile/>"}
    for name, text in texts.items():
        (folder / name).write_text(text)
    assert client.ask("GET", "/api/files").body["files"] == [str(folder / NAME)]


def node(id: str) -> str:
    return f'{NODE}[data-id="{id}"]'


def is_there(selector: str) -> str:
    return f"document.querySelector({selector!r}) !== null"


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_a_diagram_is_edited_in_the_browser(
    client: WebClient, folder: Path, tmp_path: Path
) -> None:
    file = folder / NAME
    with browser.opened(str(tmp_path), "", "") as page:
        page.picture("/dev/null", 1440, 900)  # sets the size of the window
        page.go(f"http://127.0.0.1:{client.port}/#view=document&token={client.token}")
        page.press(NAME)
        page.wait_for(is_there(node("Motor0")))
        # By keyboard: a type of the list, a name, a connector.
        page.wait_for(is_there(".document-types .rows button:not([disabled])"))  # connected
        page.type(".document-types input", "controller")
        page.wait_for("document.querySelectorAll('.document-types .rows button').length === 1")
        page.evaluate("document.querySelector('.document-types .rows button').focus()")
        page.key("Enter")
        page.wait_for(is_there(node("Controller1")))
        page.type(".document-inspector form input", "Brain")
        page.key("Enter")
        page.wait_for(is_there(node("Brain")))
        page.evaluate(f"document.querySelector({node('Brain')!r}).focus()")
        page.key("c")
        page.press("Sensor0:distance")
        page.wait_for("document.querySelectorAll('.document .react-flow__edge').length === 4")
        # By mouse: a box is moved, which is one edit.
        x, y = page.middle(f"{node('Motor0')} header")
        for kind, dx in (("mouseMoved", 0), ("mousePressed", 0), ("mouseMoved", 30),
                         ("mouseMoved", 60), ("mouseReleased", 60)):  # fmt: skip
            page.mouse(kind, x + dx, y)
        page.wait_for("document.body.textContent.includes('Move Motor0')")
        page.key("s", is_control=True)
        page.wait_for(f"!({is_there('.document .changed')})")
        saved = profile_in(file)
        assert {each.instance_name for each in saved.components} >= {"Brain", "Motor0"}
        assert len(saved.data_port_connectors) == 4
        # Back to the beginning.
        page.evaluate("document.querySelector('.document-stage').focus()")
        for _ in range(4):
            page.evaluate("document.activeElement.blur()")
            page.key("z", is_control=True)
        page.wait_for(f"!({is_there(node('Controller1'))}) && !({is_there(node('Brain'))})")
        page.wait_for(is_there(".document .changed"))
        assert page.troubles() == []


def drag(page: browser.Browser, selector: str, dx: int, dy: int) -> None:
    x, y = page.middle(selector)
    for kind, part in (("mouseMoved", 0), ("mousePressed", 0), ("mouseMoved", 0.5),
                       ("mouseMoved", 1), ("mouseReleased", 1)):  # fmt: skip
        page.mouse(kind, x + part * dx, y + part * dy)


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_boxes_are_resized_and_turned_and_wires_are_bent(
    shell: Shell, folder: Path, tmp_path: Path
) -> None:
    file = folder / NAME
    text = file.read_text(encoding="utf-8")
    stated = 'rts:name="patience" rts:data="0.5"'
    assert stated in text
    file.write_text(text.replace(stated, stated.replace("0.5", "${patience}")))
    with (
        served(shell, f"--root {folder}") as client,
        browser.opened(str(tmp_path), "", "") as page,
    ):
        page.picture("/dev/null", 1440, 900)
        address = f"http://127.0.0.1:{client.port}/#token={client.token}&view=document&of={file}"
        page.go(address)
        page.wait_for(is_there(node("Motor0")))
        page.wait_for(is_there(".document-types .rows button:not([disabled])"))  # connected
        picture = client.post("/api/documents/open", {"file": str(file)})
        path = f"/api/documents/{picture['id']}"
        page.evaluate(f"document.querySelector({node('Motor0')!r}).focus()")
        page.key("Enter")
        page.wait_for(is_there(".sizer"))
        drag(page, ".sizer", 60, 40)
        page.wait_for("document.body.textContent.includes('Done: Resize Motor0')")
        place = client.post(path, {})["places"]["Motor0"]
        box = picture["layout"]["boxes"]["Motor0"]
        assert place["width"] > box["width"] + 30
        assert place["height"] > box["height"] + 20
        # By keyboard: a direction, and a width.
        page.evaluate("document.querySelector('.place-form').closest('details').open = true")
        page.evaluate("document.querySelector('.place-form select').focus()")
        for direction in ("LEFT", "DOWN"):
            page.key("ArrowDown")
            page.wait_for(f"document.body.textContent.includes('Done: Turn Motor0 {direction}')")
        page.wait_for(is_there(f"{node('Motor0')} .port.at-top"))
        page.type(".place-form label:nth-of-type(3) input", "333")
        page.key("Enter")
        page.wait_for("document.querySelectorAll('.place-form .primary').length === 0")
        place = client.post(path, {})["places"]["Motor0"]
        assert (place["width"], place["direction"]) == (333, "DOWN")
        # A wire: bent by mouse, then by keyboard; its options.
        wire = picture["connectors"][0]["id"]
        edge = f'.react-flow__edge[data-id="{wire}"]'
        page.evaluate(f"document.querySelector({edge!r}).focus()")
        page.key("Enter")
        page.wait_for(is_there(f"{edge} .bend.is-new"))
        drag(page, f"{edge} .bend.is-new", 10, 60)
        page.wait_for(is_there(f"{edge} .bend:not(.is-new)"))
        ((x, y),) = client.post(path, {})["bends"][wire]
        page.wait_for(is_there(".bend-form input"))
        page.type(".bend-form .row input:nth-of-type(2)", str(y + 25))
        page.key("Enter")
        page.wait_for(is_there(f"{edge} .bend[cy='{y + 25}']"))
        assert client.post(path, {})["bends"][wire] == [[x, y + 25]]
        page.press("Options …")
        page.wait_for(is_there("dialog[open] .grid select"))
        page.evaluate("document.querySelector('dialog[open] .grid select').focus()")
        page.key("f")
        page.press("Apply")
        page.wait_for("document.body.textContent.includes('Done: Set properties')")
        properties = client.post(path, {})["connectors"][0]["properties"]
        assert properties["dataport.subscription_type"] == "flush"
        # A value with a variable is replaced by nobody who did not say so.
        page.evaluate(f"document.querySelector({node('Motor0')!r}).focus()")
        page.key("Enter")
        field = ".document-inspector .configuration .configuration input"
        page.wait_for(is_there(field))
        page.type(field, "0.25")
        page.key("Enter")
        page.wait_for(is_there("dialog[open] .danger"))
        assert "${patience}" in page.evaluate("document.querySelector('dialog[open]').innerText")
        page.press("Cancel")
        page.wait_for("document.body.textContent.includes('The variables were kept')")
        page.key("s", is_control=True)
        page.wait_for(f"!({is_there('.document .changed')})")
        assert "${patience}" in file.read_text(encoding="utf-8")
        # Chromium says so when a box changes its size while it is measured; nothing is lost by it.
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


@pytest.mark.skipif(not AXE.is_file(), reason="axe-core is not installed")
@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_axe_finds_nothing(client: WebClient, folder: Path, tmp_path: Path) -> None:
    axe = AXE.read_text(encoding="utf-8")
    with browser.opened(str(tmp_path), "", "") as page:
        page.picture("/dev/null", 1440, 900)
        page.go(f"http://127.0.0.1:{client.port}/#view=document&token={client.token}")
        page.wait_for(is_there(".documents .links button"))
        found = []
        for is_dark in (False, True):
            page.look(is_dark=is_dark)
            page.evaluate("location.hash = 'view=document'")
            page.wait_for(is_there(".documents .links button"))
            found += page.violations(axe)
            page.evaluate(f"location.hash = 'view=document&of={folder / NAME}'")
            page.wait_for(is_there(node("Motor0")))
            page.wait_for(is_there(".document-types .rows button"))
            found += page.violations(axe)
            page.evaluate(f"document.querySelector({node('Motor0')!r}).focus()")
            page.key("c")
            page.wait_for(is_there("dialog[open] .links button"))
            found += page.violations(axe)
            page.key("Escape")
            page.wait_for(f"!({is_there('dialog[open]')})")
            page.wait_for(is_there(".document-inspector .configuration"))
            found += page.violations(axe)
        assert found == []
