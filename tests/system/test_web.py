"""The server of the page: what it shows of real managers, does, and refuses."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from shells import ROOT, Shell
from webkit import WebClient, served

IN, OUT = "/localhost/In0.rtc", "/localhost/Out0.rtc"


@pytest.fixture
def pair(manager: Shell) -> Shell:
    manager.ok(
        "rtmgr -c 'ConsoleIn?instance_name=In0' -c 'ConsoleOut?instance_name=Out0&manager_name=s1'"
        " -c 'ConfigSample?instance_name=C0' /localhost/manager.mgr"
    )
    return manager


@pytest.fixture(scope="module")
def served_alone(shared_shell: Shell) -> Iterator[WebClient]:
    """A server without a manager."""
    with served(shared_shell) as client:
        yield client


def test_what_a_shell_changes_is_in_the_stream(pair: Shell) -> None:
    with served(pair) as client, client.stream() as stream:
        stream.until(lambda s: IN in s.components)
        assert stream.components[IN]["word"] == "Inactive"
        pair.ok(f"rtcon -i one {IN}:out {OUT}:in")
        stream.until(lambda s: "one" in s.connectors)
        assert stream.connectors["one"]["target"] == {"component": OUT, "port": "in"}
        pair.ok(f"rtact {IN}")
        stream.until(lambda s: s.components[IN]["look"] == "active")
        rates = stream.next("rates")
        while not rates["connectors"].get("one", {}).get("hz"):
            rates = stream.next("rates")
        assert {each["event"] for each in stream.events} >= {"PORT_CONNECT", "ACTIVE"}
        pair.ok(
            f"rtdis {IN}:out",
        )
        stream.until(lambda s: "one" not in s.connectors)
        pair.ok(f"rtexit {IN}")
        stream.until(lambda s: IN not in s.components)


def test_the_dead_look_dead_and_return(pair: Shell) -> None:
    with served(pair) as client, client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        os.kill(stream.processes["/localhost/manager.mgr/s1.mgr"]["pid"], signal.SIGKILL)
        stream.until(lambda s: s.components[OUT]["look"] == "zombie")
        shown = next(each for each in pair.ok("rtls -l /localhost").splitlines() if "Out0" in each)
        assert f"({stream.components[OUT]['remark']})" in shown
        pair.ok("rtmgr stop")
        stream.until(lambda s: not s.managers and not s.components)
        pair.ok("rtmgr start")
        stream.until(lambda s: bool(s.managers))


def test_nothing_flows_where_the_manager_was_killed(pair: Shell) -> None:
    pair.ok(f"rtcon -i one {IN}:out {OUT}:in")
    pair.ok(f"rtact {IN}")
    with served(pair) as client, client.stream() as stream:
        while not stream.next("rates")["connectors"].get("one", {}).get("hz"):
            pass
        (known,) = stream.managers.values()
        os.kill(known["pid"], signal.SIGKILL)
        while "one" in stream.next("rates")["connectors"]:
            pass
        stream.until(lambda s: s.components[IN]["look"] == "unreachable")


def test_each_action_does_what_its_line_says_and_is_taken_back(pair: Shell) -> None:
    with served(pair) as client, client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        wire = {"do": "connect", "source": f"{IN}:out", "target": f"{OUT}:in", "id": "w"}
        made = client.do({**wire, "properties": {"dataport.subscription_type": "flush"}})
        assert "dataport.subscription_type  flush" in pair.ok(f"rtcat -ll {IN}:out")
        stream.until(lambda s: "w" in s.connectors)
        cut = client.do(*made["undo"])
        stream.until(lambda s: "w" not in s.connectors)
        client.do(*cut["undo"])
        assert "dataport.subscription_type  flush" in pair.ok(f"rtcat -ll {IN}:out")
        pair.ok(cut["steps"][0]["command"])
        stream.until(lambda s: "w" not in s.connectors)

        started = client.do(
            {"do": "activate", "component": IN}, {"do": "activate", "component": OUT}
        )
        stream.until(lambda s: s.components[OUT]["word"] == s.components[IN]["word"] == "Active")
        client.do(*started["undo"])
        stream.until(lambda s: s.components[OUT]["word"] == s.components[IN]["word"] == "Inactive")

        set_ = {"do": "configure", "component": "/localhost/C0.rtc", "set": "default"}
        changed = client.do({**set_, "values": {"int_param0": "7", "str_param1": "-a b'\"$x"}})
        assert pair.ok("rtconf /localhost/C0.rtc get str_param1") == "-a b'\"$x\n"
        pair.ok("rtconf /localhost/C0.rtc set int_param0 9")
        stream.until(
            lambda s: s.components[set_["component"]]["sets"]["default"]["int_param0"] == "9"
        )
        refused = client.ask("POST", "/api/do", {"actions": changed["undo"]})
        assert (refused.status, refused.body["error"]["kind"]) == (409, "refused")
        assert "it is '9', not '7'" in refused.body["error"]["text"]
        *_, last = client.ask("GET", "/api/changes").body["changes"]
        assert last["old"].startswith("int_param0=0, ")

        made = client.do(
            {"do": "create", "manager": "/localhost/manager.mgr", "create": "ConsoleIn"}
        )
        assert made["undo"] is None
        stream.until(lambda s: "/localhost/ConsoleIn0.rtc" in s.components)
        client.do({"do": "delete", "component": "/localhost/ConsoleIn0.rtc"})
        stream.until(lambda s: "/localhost/ConsoleIn0.rtc" not in s.components)
    line = "script at 127.0.0.1: Set int_param0=7, str_param1=-a b'\"$x in the set default of "
    assert f"{line}/localhost/C0.rtc from int_param0=0, str_param1=" in client.log


def test_a_failure_ends_what_follows_and_names_the_thing(pair: Shell) -> None:
    with served(pair) as client, client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        bad = {"do": "configure", "component": "/localhost/C0.rtc", "set": "default"}
        actions = [
            {"do": "activate", "component": IN},
            {**bad, "values": {"int_param0": "700"}},
            {"do": "activate", "component": OUT},
        ]
        planned = client.post("/api/do", {"actions": actions, "dry_run": True})
        assert [each["ok"] for each in planned["steps"]] == [None, None, None]
        outcome = client.post("/api/do", {"actions": actions})
        assert [each["ok"] for each in outcome["steps"]] == [True, False, None]
        assert outcome["steps"][1]["error"] == "int_param0 cannot be '700': it is to be 0<=x<=100"
        assert [each["do"] for each in outcome["undo"]] == ["deactivate"]
        assert "Inactive" in pair.ok(f"rtls -l {OUT}")


def test_layout_offers_fitting_ports_and_exports(pair: Shell) -> None:
    pair.ok(f"rtcon -i one {IN}:out {OUT}:in")
    with served(pair) as client, client.stream() as stream:
        stream.until(lambda s: "one" in s.connectors)
        layout = client.post("/api/layout", {"folded": []})
        assert layout == client.post("/api/layout", {"folded": []})
        assert layout["boxes"][OUT]["parent"] == "/localhost/manager.mgr/s1.mgr"
        first, *_, last = layout["paths"]["one"]
        box = layout["boxes"][OUT]
        assert last == [box["x"], box["y"] + box["ports"]["in"]["y"]]
        assert first[0] < last[0]
        folded = client.post("/api/layout", {"folded": ["/localhost/manager.mgr/s1.mgr"]})
        assert OUT not in folded["boxes"]
        assert "one" in folded["paths"]
        ports = client.ask("GET", f"/api/connectable?port={IN}:out").body["ports"]
        assert [(each["path"], each["why"]) for each in ports] == [(f"{OUT}:in", "")]
        offers = client.ask("GET", "/api/offers?manager=/localhost/manager.mgr").body
        assert "Motor" in [each["name"] for each in offers["types"]]
        files = [each["path"].rpartition("/")[2] for each in offers["modules"]]
        assert "Motor.py" in files
        assert "ConsoleIn.py" not in files
        drawn = client.ask("GET", "/api/export?form=svg")
        assert drawn.headers["content-type"].startswith("image/svg+xml")
        assert "Out0" in drawn.body
        assert client.ask("GET", "/api/export?form=gif").status == 400


def test_the_system_is_saved_and_compared_in_granted_folders(pair: Shell, tmp_path: Path) -> None:
    file = str(tmp_path.resolve() / "robot.yaml")
    with served(pair, f"--root {tmp_path}") as client, client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        client.do({"do": "save", "file": file})
        again = client.ask("POST", "/api/do", {"actions": [{"do": "save", "file": file}]})
        assert again.body["error"]["text"] == f"{file} is there already"
        assert client.ask("GET", "/api/files").body["files"] == [file]
        pair.ok("rtconf /localhost/C0.rtc set int_param0 9")
        url = f"/api/plans/compare?state=inactive&before={file}"
        (deviation,) = client.ask("GET", url).body["facts"]
        assert (deviation["subject"], deviation["found"]) == ("C0", "9")
        Path(file).write_text("rubbish", encoding="utf-8")
        assert client.ask("GET", url).status == 409
        assert client.ask("GET", "/api/plans/compare?before=/etc/passwd").status == 409


def test_an_interface_has_the_polarity_that_the_page_knows(manager: Shell) -> None:
    manager.ok("rtmgr -c MyServiceProvider /localhost/manager.mgr")
    with served(manager) as client, client.stream() as stream:
        stream.until(lambda s: "/localhost/MyServiceProvider0.rtc" in s.components)
        ports = stream.components["/localhost/MyServiceProvider0.rtc"]["ports"]
        (interface,) = next(each["interfaces"] for each in ports if each["name"] == "myservice")
        types = (ROOT / "web" / "src" / "model" / "types.ts").read_text()
        assert f"polarity: '{interface['polarity']}' | " in types


def test_it_serves_on_when_nobody_reads_its_output(pair: Shell) -> None:
    process = pair.open("rtweb --no-browser")
    assert process.stdout is not None
    address = process.stdout.readline().strip().removeprefix("http://127.0.0.1:")
    port, token = address.split("/#token=")
    process.stdout.close()
    with WebClient(int(port), token).stream() as stream:
        stream.until(lambda s: IN in s.components)
        pair.ok(f"rtact {IN}")
        stream.until(lambda s: s.components[IN]["word"] == "Active")
    process.send_signal(signal.SIGINT)
    process.wait(20)


def test_it_ends_without_a_word_while_pages_are_open(shell: Shell) -> None:
    process = shell.open("rtweb --no-browser")
    assert process.stdout is not None
    address = process.stdout.readline().strip().removeprefix("http://127.0.0.1:")
    port, token = address.split("/#token=")
    with WebClient(int(port), token).stream() as stream:
        stream.next("picture")
        process.send_signal(signal.SIGINT)
        assert shell.end_of(process).err == "rtweb: interrupted\n"


@pytest.mark.parametrize(
    ("method", "path", "headers", "status"),
    [
        ("GET", "/", {"Host": "evil.example"}, 403),
        ("GET", "/api/events", {"Host": "evil.example:80"}, 403),
        ("GET", "/api/events", {"Authorization": ""}, 401),
        ("GET", "/api/events", {"Authorization": "Bearer x"}, 401),
        ("GET", "/api/events", {"Origin": "http://evil.example"}, 403),
        ("GET", "/api/events", {"Sec-Fetch-Site": "cross-site"}, 403),
        ("GET", "/api/events", {"Sec-Fetch-Site": "same-site"}, 403),
        ("POST", "/api/do", {"Content-Type": "text/plain"}, 415),
        ("POST", "/api/do", {"Content-Type": "application/x-www-form-urlencoded"}, 415),
        ("PUT", "/api/do", {}, 405),
        ("POST", "/", {}, 405),
        ("GET", "/../../etc/passwd", {}, 404),
        ("GET", "/assets/..%2f..%2f..%2fetc%2fpasswd", {}, 404),
        ("GET", "/api/nothing", {}, 404),
    ],
)
def test_what_strangers_ask_is_refused(
    served_alone: WebClient, method: str, path: str, headers: dict[str, str], status: int
) -> None:
    answer = served_alone.ask(method, path, '{"actions": []}', headers)
    assert answer.status == status
    assert answer.headers["content-security-policy"].startswith("default-src 'none'")
    assert "access-control-allow-origin" not in answer.headers


def test_a_link_may_lead_to_the_page_and_to_nothing_else(served_alone: WebClient) -> None:
    link = {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate", "Authorization": ""}
    assert served_alone.ask("GET", "/", None, link).status == 200
    assert served_alone.ask("GET", "/api/events", None, link).status == 403
    assert served_alone.ask("GET", "/", None, {**link, "Host": "evil.example"}).status == 403


def test_the_secret_is_on_no_command_line(shell: Shell, tmp_path: Path) -> None:
    browser, seen = tmp_path / "browser", tmp_path / "seen"
    os.mkfifo(seen)
    browser.write_text(f'#!/bin/sh\necho "$@" > {seen}\n')
    browser.chmod(0o700)
    shell.environment["BROWSER"] = f"{browser} %s"
    process = shell.open("rtweb")
    assert process.stdout is not None
    token = process.stdout.readline().strip().partition("#token=")[2]
    given = seen.read_text().strip()
    assert token
    assert token not in given
    file = Path(given.removeprefix("file://"))
    assert f"#token={token}" in file.read_text()
    assert file.stat().st_mode & 0o777 == 0o600
    process.send_signal(signal.SIGINT)
    shell.end_of(process)
    assert not file.exists()


def test_a_token_in_the_query_does_not_count(served_alone: WebClient) -> None:
    answer = served_alone.ask(
        "GET", f"/api/events?token={served_alone.token}", None, {"Authorization": ""}
    )
    assert answer.status == 401


@pytest.mark.parametrize(
    "body",
    [
        "", "[]", "{", '{"actions": 1}', '{"actions": []}', '{"actions": [1]}',
        '{"actions": [{"do": "rm"}]}', '{"actions": [{"do": 1}]}',
        '{"actions": [{"do": "create", "manager": "/localhost/manager.mgr"}]}', "[" * 100_000,
    ],
)  # fmt: skip
def test_rubbish_is_refused_in_a_sentence(served_alone: WebClient, body: str) -> None:
    answer = served_alone.ask("POST", "/api/do", body)
    assert answer.status in (400, 404)
    assert answer.body["error"]["text"]


def test_nothing_is_changed_through_a_page_that_only_looks(pair: Shell) -> None:
    with served(pair, "--read-only") as client, client.stream() as stream:
        assert stream.next("picture")["read_only"]
        stream.until(lambda s: IN in s.components)
        answer = client.ask("POST", "/api/do", {"actions": [{"do": "activate", "component": IN}]})
        assert (answer.status, answer.body["error"]["kind"]) == (403, "denied")
        assert "Inactive" in pair.ok(f"rtls -l {IN}")
