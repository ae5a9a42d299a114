"""Plans of the page, by real managers: what is shown is what commands plan, and then do."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import browser
import pytest
from shells import Shell, opened_shell
from webkit import Stream, WebClient, served

MOODY = '''
"""A component that is not activated while a file is there, or for as long as it is."""

import os
import time

from rtkit.component import Component


class Moody(Component):
    def on_activated(self, context):
        folder = os.environ["RTKIT_STATE_DIR"]
        if os.path.exists(folder + "/bad"):
            raise RuntimeError("in a bad mood")
        while os.path.exists(folder + "/slow"):
            time.sleep(0.01)


def MoodyInit(manager):
    manager.register_factory(Moody)
'''
AXE = Path(__file__).parents[2] / "web/node_modules/axe-core/axe.min.js"


@pytest.fixture(scope="module")
def profile() -> bytes:
    """The profile of a system that a manager of its own has had."""
    with opened_shell() as shell:
        (shell.modules / "Moody.py").write_text(MOODY)
        shell.ok("rtmgr start")
        shell.ok(
            "rtmgr -c Sensor -c 'Controller?manager_name=brain' -c Moody /localhost/manager.mgr"
        )
        shell.ok("rtcon /localhost/Sensor0.rtc:distance /localhost/Controller0.rtc:distance")
        shell.ok("rtconf /localhost/Controller0.rtc set gain 2.5")
        return shell.ok("rtcryo --all --yaml").encode()


@pytest.fixture
def robot(manager: Shell, tmp_path: Path, profile: bytes) -> tuple[Shell, str]:
    """A shell, and the file of a system that does not live now."""
    (manager.modules / "Moody.py").write_text(MOODY)
    file = tmp_path.resolve() / "robot.yaml"
    file.write_bytes(profile)
    return manager, str(file)


def state_file(shell: Shell, name: str) -> Path:
    return Path(shell.environment["RTKIT_STATE_DIR"]) / name


def started(client: WebClient, **request: Any) -> str:
    id: str = client.post("/api/plans/start", request)["id"]
    return id


def ended(stream: Stream, id: str) -> Any:
    """Return the news that a job has ended."""
    job = stream.next("job")
    while job["id"] != id or job["status"] is None:
        job = stream.next("job")
    return job


def told(client: WebClient, id: str, state: str) -> list[str]:
    """Return the texts of the steps that came to a state."""
    rows = client.ask("GET", f"/api/jobs/{id}").body["rows"]
    return [row["text"] for row in rows if row.get("state") == state]


def snapshot(shell: Shell) -> str:
    """Return what lives, without times and the ids that each run makes."""
    return re.sub(r"\d{4}-\d\d-\d\dT[0-9:.Z+-]+", "", shell.ok("rtcryo --all -x"))


def test_a_restore_is_that_of_rtresurrect(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    with served(shell, f"--root {Path(file).parent}") as client, client.stream() as stream:
        plan = client.post("/api/plans/show", {"do": "restore", "file": file})
        parts = [*plan["checks"], *plan["steps"]]
        lines = [f"{s['text']}{' (Required)' if s['required'] else ''}" for s in parts]
        assert plan["cost"] == sum(each["cost"] for each in plan["steps"])
        assert lines == shell.ok(f"rtresurrect --dry-run {file}").splitlines()
        job = ended(stream, started(client, do="restore", file=file))
        assert (job["status"], job["error"]) == (0, "")
        assert "Restore robot.yaml" in job["text"]
        by_page = snapshot(shell)
        done = [text for text in told(client, job["id"], "done") if text.startswith("Create")]
        assert len(done) == 3
        taken = started(client, do="take_down", file=file, flags=["exit"])
        assert ended(stream, taken)["status"] == 0
    shell.ok(f"rtresurrect {file}")
    assert snapshot(shell) == by_page


def test_the_plan_is_that_of_rtplan_and_is_done_as_shown(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    with served(shell, f"--root {Path(file).parent}") as client, client.stream() as stream:
        plan = client.post("/api/plans/show", {"do": "apply", "file": file})
        known = json.loads(shell.ok(f"rtplan --json {file}"))
        assert {key: plan[key] for key in known if key != "schema"} == {
            key: value for key, value in known.items() if key != "schema"
        }
        shown = [step["text"] for step in plan["steps"]]
        shell.ok("rtmgr -c Sensor /localhost/manager.mgr")
        request = {"do": "apply", "file": file, "shown": shown}
        changed = client.ask("POST", "/api/plans/start", request)
        assert changed.status == 409
        assert "look again" in changed.body["error"]["text"]
        job = ended(stream, started(client, do="apply", file=file))
        assert job["status"] == 0
        assert job["command"] == f"rtapply -- {file}"
        first = client.ask("GET", f"/api/jobs/{job['id']}").body["rows"][0]
        assert first["request"] == {"do": "apply", "file": file}
        assert first["plan"]["steps"] != []
        same = client.ask("GET", f"/api/plans/compare?before={file}").body
        assert (same["same"], same["facts"]) == (True, [])


def test_what_fails_midway_is_told_and_goes_on_when_tried_again(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    state_file(shell, "bad").touch()
    with served(shell, f"--root {Path(file).parent}") as client, client.stream() as stream:
        request = {"do": "apply", "file": file}
        job = ended(stream, started(client, **request))
        assert job["status"] == 1
        assert "in a bad mood" in job["error"]
        assert "left; run it again to go on" in job["error"]
        assert any("create Moody0" in text for text in told(client, job["id"], "done"))
        (failed,) = told(client, job["id"], "failed")
        assert "activate Moody0" in failed
        state_file(shell, "bad").unlink()
        shell.run("rtreset /localhost/Moody0.rtc")
        again = ended(stream, started(client, **request))
        assert (again["status"], again["error"]) == (0, "")
        assert not any("create" in text for text in told(client, again["id"], "done"))
    assert shell.run(f"rtcheck {file}").status == 0


def test_an_apply_that_is_stopped_ends_as_by_ctrl_c(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    state_file(shell, "slow").touch()
    with served(shell, f"--root {Path(file).parent}") as client, client.stream() as stream:
        id = started(client, do="apply", file=file)
        while not any("Sensor0" in str(row) for row in stream.next("job").get("rows", ())[1:]):
            pass
        client.post(f"/api/jobs/{id}/stop", {})
        state_file(shell, "slow").unlink()
        job = ended(stream, id)
        assert job["status"] in (130, -2)
        assert "left; run it again to go on" in job["error"]
        assert ended(stream, started(client, do="apply", file=file))["status"] == 0


def test_everything_that_lives_is_stopped_started_and_ended(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    assert shell.run(f"rtapply {file}").status == 0
    with served(shell) as client, client.stream() as stream:
        plan = client.post("/api/plans/show", {"do": "stop"})
        assert plan["command"] == "rtcryo --all | rtstop"
        assert len(plan["steps"]) == 3
        job = ended(stream, started(client, do="stop"))
        assert (job["status"], job["command"]) == (0, "rtcryo --all | rtstop")
        assert shell.run(f"rtcheck -s inactive {file}").status == 0
        assert ended(stream, started(client, do="start"))["status"] == 0
        assert shell.run(f"rtcheck {file}").status == 0
        assert ended(stream, started(client, do="take_down", flags=["exit"]))["status"] == 0
        stream.until(lambda s: not s.components)


def test_a_read_only_page_shows_plans_and_does_none(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    with served(shell, f"--read-only --root {Path(file).parent}") as client:
        request = {"do": "apply", "file": file}
        assert client.post("/api/plans/show", request)["steps"]
        assert client.ask("POST", "/api/plans/start", request).status == 403
        order = {"do": "order", "file": file, "order": "activation", "steps": ["Sensor0"]}
        assert client.ask("POST", "/api/do", {"actions": [order]}).status == 403
        for bad, status in (
            ({"do": "apply", "file": "/etc/passwd"}, 409),
            ({"do": "explode"}, 400),
            ({"do": "start", "flags": ["exit"]}, 400),
        ):
            assert client.ask("POST", "/api/plans/show", bad).status == status


def test_a_restore_takes_some_parts_to_other_places(robot: tuple[Shell, str]) -> None:
    shell, file = robot
    with served(shell, f"--root {Path(file).parent}") as client, client.stream() as stream:
        profile = client.ask("GET", f"/api/plans/profile?file={file}").body
        (wire,) = profile["connectors"]
        assert wire["text"] == "Sensor0.distance → Controller0.distance"
        sets = {each["name"]: each["sets"] for each in profile["components"]}
        assert "default" in sets["Controller0"]
        place = "/localhost/manager.mgr/eye.mgr"
        request = {"do": "restore", "file": file, "place": {"Sensor0": place}}
        request["without"] = ["Moody0", wire["id"], "Controller0.*"]
        plan = client.post("/api/plans/show", request)
        assert ended(stream, started(client, **request))["status"] == 0
        assert not any("Moody" in each["text"] for each in plan["steps"])
        assert f"--place=Sensor0={place} --without=Moody0" in plan["command"]
        assert client.ask("POST", "/api/plans/show", {**request, "without": ["No0"]}).status == 409
        stream.until(lambda s: len(s.components) == 2)
        assert stream.connectors == {}
    assert sorted(shell.ok("rtls /localhost/manager.mgr").split()) == [
        "Controller0.rtc", "Sensor0.rtc", "brain.mgr/", "eye.mgr/",
    ]  # fmt: skip
    assert shell.ok("rtls /localhost/manager.mgr/eye.mgr").split() == ["Sensor0.rtc"]
    assert float(shell.ok("rtconf /localhost/Controller0.rtc get gain")) != 2.5


def test_files_are_compared_and_orders_are_written_and_taken_back(
    robot: tuple[Shell, str],
) -> None:
    shell, file = robot
    folder = Path(file).parent
    with served(shell, f"--root {folder}") as client:
        shell.ok(f"rtprofile order {file} activation Sensor0 Moody0:wait=20 -o {folder}/new.yaml")
        url = f"/api/plans/compare?before={file}&after={folder}/new.yaml"
        differs = client.ask("GET", url).body
        assert differs["same"] is False
        assert [(fact["mark"], fact["text"]) for fact in differs["facts"]] == [
            ("+", "order Activation")
        ]
        live = client.ask("GET", f"/api/plans/compare?before={file}").body
        marks = {box["id"]: box["mark"] for box in live["picture"]["boxes"]}
        assert marks == dict.fromkeys(("Sensor0", "Controller0", "Moody0"), "-")
        assert [wire["mark"] for wire in live["picture"]["wires"]] == ["-"]
        steps = ["Moody0", "Sensor0:after=Moody0,timeout=500"]
        done = client.do({"do": "order", "file": file, "order": "activation", "steps": steps})
        profile = client.ask("GET", f"/api/plans/profile?file={file}").body
        assert profile["orders"]["activation"] == steps
        assert {each["host"] for each in profile["components"]} == {"localhost"}
        client.do(*done["undo"])
        assert (
            client.ask("GET", f"/api/plans/profile?file={file}").body["orders"]["activation"] == []
        )


@pytest.mark.skipif(browser.NAME is None, reason="chromium is not installed")
def test_a_plan_is_shown_then_done_and_all_pages_see_it(
    robot: tuple[Shell, str], tmp_path: Path
) -> None:
    shell, file = robot
    state_file(shell, "bad").touch()
    with (
        served(shell, f"--root {Path(file).parent}") as client,
        browser.opened(str(tmp_path), "", "") as page,
    ):
        address = f"http://127.0.0.1:{client.port}/#token={client.token}&view=plan&of=do:{file}"
        page.picture("/dev/null", 1024, 768)
        page.go(address)
        page.wait_for("document.querySelector('.deeds') !== null")
        page.wait_for("document.querySelector('.hosts summary') !== null")
        page.click(".hosts summary")
        sensor = page.evaluate(
            "[...document.querySelectorAll('.hosts th input')].findIndex((each) =>"
            " each.closest('label').innerText.trim() === 'Sensor0') + 1"
        )
        page.click(f".hosts tbody tr:nth-of-type({sensor}) th input")
        field = "[aria-label='Goes to: Controller0']"
        page.type(field, "/localhost/manager.mgr/head.mgr")
        page.press("Show the plan")
        page.wait_for("document.querySelector('.command') !== null")
        command = page.evaluate("document.querySelector('.command code').innerText")
        assert "--place=Controller0=/localhost/manager.mgr/head.mgr --without=Sensor0" in command
        clean(page)
        page.click(f".hosts tbody tr:nth-of-type({sensor}) th input")
        page.evaluate(f"document.querySelector({json.dumps(field)}).select()")
        page.key("Backspace")
        page.press("Show the plan")
        page.wait_for("document.querySelectorAll('.steps .layer').length > 2")
        page.press("Apply now")
        page.wait_for("document.querySelector('.trouble') !== null")
        text = page.evaluate("document.querySelector('.trouble').innerText")
        assert "in a bad mood" in text
        assert "steps left" in text
        clean(page)
        state_file(shell, "bad").unlink()
        shell.run("rtreset /localhost/Moody0.rtc")
        page.press("Retry what failed")
        page.wait_for("document.querySelector('.plans-main .step-state.is-done') !== null")
        page.wait_for(
            "document.querySelector('.plans-main .step-state.is-done') !== null"
            " && document.querySelector('.trouble') === null"
        )
        shell.ok("rtconf /localhost/Controller0.rtc set gain 7")
        page.evaluate(f"location.hash = '#view=plan&of=compare:{file}'")
        page.wait_for("document.querySelector('.compared .box-changed') !== null")
        clean(page)
        page.evaluate(f"location.hash = '#view=plan&of=order:{file}'")
        page.wait_for("document.querySelector('.plans-main select') !== null")
        clean(page)
        assert page.troubles() == []


def clean(page: browser.Browser) -> None:
    """Let axe-core find nothing against the page, in light and dark."""
    for is_dark in (False, True) if AXE.exists() else ():
        page.look(is_dark=is_dark)
        page.rest()
        assert page.violations(AXE.read_text(encoding="utf-8")) == []
