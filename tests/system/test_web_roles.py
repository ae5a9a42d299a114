"""The page over a manager that lets users in by their certificates: each role sees and may its own.

The page itself is served by TLS, as somebody on another host gets it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import browser
import pytest
from forked import Commands
from robotkit import AT, Robot, opened_robot
from webkit import WebClient, certified, served

AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"
needs_browser = pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
Served = Callable[..., Any]


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    with opened_robot(commands) as robot:
        kinds = "-c SeqOut -c 'SeqIn?manager_name=s'"
        assert robot.there(f"rtmgr {kinds} /localhost/manager.mgr").err == ""
        out, into = ("/localhost/SeqOut0.rtc", "/localhost/SeqIn0.rtc")
        assert robot.there(f"rtcon -i one {out}:Long {into}:Long").err == ""
        assert robot.there(f"rtact {out} {into}").err == ""
        yield robot


@pytest.fixture
def page_of(robot: Robot, tmp_path: Path) -> Served:
    """What serves the page with the keys of somebody, and yields a client of it."""

    @contextmanager
    def serving(who: str, options: str = "") -> Iterator[WebClient]:
        with robot.usual(), robot.keys_of(who):
            started = served(robot.shell, options, certified(tmp_path))
            with started as client:
                yield client

    return serving


def refusal(client: WebClient, **action: object) -> str:
    """Return why an action was not done, which fails."""
    (step,) = client.post("/api/do", {"actions": [action]})["steps"]
    assert step["ok"] is False
    return str(step["error"])


def test_a_viewer_sees_everything_and_values_flow(
    robot: Robot, page_of: Served, tmp_path: Path
) -> None:
    port = f"{robot.path}/SeqOut0.rtc:Long"
    with page_of("anna", f"--root {tmp_path}") as client, client.stream("one") as stream:
        stream.until(lambda seen: seen.components)
        (manager,) = stream.managers.values()
        assert manager["rights"] == {"name": "anna", "role": "viewer"}
        assert (manager["host"], manager["state"]) == ("robot1", "up")
        assert stream.components[f"{robot.path}/SeqOut0.rtc"]["word"] == "Active"
        client.post("/api/watch", {"page": "one", "ports": [port]})
        first = stream.next("values")["values"][port]
        while (later := stream.next("values")["values"].get(port, first)) == first:
            pass
        assert later["count"] > first["count"]
        file = tmp_path / "seen.mcap"
        job = client.post("/api/record", {"ports": [port], "file": str(file)})
        while not file.exists() or file.stat().st_size < 500:  # it has a beginning first
            stream.next("rates")
        client.post(f"/api/jobs/{job['id']}/stop", {})
        while stream.next("job")["status"] is None:
            pass
    assert "SeqOut0_Long" in robot.shell.ok(f"rtlog -d -f {file}")


def test_each_role_is_refused_what_it_lacks_in_the_words_of_the_page(
    robot: Robot, page_of: Served
) -> None:
    at = robot.path
    given, taken = f"{at}/ConsoleIn0.rtc", f"{at}/ConsoleOut0.rtc"
    changes: list[tuple[dict[str, Any], str]] = [
        ({"do": "activate", "component": given}, "activate ConsoleIn0"),
        ({"do": "connect", "source": f"{given}:out", "target": f"{taken}:in"},
         "connect ConsoleIn0.out and ConsoleOut0.in"),
        ({"do": "configure", "component": given, "set": "default", "values": {"values": "3"}},
         "set parameters ConsoleIn0"),
        ({"do": "inject", "port": f"{taken}:in", "value": "3"}, "write values to ConsoleOut0.in"),
    ]  # fmt: skip
    makes: list[tuple[dict[str, Any], str]] = [
        ({"do": "create", "manager": f"{at}/manager.mgr", "create": "ConsoleIn"}, "create"),
        ({"do": "delete", "component": given}, "delete ConsoleIn0"),
        ({"do": "stop_manager", "manager": f"{at}/manager.mgr", "keep": True}, "set stop"),
        ({"do": "restart_manager", "manager": f"{at}/manager.mgr"}, "set restart"),
    ]
    before = robot.there("rtls -lR /localhost").out
    with page_of("anna") as client, client.stream() as stream:
        stream.until(lambda seen: seen.components)
        for action, what in changes:
            assert f"anna (viewer) may not {what}" in refusal(client, **action)
        for action, what in makes:
            error = refusal(client, **action)
            assert f"anna (viewer) may not {what}" in error
            assert "it takes administrator" in error
        target = f"{given}.configuration.default.values"
        answer = client.ask("POST", "/api/properties/set", {"target": target, "value": "7"})
        assert (answer.status, answer.body["error"]["kind"]) == (403, "denied")
        why = f"{target}: denied: anna (viewer) may not set parameters ConsoleIn0"
        assert answer.body["error"]["text"].startswith(why)
        assert client.ask("GET", f"/api/properties/value?target={target}").body == "0"
    assert robot.there("rtls -lR /localhost").out == before
    with page_of("bert") as client, client.stream() as stream:
        stream.until(lambda seen: seen.components)
        for action, what in makes:
            assert f"bert (operator) may not {what}" in refusal(client, **action)
        done = client.do(changes[0][0], changes[1][0])
        client.do(*done["undo"])
    assert robot.there("rtls -lR /localhost").out == before


def test_an_administrator_restarts_and_stops_a_manager_by_its_address(
    robot: Robot, page_of: Served
) -> None:
    assert robot.there(f"rtmgr start second -a --tls {AT}:0") == (0, "", "")
    usual, robot.port = robot.port, robot.port_of("second")
    try:
        manager = f"{robot.path}/second.mgr"
        with page_of("owner1") as client, client.stream() as stream:
            stream.until(lambda seen: manager in seen.managers)
            assert stream.managers[manager]["rights"]["role"] == "administrator"
            done = client.do({"do": "restart_manager", "manager": manager})
            assert done["steps"][0]["command"] == f"rtmgr restart -- {robot.path[1:]}"
            stream.until(lambda seen: manager not in seen.managers)
            stream.until(lambda seen: manager in seen.managers)
            stopped = client.do({"do": "stop_manager", "manager": manager, "keep": False})
            assert stopped["steps"][0]["command"] == f"rtmgr stop -- {robot.path[1:]}"
            stream.until(lambda seen: manager not in seen.managers)
        assert robot.there("rtmgr status second").status == 1
    finally:
        robot.port = usual


@contextmanager
def looking(client: WebClient, folder: Path) -> Iterator[browser.Browser]:
    with browser.opened(str(folder), "", "") as page:
        page.trust_all()
        page.picture("/dev/null", 1440, 900)  # sets the size of the window
        page.go(f"{client.site}#token={client.token}")
        yield page


HANDLES = ".react-flow__node-component .react-flow__handle"
BUTTONS = "[...document.querySelectorAll('.inspector button')]"


def is_disabled(text: str) -> str:
    return f"{BUTTONS}.find((each) => each.textContent.trim().startsWith({text!r}))?.disabled"


def select(page: browser.Browser, id: str) -> None:
    row = f"document.querySelector('[role=treeitem][title={json.dumps(id)}]')"
    page.wait_for(f"{row} !== null")
    page.evaluate(f"{row}.click()")
    page.wait_for(f"location.hash.includes('select=') && {BUTTONS}.length > 0")


@needs_browser
def test_controls_of_what_a_viewer_may_not_do_are_disabled_with_the_reason(
    robot: Robot, page_of: Served, tmp_path: Path
) -> None:
    with page_of("anna") as client, looking(client, tmp_path) as page:
        select(page, f"{robot.path}/ConsoleIn0.rtc")
        for text in ("Activate", "End", "Make a composite", "Connect"):
            page.wait_for(f"{is_disabled(text)} === true")
        note = page.evaluate("document.querySelector('.inspector .rights').textContent")
        assert note.startswith("anna is viewer at robot1 and may only look.")
        assert "operator" in note
        badge = "document.querySelector('.bar .badge')?.textContent"
        page.wait_for(f"{badge} === 'viewer at robot1'")
        # A component cannot be ended by a key, nor is that offered by the palette.
        page.key("Delete")
        page.key("k", is_control=True)
        page.wait_for("document.querySelector('dialog[open] input') !== null")
        page.type("dialog[open] input", "activate")
        offered = "[...document.querySelectorAll('dialog[open] [role=option]')]"
        page.wait_for(f"{offered}.every((each) => !each.textContent.startsWith('Activate'))")
        page.key("Escape")
        page.wait_for("document.querySelector('dialog[open]') === null")
        handles = f"[...document.querySelectorAll({HANDLES!r})]"
        page.wait_for(f"{handles}.length && {handles}.every((e) => !e.matches('.connectable'))")
        select(page, f"{robot.path}/manager.mgr")
        for text in ("Create", "Load", "Stop"):
            page.wait_for(f"{is_disabled(text)} === true")
        if AXE.exists():
            assert page.violations(AXE.read_text(encoding="utf-8")) == []
        assert page.troubles() == []
        assert "ConsoleIn0" in robot.there("rtls /localhost").out


NOTE = "document.querySelector('.room .rights')?.textContent"


@needs_browser
def test_rooms_disable_what_a_viewer_may_not_do_with_the_reason(
    robot: Robot, page_of: Served, tmp_path: Path
) -> None:
    given = f"{robot.path}/ConsoleIn0.rtc.configuration.default"
    with page_of("anna") as client, looking(client, tmp_path) as page:
        page.wait_for("document.querySelector('[role=treeitem]') !== null")
        page.evaluate(f"location.hash = '#view=properties&of={given}'")
        page.wait_for("document.querySelector('.widgets [data-name]') !== null")
        page.wait_for(f"{NOTE}?.startsWith('anna is viewer at robot1')")
        fields = "[...document.querySelectorAll('.widgets :is(input, select, button, textarea)')]"
        is_fixed = f"{fields}.length && {fields}.every((each) => each.disabled || each.readOnly)"
        page.wait_for(is_fixed)
        page.evaluate("location.hash = '#view=plan'")
        page.wait_for("document.querySelector('.plans-form [type=submit]') !== null")
        page.evaluate("document.querySelector('.plans-form [type=submit]').click()")
        start = "document.querySelector('.plans-main section > button')"
        page.wait_for(f"{start}?.disabled === true")
        page.wait_for(f"{NOTE}?.startsWith('anna is viewer at robot1')")
        page.evaluate(f"location.hash = '#view=machine&of={robot.path}/butler'")
        page.wait_for(f"{NOTE}?.startsWith('anna is viewer at robot1')")
        assert page.troubles() == []
    with page_of("bert") as client, looking(client, tmp_path) as page:
        page.wait_for("document.querySelector('[role=treeitem]') !== null")
        page.evaluate(f"location.hash = '#view=properties&of={given}'")
        page.wait_for(f"{fields}.length && !({is_fixed})")
        assert page.evaluate(NOTE) is None
        page.evaluate("location.hash = '#view=plan'")
        page.wait_for("document.querySelector('.plans-form [type=submit]') !== null")
        page.evaluate("document.querySelector('.plans-form [type=submit]').click()")
        page.wait_for(f"{start}?.disabled === false")


@needs_browser
def test_an_operator_may_change_what_is_there_and_make_nothing(
    robot: Robot, page_of: Served, tmp_path: Path
) -> None:
    with page_of("bert") as client, looking(client, tmp_path) as page:
        select(page, f"{robot.path}/ConsoleIn0.rtc")
        page.wait_for(f"{is_disabled('Activate')} === false")
        page.wait_for(f"{is_disabled('End')} === true")
        note = page.evaluate("document.querySelector('.inspector .rights').textContent")
        assert "bert is operator at robot1 and may change what is there." in note
        page.press("Activate")
        page.wait_for(f"{is_disabled('Deactivate')} === false")
        page.press("Deactivate")
        page.wait_for(f"{is_disabled('Activate')} === false")
