"""The room of state machines: real machines are drawn, created, run and edited while they run."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import browser
import pytest
from shells import Shell
from webkit import WebClient, served

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
MARKUP = "<img src=x onerror=alert()>"
HEAD = """@prefix sm: <urn:rtkit:statemachine#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix : <#> .
"""
OVEN = f"""{HEAD}
:oven a sm:Machine ; sm:initial :idle ; sm:variable [ sm:name "minutes" ; sm:value 0 ] .
:idle a sm:State ; rdfs:comment "{MARKUP}" ; sm:transition ( [ sm:on "start" ; sm:to :cooking ]
    [ sm:on "minute" ;
      sm:action [ sm:set "variables.minutes" ; sm:expression "variables.minutes + 1" ] ] ) .
:cooking a sm:State ; sm:initial :heat ; sm:substate :heat, :rest ;
    sm:transition ( [ sm:on "stop" ; sm:to :idle ] [ sm:after 6000 ; sm:to :end ] ) .
:heat a sm:State ; sm:transition [ sm:on "tick" ; sm:to :rest ] .
:rest a sm:State ; sm:transition [ sm:on "tick" ; sm:to :heat ] .
:end a sm:Final .
"""
LOAD = """
import re, sys, threading
import rtkit
sent, halves, is_over = 0, [], threading.Event()
def look():
    with rtkit.Client(timeout_s=20) as client:
        while not is_over.wait(0.01):
            text = client.get_bytes("busy.machine").decode()
            numbers = re.findall(r"edit (\\d+)", text)
            if len(numbers) != 2 or numbers[0] != numbers[1]:
                halves.append(text)
looking = threading.Thread(target=look)
threading.Thread(target=lambda: (sys.stdin.read(), is_over.set()), daemon=True).start()
with rtkit.Client(timeout_s=20) as client:
    print("begun", flush=True)
    looking.start()
    while not is_over.wait(0.001):
        client.set("busy.event", "tick")
        sent += 1
    looking.join()
    print(sent, client.get("busy.variables.n"), len(halves), flush=True)
"""


def busy(number: int) -> str:
    """Return a machine that counts events in whatever state it is, with its number twice."""
    return f"""{HEAD}
:busy a sm:Machine ; rdfs:comment "edit {number}" ; sm:initial :on ;
    sm:variable [ sm:name "n" ; sm:value 0 ] .
:on a sm:State ; sm:initial :even ; sm:substate :even, :odd ; sm:transition [ sm:on "never" ;
    sm:action [ sm:set "variables.n" ; sm:value 0 ] ] .
:even a sm:State ; sm:transition [ sm:on "tick" ; sm:to :odd ;
    sm:action [ sm:set "variables.n" ; sm:expression "variables.n + 1" ] ] .
:odd a sm:State ; sm:transition [ sm:on "tick" ; sm:to :even ;
    sm:action [ sm:set "variables.n" ; sm:expression "variables.n + 1" ] ] .
:last a sm:State ; rdfs:comment "edit {number}" .
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("granted").resolve()


@pytest.fixture(scope="module")
def machines(shared_shell: Shell, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shell]:
    """Two machines and a storage."""
    kept = tmp_path_factory.mktemp("kept")
    shared_shell.ok("rtmgr start")
    for name in ("oven", "busy"):
        shared_shell.ok(
            f"rtmgr -c 'StateMachine?instance_name={name}&conf.default.service={name}'"
            " /localhost/manager.mgr"
        )
    shared_shell.ok(
        "rtmgr -c 'Storage?instance_name=files&conf.default.service=files"
        f"&conf.default.root={kept}' /localhost/manager.mgr"
    )
    for name in ("oven", "busy", "files"):
        shared_shell.ok(f"rtact /localhost/{name}.rtc")
    yield shared_shell
    shared_shell.ok("rtmgr stop")


@pytest.fixture(scope="module")
def client(machines: Shell, folder: Path) -> Iterator[WebClient]:
    with served(machines, f"--root {folder}") as client:
        yield client


@pytest.fixture
def oven(machines: Shell) -> Shell:
    """The shell, after the machine was put into its first state."""
    put(machines, "oven", OVEN)
    if machines.ok("rtget oven.run").strip('"\n') != "stopped":
        machines.ok("rtset oven.run stop")
    machines.ok("rtset oven.run start")
    return machines


def put(shell: Shell, machine: str, text: str) -> None:
    done = shell.run(f"rtset -p goto={first_of(text)} {machine}.machine -", text)
    assert (done.status, done.err) == (0, "")


def first_of(text: str) -> str:
    return text.partition("sm:initial :")[2].partition(" ")[0]


def edits(shell: Shell, machine: str) -> int:
    return int(shell.ok(f"rtget {machine}.edits"))


# Without a browser


def test_machines_are_listed_and_kept_in_storages_and_folders(
    client: WebClient, oven: Shell, folder: Path
) -> None:
    rows = client.ask("GET", "/api/machines").body["machines"]
    (row,) = (each for each in rows if each["id"] == "oven")
    assert (row["state"], row["run"], row["status"]) == ("idle", "running", "running")
    client.do({"do": "keep_machine", "machine": "oven", "target": "files.oven.ttl"})
    file = f"{folder}/oven.scxml"
    client.do({"do": "save_machine", "machine": "oven", "file": file})
    again = {"do": "save_machine", "machine": "oven", "file": file}
    answer = client.ask("POST", "/api/do", {"actions": [again]})
    assert answer.body["error"]["text"] == f"{file} is there already"
    places = client.ask("GET", "/api/machine/places").body
    assert places == {"stored": ["files.oven.ttl"], "folders": [str(folder)], "files": [file]}
    for each in ("target=files.oven.ttl", f"file={file}"):
        text = client.ask("GET", f"/api/machine/stored?{each}").body["text"]
        record = client.post("/api/machine/read", {"text": text})["machine"]
        assert {each["path"] for each in record["states"]} == {
            "idle", "cooking", "cooking.heat", "cooking.rest", "end"
        }  # fmt: skip
    for path in ("/etc/passwd", f"{folder}/../x.ttl", f"{folder}/x.py"):
        outside = {"do": "save_machine", "machine": "oven", "file": path}
        assert client.ask("POST", "/api/do", {"actions": [outside]}).status == 409
        assert client.ask("GET", f"/api/machine/stored?file={path}").status == 409
    (folder / "link.ttl").symlink_to("/etc/passwd")
    assert client.ask("GET", f"/api/machine/stored?file={folder}/link.ttl").status == 409


@pytest.mark.parametrize("form", ["turtle", "xml", "scxml"])
def test_a_machine_is_the_same_after_it_was_written_and_read(
    client: WebClient, oven: Shell, form: str
) -> None:
    text = oven.ok("rtget --raw oven.machine")
    record = client.post("/api/machine/read", {"text": text})["machine"]
    written = client.post("/api/machine/write", {"machine": record, "form": form})["text"]
    again = client.post("/api/machine/read", {"text": written})["machine"]
    if form == "scxml":  # it has no place for what is said of a state
        record["states"][0]["doc"] = ""
    for each in (again, record):
        each["states"].sort(key=lambda state: str(state["path"]))
    assert again == record


def test_a_state_is_stored_and_put_into_another_machine(
    client: WebClient, oven: Shell, folder: Path
) -> None:
    text = oven.ok("rtget --raw oven.machine")
    record = client.post("/api/machine/read", {"text": text})["machine"]
    given = {"machine": record, "form": "turtle", "at": "cooking"}
    part = client.post("/api/machine/write", given)["text"]
    client.do({"do": "store_state", "target": "files.cooking.ttl", "text": part})
    file = f"{folder}/cooking.ttl"
    client.do({"do": "save_machine", "machine": "oven", "file": file, "at": "cooking"})
    for each in ("target=files.cooking.ttl", f"file={file}"):
        text = client.ask("GET", f"/api/machine/stored?{each}").body["text"]
        # It leads to states that are there where it is put.
        states = [{"path": "idle"}, {"path": "end"}, {"path": "on"}, {"path": "on.a"}]
        states[2]["initial"] = "on.a"
        other = {"name": "other", "initial": "idle", "states": states}
        given = {"text": text, "machine": other, "at": "on.part1"}
        found = client.post("/api/machine/read", given)["machine"]
        paths = {each["path"] for each in found["states"]}
        assert paths >= {"on.part1", "on.part1.heat", "on.part1.rest"}
    given = {"machine": record, "form": "scxml", "at": "cooking"}
    assert client.ask("POST", "/api/machine/write", given).status == 400


def test_rubbish_is_refused_with_its_line(client: WebClient) -> None:
    for text, why in (
        ("rubbish", "line 1"),
        ('<?xml version="1.0"?>\n<!DOCTYPE scxml [<!ENTITY x "y">]><scxml/>', "DOCTYPE"),
    ):
        answer = client.ask("POST", "/api/machine/read", {"text": text})
        assert (answer.status, why in answer.body["error"]["text"]) == (400, True), answer
    wrong = {"name": "m", "initial": "b", "states": [{"path": "a"}]}
    answer = client.ask("POST", "/api/machine/write", {"machine": wrong, "form": "scxml"})
    assert answer.status == 409
    problems = client.post("/api/machine/draft", {"machine": wrong})
    assert [(each["part"], problems["text"]) for each in problems["problems"]] == [("initial", "")]


def test_an_edit_is_one_command_and_is_taken_back(client: WebClient, oven: Shell) -> None:
    before, count = oven.ok("rtget --raw oven.machine"), edits(oven, "oven")
    text = before.replace('"stop"', '"halt"')
    edit = {"do": "edit_machine", "machine": "oven", "text": text, "edits": count}
    outcome = client.do({**edit, "before": before})
    assert outcome["steps"][0]["command"] == f"rtset -p edits={count} -- oven.machine -"
    assert oven.ok("rtget --raw oven.machine") == text
    refused = client.post("/api/do", {"actions": [edit]})["steps"][0]
    assert (refused["ok"], "it has been edited since" in refused["error"]) == (False, True)
    client.do(*outcome["undo"])
    assert oven.ok("rtget --raw oven.machine") == before


def test_nothing_is_changed_from_a_page_that_only_reads(oven: Shell) -> None:
    with served(oven, "--read-only") as client:
        for action in (
            {"do": "send_event", "machine": "oven", "name": "start"},
            {"do": "run_machine", "machine": "oven", "word": "stop"},
            {"do": "edit_machine", "machine": "oven", "text": OVEN, "edits": 0},
        ):
            assert client.ask("POST", "/api/do", {"actions": [action]}).status == 403
        assert len(client.ask("GET", "/api/machines").body["machines"]) >= 2
    assert oven.ok("rtget oven.state") == '"idle"\n'


@pytest.mark.timeout(240)
def test_100_edits_under_load_lose_no_event_and_none_is_half_done(
    client: WebClient, machines: Shell, request: pytest.FixtureRequest
) -> None:
    put(machines, "busy", busy(0))
    machines.ok("rtset busy.run start")
    count = edits(machines, "busy")
    with subprocess.Popen(
        [sys.executable, "-c", LOAD], env=machines.environment, text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as load:  # fmt: skip
        assert load.stdout is not None
        assert load.stdout.readline() == "begun\n"
        for number in range(1, 101):
            edit = {"do": "edit_machine", "machine": "busy", "text": busy(number)}
            client.do({**edit, "edits": count + number - 1})
            if number == 50 and browser.NAME is not None:
                edit_by_page(request.getfixturevalue("window"))
                count += 1
        out, _ = load.communicate()
    sent, counted, halves = map(int, out.split())
    assert (counted, halves) == (sent, 0)
    assert sent > 100
    assert edits(machines, "busy") == count + 100
    assert 'lost"' not in machines.ok("rtget busy.log?n=1000")
    machines.ok("rtset busy.run stop")


# With a browser

needs_browser = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")


@pytest.fixture(scope="module")
def window(
    client: WebClient, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[browser.Browser]:
    with browser.opened(str(tmp_path_factory.mktemp("browser")), "", "") as page:
        page.picture("/dev/null", 1280, 900)  # sets the size of the window
        page.go(f"http://127.0.0.1:{client.port}/#token={client.token}")
        page.wait_for(is_there(".bar"))
        yield page
        assert [each for each in page.troubles() if "ResizeObserver loop" not in each] == []


def is_there(selector: str) -> str:
    return f"document.querySelector({json.dumps(selector)}) !== null"


def has_text(selector: str, text: str) -> str:
    found = f"document.querySelector({json.dumps(selector)})?.textContent"
    return f"({found} ?? '').includes({json.dumps(text)})"


def node(path: str) -> str:
    return f'.react-flow__node[data-id="{path}"]'


def enter(page: browser.Browser, label: str, text: str) -> None:
    """Put a text into the field with this label."""
    page.evaluate("document.querySelector('#wanted')?.removeAttribute('id')")
    found = "[...document.querySelectorAll('dialog[open] .field, .machine-inspector .field')]"
    wanted = f"{found}.find((each) => each.textContent.startsWith({label!r}))"
    page.wait_for(f"{wanted} !== undefined")
    page.evaluate(f"{wanted}.querySelector('input').id = 'wanted'")
    page.type("#wanted", text)


def show(page: browser.Browser, machine: str, condition: str) -> None:
    page.evaluate("location.hash = '#view=machine'")
    page.wait_for(is_there(".machines"))
    page.evaluate(f"location.hash = '#view=machine&of={machine}'")
    page.wait_for(condition)


def key(page: browser.Browser, name: str, **given: Any) -> None:
    """Press a key that belongs to the room, not to a field."""
    page.evaluate("document.activeElement.blur()")
    page.key(name, **given)


def edit_by_page(page: browser.Browser) -> None:
    show(page, "busy", is_there(f"{node('on')} .is-active"))
    key(page, "n")
    page.wait_for(is_there(node("state1")))
    page.press("Apply …")
    page.press("Apply")
    page.wait_for(f"!({is_there('dialog[open]')})")


@needs_browser
def test_a_machine_is_drawn_created_and_run(window: browser.Browser, machines: Shell) -> None:
    page = window
    show(page, "%2B", is_there(".machine-tools"))
    key(page, "n")
    page.wait_for(is_there(node("state1")))
    enter(page, "Name", "off")
    page.key("Enter")
    page.wait_for(is_there(node("off")))
    key(page, "n")
    page.wait_for(is_there(node("state1")))
    enter(page, "Name", "1st")
    page.wait_for(has_text(".machine-inspector", "begins with a letter"))
    enter(page, "Name", "lit")
    page.key("Enter")
    page.wait_for(has_text(".machine-notes", "lit: Nothing leads to this state."))
    page.click(f"{node('off')} header")
    start, end = page.middle(f"{node('off')} .more"), page.middle(f"{node('lit')} header")
    page.mouse("mouseMoved", *start)
    page.mouse("mousePressed", *start)
    for part in (0.3, 0.6, 1.0):
        page.mouse("mouseMoved", *(a + part * (b - a) for a, b in zip(start, end, strict=True)))
    page.mouse("mouseReleased", *end)
    page.wait_for(is_there(".react-flow__edge"))
    enter(page, "On the event", "press")
    page.wait_for(has_text(f"{node('off')} .row", "press"))
    key(page, "z", is_control=True)
    page.wait_for(has_text(f"{node('off')} .row", "at once"))
    key(page, "y", is_control=True)
    page.wait_for(has_text(f"{node('off')} .row", "press"))
    page.press("Create …")
    enter(page, "Name of the service", "lamp")
    enter(page, "Name of the component", "lamp")
    page.press("Create")
    page.wait_for(has_text("dialog.plan", "rtact -- /localhost/manager.mgr/lamp.rtc"))
    page.press("Do it")
    page.wait_for("location.hash === '#view=machine&of=lamp'")
    page.press("Start")
    page.wait_for(is_there(f"{node('off')} .is-active"))
    assert machines.ok("rtget lamp.state") == '"off"\n'
    page.press("press")
    page.wait_for(is_there(f"{node('lit')} .is-active"))
    page.wait_for(has_text(".history .last", "off → lit on press"))
    page.wait_for(is_there(".way.is-last"))
    page.press("Pause")
    page.wait_for(has_text(".run-bar", "paused"))
    machines.ok("rtset lamp.run stop")
    page.wait_for(has_text(".run-bar", "stopped") + f" && !({is_there('.state.is-active')})")


@needs_browser
def test_what_a_shell_does_is_lit_and_text_stays_text(window: browser.Browser, oven: Shell) -> None:
    page = window
    show(page, "oven", is_there(f"{node('idle')} .is-active"))
    oven.ok("rtset oven.event minute")
    oven.ok("rtset oven.event start")
    page.wait_for(is_there(f"{node('cooking.heat')} .is-active"))
    assert page.evaluate(is_there(f"{node('cooking')} .is-active")) is True
    oven.ok("rtset oven.event tick")
    page.wait_for(is_there(f"{node('cooking.rest')} .is-active"))
    page.wait_for(has_text(".history .last", "cooking.heat → cooking.rest on tick"))
    page.wait_for("[...document.querySelectorAll('.present input')].some((e) => e.value === '1')")
    page.click(f"{node('idle')} header")
    page.wait_for(f"[...document.querySelectorAll('input')].some((e) => e.value === {MARKUP!r})")
    assert page.evaluate("document.querySelector('img[src=x]')") is None


@needs_browser
def test_who_deletes_the_active_state_is_asked_where_to_go(
    window: browser.Browser, oven: Shell
) -> None:
    page = window
    oven.ok("rtset oven.event start")
    show(page, "oven", is_there(f"{node('cooking.heat')} .is-active"))
    page.click(f"{node('cooking')} header")
    key(page, "Delete")
    page.wait_for(f"!({is_there(node('cooking'))})")
    page.press("Apply …")
    page.wait_for(has_text("dialog .goto", "The active state cooking.heat would be gone."))
    page.wait_for(has_text("dialog .diff", "cooking.rest removed"))
    assert page.evaluate("document.querySelector('dialog button.primary').disabled") is True
    page.evaluate(
        "{const select = document.querySelector('dialog select'); select.value = 'end';"
        " select.dispatchEvent(new Event('change', {bubbles: true}))}"
    )
    page.press("Apply")
    page.wait_for(has_text(".run-bar", "done"))
    assert oven.ok("rtget oven.state") == '"end"\n'
    page.wait_for(has_text(".toasts", "-p goto=end"))
    page.wait_for(f"!({has_text('.machine-notes', 'not applied')})")


@needs_browser
def test_what_others_edit_meanwhile_is_not_overwritten(
    window: browser.Browser, oven: Shell
) -> None:
    page = window
    show(page, "oven", is_there(f"{node('idle')} .is-active"))
    key(page, "n")
    page.wait_for(is_there(node("state1")))
    put(oven, "oven", OVEN.replace('"stop"', '"halt"'))
    page.wait_for(has_text(".machine-notes", "edited meanwhile"))
    apply = "[...document.querySelectorAll('button')].find((e) => e.textContent === 'Apply …')"
    assert page.evaluate(f"{apply}.disabled") is True
    page.press("Take theirs")
    page.wait_for(f"!({is_there(node('state1'))})")
    page.wait_for(has_text(f"{node('cooking')} .row", "halt"))
    key(page, "n")
    page.wait_for(is_there(node("state1")))
    put(oven, "oven", OVEN)
    page.wait_for(has_text(".machine-notes", "edited meanwhile"))
    page.press("Keep mine, over theirs")
    page.press("Apply …")
    page.wait_for(has_text("dialog .diff", "halt"))
    page.press("Apply")
    page.wait_for(f"!({is_there('dialog[open]')})")
    text = oven.ok("rtget --raw oven.machine")
    assert '"halt"' in text
    assert "state1" in text


@needs_browser
def test_all_is_done_by_keys_in_the_outline_and_axe_finds_no_barrier(
    window: browser.Browser, oven: Shell, tmp_path: Path
) -> None:
    page = window
    show(page, "oven", is_there(f"{node('idle')} .is-active"))
    page.evaluate(f"document.querySelector({json.dumps(node('idle'))}).focus()")
    page.key("ArrowRight")
    page.wait_for(has_text(".machine-inspector h2", "cooking.heat"))
    key(page, "c")
    page.wait_for(is_there("dialog[open] select"))
    enter(page, "On the event", "loop")
    page.key("Enter")
    page.wait_for(has_text(node("cooking.heat"), "loop ↺"))
    page.press("Outline")
    page.wait_for(has_text(".outline", "heat"))
    page.wait_for(has_text(".outline", "loop → ↺"))
    found = []
    axe = AXE.read_text(encoding="utf-8") if AXE.exists() else ""
    for is_dark in (False, True):
        page.look(is_dark=is_dark)
        for view in ("Outline", "Chart"):
            page.press(view)
            found += page.violations(axe) if axe else []
        for button in ("Apply …", "Open, save …"):
            page.press(button)
            page.wait_for(is_there("dialog[open]"))
            found += page.violations(axe) if axe else []
            page.key("Escape")
            page.wait_for(f"!({is_there('dialog[open]')})")
    page.save_to(str(tmp_path))
    page.press("Open, save …")
    page.press("SCXML")
    page.saved()
    (saved,) = tmp_path.glob("*.scxml")
    assert 'event="loop"' in saved.read_text(encoding="utf-8")
    page.key("Escape")
    page.press("Discard")
    page.evaluate("location.hash = '#view=machine'")
    page.wait_for(has_text(".machines", "oven"))
    found += page.violations(axe) if axe else []
    page.look(is_dark=False)
    assert found == []
