"""The room that builds components: forms, preview, generated files, and a trial on a manager."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser
import pytest
from shells import Shell
from webkit import WebClient, served

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
GAIN, SINK = "/localhost/Gain0.rtc", "/localhost/SeqIn0.rtc"


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "robots"
    folder.mkdir()
    return folder


@pytest.fixture
def client(manager: Shell, root: Path) -> Iterator[WebClient]:
    with served(manager, f"--root {root}") as found:
        yield found


def form_of(client: WebClient, name: str, *outs: str) -> Any:
    form = client.post("/api/builder/new", {"name": name})["form"]
    form["dataPorts"] = [
        {"portType": "DataOutPort", "name": out, "type": "RTC::TimedDouble",
         "rtcExt::position": "RIGHT"}
        for out in outs
    ]  # fmt: skip
    return form


def test_a_form_is_previewed_written_and_opened_again(client: WebClient, root: Path) -> None:
    form, folder = form_of(client, "Gain", "out"), f"{root}/Gain"
    preview = client.post("/api/builder/preview", {"form": form, "folder": folder})
    assert preview["findings"] == []
    assert {each["name"]: each["before"] for each in preview["files"]} == dict.fromkeys(
        ["Gain.py", "tests/test_Gain.py", "README.md", "pyproject.toml", "system.xml", "RTC.xml"]
    )
    assert not os.path.exists(folder)
    done = client.post("/api/builder/write", {"form": form, "folder": folder})
    assert (done["ok"], done["command"]) == (True, f"rtbuild --output={folder} -")
    for each in preview["files"]:
        assert Path(each["path"]).read_text(encoding="utf-8") == each["after"]
    assert (
        client.ask("GET", "/api/builder").body["files"]
        == [f"{folder}/RTC.xml", f"{folder}/system.xml"][:1]
    )
    opened = client.post("/api/builder/open", {"file": f"{folder}/RTC.xml"})
    assert opened["form"] == form
    form["dataPorts"].append({**form["dataPorts"][0], "type": "Other::Type"})
    found = client.post("/api/builder/preview", {"form": form, "folder": folder})
    assert [(each["place"], each["level"]) for each in found["findings"]] == [
        ("dataPorts.1.name", "error")
    ]
    form["dataPorts"][1]["name"] = "other"
    found = client.post("/api/builder/preview", {"form": form, "folder": folder})
    assert [each["place"] for each in found["findings"]] == ["dataPorts.1.type"]
    text = client.post("/api/builder/export", {"form": form, "kind": "yaml"})["text"]
    again = client.post("/api/builder/open", {"text": text, "name": "a.yaml"})["form"]
    assert again == form


def test_files_outside_of_what_is_granted_are_left_alone(
    manager: Shell, client: WebClient, root: Path, tmp_path: Path
) -> None:
    form = form_of(client, "Gain")
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "README.md").write_text("secret")
    (root / "link").symlink_to(outside)
    (root / "Gain").mkdir()
    (root / "Gain/README.md").symlink_to(outside / "README.md")
    for folder in (str(outside), f"{root}/link", f"{root}/../outside", f"{root}/Gain", ""):
        for verb in ("preview", "write"):
            answer = client.ask("POST", f"/api/builder/{verb}", {"form": form, "folder": folder})
            told = json.dumps(answer.body)
            assert "links are not followed" in told or "no folder that this page" in told, folder
            assert "secret" not in told
    assert [each.read_text() for each in outside.iterdir()] == ["secret"]
    (outside / "RTC.xml").write_text("<secret/>")
    answer = client.ask("POST", "/api/builder/open", {"file": str(outside / "RTC.xml")})
    assert answer.status == 409
    with served(manager, f"--read-only --root {root}") as reader:
        body = {"form": form, "folder": f"{root}/New"}
        assert reader.ask("POST", "/api/builder/write", body).status == 403
        assert reader.post("/api/builder/preview", body)["findings"] == []
    with served(manager) as without_folders:
        body = {"form": form, "folder": ""}
        files = without_folders.post("/api/builder/preview", body)["files"]
        assert [each["before"] for each in files] == [None] * 6
        assert without_folders.ask("POST", "/api/builder/write", body).status == 409


def test_a_second_component_is_added_and_backups_stay_in_their_folder(
    client: WebClient, root: Path, tmp_path: Path
) -> None:
    folder = f"{root}/Gain"
    client.post("/api/builder/write", {"form": form_of(client, "Gain", "out"), "folder": folder})
    body = {"form": form_of(client, "Sum", "out"), "folder": folder}
    refused = client.post("/api/builder/preview", body)
    assert "--add puts it beside that one" in refused["findings"][-1]["text"]
    body["adds"] = True
    assert "Sum.py" in {each["name"] for each in client.post("/api/builder/preview", body)["files"]}
    done = client.post("/api/builder/write", body)
    assert (done["ok"], done["command"]) == (True, f"rtbuild --output={folder} --add -")
    assert {each.name for each in Path(folder).glob("*.py")} >= {"Gain.py", "Sum.py"}
    outside = tmp_path / "a.py.bak"
    outside.write_text("secret")
    Path(folder, "b.py.bak").symlink_to(outside)
    assert client.post("/api/builder/backups", {"folder": folder})["backups"] == []
    for path in (str(outside), f"{folder}/b.py.bak", f"{folder}/none.bak"):
        put = {"folder": folder, "backup": path}
        assert client.ask("POST", "/api/builder/put_back", put).status == 404
    assert client.post("/api/builder/clear", {"folder": folder}) == {"removed": 0}
    assert outside.read_text() == "secret"


def field(page: browser.Browser, label: str, number: int = 0) -> str:
    """Return a selector of the field with that label."""
    fields = "[...document.querySelectorAll('.builder-form .field')]"
    own = f"{fields}.filter((e) => e.querySelector('label').textContent === {label!r})[{number}]"
    page.wait_for(f"{own} !== undefined")
    return str(page.evaluate(f"'#' + CSS.escape({own}.querySelector('label').htmlFor)"))


def button(page: browser.Browser, text: str) -> str:
    found = "[...document.querySelectorAll('button')]"
    return f"{found}.find((each) => each.textContent === {text!r})"


def is_there(selector: str) -> str:
    return f"document.querySelector({selector!r}) !== null"


def shows(selector: str, text: str) -> str:
    return f"(document.querySelector({selector!r})?.textContent ?? '').includes({text!r})"


GOOD = is_there(".verdict .good")


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_a_component_is_built_tried_and_seen_on_a_wire(
    manager: Shell, client: WebClient, root: Path, tmp_path: Path
) -> None:
    manager.ok("rtmgr -c SeqIn /localhost/manager.mgr")
    with browser.opened(str(tmp_path), "", "") as page:
        page.picture("/dev/null", 1440, 900)  # sets the size of the window
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.press("Builder")
        page.wait_for(is_there("#builder-name"))
        page.type("#builder-name", "Gain")
        page.key("Enter")
        page.wait_for(shows(".code", "class Gain"))
        ports_are_named(page)
        code = root / "Gain/Gain.py"
        generate(page)
        assert "out = rt.OutPort(rt.TimedDouble)" in code.read_text(encoding="utf-8")
        edited_on_disk(code)
        parameter_is_added(page, code)
        profile_is_changed_on_disk(page, code.with_name("RTC.xml"))
        backups_are_put_back_and_cleared(page, code)
        tried(page, manager)
        after_a_reload(page)
        if AXE.exists():
            pages_have_no_barrier(page)
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


def ports_are_named(page: browser.Browser) -> None:
    page.press("Data ports")
    page.press("Add an out port")
    page.press("Add an in port")
    page.type(field(page, "Name", 1), "out")
    page.wait_for(shows(".builder-form", "There is a port out already"))
    page.wait_for(f"{button(page, 'Generate …')}.disabled")
    page.key("z", is_control=True)
    page.wait_for(GOOD)
    page.wait_for(shows(".code", "out = rt.OutPort(rt.TimedDouble)"))


def generate(page: browser.Browser) -> None:
    page.press("Generate …")
    page.wait_for(shows("dialog.generate[open]", "rtbuild --output="))
    page.press("Generate")
    page.wait_for(f"!({is_there('dialog[open]')})")
    page.wait_for(shows(".written", "rtbuild"))


def edited_on_disk(code: Path) -> None:
    """Write code between the marks, and a line outside of them."""
    text = code.read_text(encoding="utf-8")
    mark = "        # <user code on_execute>\n"
    text = text.replace(mark, f"{mark}        self.out.write(rt.TimedDouble(data=7.0))\n")
    code.write_text(text.replace("from rtkit", "# mine\nfrom rtkit"), encoding="utf-8")


def parameter_is_added(page: browser.Browser, code: Path) -> None:
    page.press("Configuration")
    page.press("Add a parameter")
    page.type(field(page, "Name"), "factor")
    page.wait_for(is_there(".fate-conflict"))
    page.wait_for(shows(".code", "factor = rt.Parameter"))
    page.press("Generate …")
    page.wait_for(is_there("dialog .comparison .is-new"))
    if AXE.exists():
        assert page.violations(AXE.read_text(encoding="utf-8")) == []
    for word, mine in (("Take the generated one", "-"), ("Keep mine", "-"), ("Merge both", "")):
        labels = "[...document.querySelectorAll('dialog .choices label')]"
        page.evaluate(f"{labels}.find((e) => e.textContent.startsWith({word!r})).click()")
        # Both have the line when they are merged: it is no difference then.
        is_gone = (
            "[...document.querySelectorAll('.is-gone')].some((e) => /# mine/.test(e.textContent))"
        )
        page.wait_for(is_gone if mine else f"!{is_gone}")
    page.press("Generate")
    page.wait_for(f"!({is_there('dialog[open]')})")
    page.wait_for(f"!{button(page, 'Try it …')}.disabled")
    text = code.read_text(encoding="utf-8")
    for part in ("# mine\n", "data=7.0", "factor = rt.Parameter(0.0)"):
        assert part in text
    assert "factor = " not in Path(f"{code}.bak").read_text(encoding="utf-8")


def profile_is_changed_on_disk(page: browser.Browser, profile: Path) -> None:
    """Somebody else changes the profile while the form has changes: both are brought together."""
    page.press("Add a parameter")
    page.type(field(page, "Name", 1), "offset")
    page.wait_for(shows(".code", "offset = rt.Parameter"))
    text = profile.read_text(encoding="utf-8")
    assert 'rtc:version="1.0.0"' in text
    profile.write_text(text.replace('rtc:version="1.0.0"', 'rtc:version="2.5.0"'), encoding="utf-8")
    page.evaluate("dispatchEvent(new Event('focus'))")
    page.wait_for(is_there(".outdated"))
    page.press("Generate …")
    page.wait_for(shows("dialog.generate .group", "RTC.xml ?"))
    page.wait_for("[...document.querySelectorAll('dialog footer button')].at(-1).disabled")
    page.key("Escape")
    page.wait_for(f"!({is_there('dialog[open]')})")
    page.press("Compare")
    page.wait_for(shows(".outdated .comparison", "2.5.0"))
    page.press("Bring both together")
    page.wait_for(f"!({is_there('.outdated')})")
    page.press("Generate …")
    page.wait_for(shows("dialog.generate[open]", "rtbuild --output="))
    # What the code was generated from is not known any more: it is kept or replaced as a whole.
    labels = "[...document.querySelectorAll('dialog .choices label')]"
    page.evaluate(f"{labels}.find((e) => e.textContent.startsWith('Take the generated')).click()")
    page.press("Generate")
    page.wait_for(f"!({is_there('dialog[open]')})")
    page.wait_for(f"!{button(page, 'Try it …')}.disabled")
    text = profile.read_text(encoding="utf-8")
    assert 'rtc:version="2.5.0"' in text
    assert '"offset"' in text
    assert not page.evaluate(is_there(".outdated"))


def backups_are_put_back_and_cleared(page: browser.Browser, code: Path) -> None:
    now = code.read_text(encoding="utf-8")
    page.press("Backups …")
    row = "dialog.generate .links li:first-child"
    page.wait_for(shows(row, "Gain.py.bak2"))
    page.click(f"{row} .link")
    page.wait_for(is_there("dialog.generate .comparison"))
    for sign in (".is-new", ".is-gone"):
        page.evaluate(f"document.querySelector('{row} button:last-child').click()")
        # What was there is the latest backup now: it is compared with what took its place.
        page.wait_for(
            f"[...document.querySelectorAll('dialog.generate {sign}')]"
            ".some((each) => each.textContent.includes('offset'))"
        )
    assert code.read_text(encoding="utf-8") == now
    count = len(list(code.parent.rglob("*.bak*")))
    for _ in range(2):  # the second time is the answer to a question
        page.press(f"Remove all {count} backups")
    page.wait_for(shows("dialog.generate", "There are no backups"))
    assert [each.name for each in code.parent.rglob("*.bak*")] == []
    page.press("Close")
    page.wait_for(f"!({is_there('dialog[open]')})")


def tried(page: browser.Browser, manager: Shell) -> None:
    page.press("Try it …")
    page.wait_for(is_there("dialog[open] select"))
    page.press("Load and create")
    page.wait_for(shows("dialog.plan", "Create Gain"))
    page.press("Do it")
    page.wait_for(is_there(f'.react-flow__node[data-id="{GAIN}"]'))
    page.wait_for(shows(".inspector h2", "Gain0"))
    manager.ok(f"rtcon {GAIN}:out {SINK}:Double")
    manager.ok(f"rtact {SINK}")
    page.press("Activate")
    page.wait_for(shows(".react-flow__edge", "Hz"))
    assert "7" in manager.ok(f"rtprint -n 1 {GAIN}:out")


def after_a_reload(page: browser.Browser) -> None:
    """The draft outlives a reload of the page."""
    page.evaluate("location.hash = '#view=builder'")
    page.reload()
    page.wait_for(shows(".code", "factor = rt.Parameter"))
    page.press("RTC.xml")
    page.wait_for(shows(".source textarea", "factor"))
    page.evaluate("""
        const area = document.querySelector(".source textarea");
        area.focus();
        area.setSelectionRange(area.value.indexOf("factor"), area.value.indexOf("factor") + 6);
    """)
    page._do("Input.insertText", text="speed")
    page.press("Compare")
    page.wait_for(shows(".source .is-new:not(.line-number)", "speed"))
    page.press("Take over")
    page.wait_for(shows(".code", "speed = rt.Parameter"))
    page.key("z", is_control=True)


def pages_have_no_barrier(page: browser.Browser) -> None:
    axe = AXE.read_text(encoding="utf-8")
    page.press("Open …")
    page.wait_for(is_there(".builder-start .links button"))
    found = page.violations(axe)
    page.press("Back to the draft")
    page.wait_for(is_there(".code .line"))
    for is_dark, numbers in ((False, range(9)), (True, (2, 4))):
        page.look(is_dark=is_dark)
        for number in numbers:
            page.evaluate(f"document.querySelectorAll('.builder-pages button')[{number}].click()")
            found += page.violations(axe)
    assert found == []
