"""What flows: values of ports as pages get them, values written to ports, recordings."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from shells import Shell
from webkit import Stream, WebClient, served

OUT, IN, GOAL = "/localhost/SeqOut0.rtc", "/localhost/SeqIn0.rtc", "/localhost/Motor0.rtc"
PORTS = [f"{OUT}:Long", f"{IN}:Long"]
HAS_VALUES = 500
"""Size of a recording with values; without any it has a beginning only."""


@pytest.fixture(scope="module")
def flow(shared_shell: Shell) -> Iterator[Shell]:
    """A system in which values flow to a component that takes none."""
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
def client(flow: Shell, folder: Path) -> Iterator[WebClient]:
    with served(flow, f"--root {folder}") as client:
        yield client


def shown(flow: Shell) -> str:
    return flow.ok("rtls -lR /localhost") + flow.ok(f"rtcat -ll {OUT}")


def until(stream: Stream, port: str, condition: Any) -> dict[str, Any]:
    """Return the first sample of a port that is as wanted."""
    while True:
        sample = stream.next("values")["values"].get(port)
        if sample is not None and condition(sample):
            return dict(sample)


def test_values_come_of_the_ports_that_a_page_shows_and_nothing_else_shows_it(
    client: WebClient, flow: Shell
) -> None:
    before = shown(flow)
    with client.stream("one") as stream:
        stream.until(lambda s: OUT in s.components)
        client.post("/api/watch", {"page": "one", "ports": PORTS})
        first = until(stream, PORTS[0], lambda sample: sample["at"])
        assert set(first["numbers"]) == {"data"}
        assert first["text"].endswith(f"] {first['numbers']['data']:.0f}")
        later = until(stream, PORTS[0], lambda sample: sample["count"] > first["count"])
        assert later["numbers"]["data"] > first["numbers"]["data"]
        assert later["at"] > first["at"]
        # Nobody reads at the other end: its buffer is full, and drops the oldest.
        tight = until(stream, PORTS[1], lambda sample: sample["buffers"]["one"][2] > 0)
        assert tight["buffers"]["one"][:2] == [8, 8]
        assert shown(flow) == before
        client.post("/api/watch", {"page": "one", "ports": []})
        assert "values" not in stream.next("rates")


def test_a_watch_is_of_a_page_that_is_open(client: WebClient) -> None:
    answer = client.ask("POST", "/api/watch", {"page": "nobody", "ports": PORTS})
    assert (answer.status, answer.body["error"]["text"]) == (404, "No such page: nobody")
    answer = client.ask("POST", "/api/watch", {"page": "one", "ports": "all"})
    assert answer.status == 400


def test_a_value_is_checked_and_written_by_the_command_that_is_shown(client: WebClient) -> None:
    port = f"{GOAL}:velocity"
    described = client.ask("GET", f"/api/port?port={port}").body
    assert described["type"] == "RTC::TimedVelocity2D"
    assert [(each["name"], each["kind"]) for each in described["fields"]] == [
        ("data.vx", "number"), ("data.vy", "number"), ("data.va", "number"),
    ]  # fmt: skip
    check = {"port": port, "value": '{"data": {"vx": "fast"}}'}
    assert "fast" in client.post("/api/port/check", check)["why"]
    value = '{"data": {"vx": 0.5}}'
    assert client.post("/api/port/check", {"port": port, "value": value}) == {"why": ""}
    with client.stream("two") as stream:
        stream.until(lambda s: GOAL in s.components)
        client.post("/api/watch", {"page": "two", "ports": [port]})
        until(stream, port, lambda _sample: True)
        done = client.do({"do": "inject", "port": port, "value": value})
        assert done["steps"][0]["command"] == f"rtinject '--const={value}' -- {port}"
        assert done["undo"] is None
        sample = until(stream, port, lambda sample: "text" in sample)
        assert sample["numbers"]["data.vx"] == 0.5
    answer = client.ask(
        "POST", "/api/do", {"actions": [{"do": "inject", "port": PORTS[0], "value": "1"}]}
    )
    assert (answer.status, answer.body["error"]["text"]) == (409, f"{PORTS[0]} is no in port")


def test_a_recording_is_a_job_until_it_is_stopped(
    client: WebClient, flow: Shell, folder: Path
) -> None:
    file = folder / "run.mcap"
    with client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        job = client.post("/api/record", {"ports": [PORTS[0]], "file": str(file)})
        assert job["command"] == f"rtlog --filename={file} -- {PORTS[0]}"
        while not file.exists() or file.stat().st_size < HAS_VALUES:
            stream.next("rates")
        client.post(f"/api/jobs/{job['id']}/stop", {})
        while (news := stream.next("job"))["status"] is None:
            pass
        assert news["status"] == -2  # as by Ctrl-C
    assert "SeqOut0_Long" in flow.ok(f"rtlog -d -f {file}")
    again = client.ask("POST", "/api/record", {"ports": [PORTS[0]], "file": str(file)})
    assert (again.status, again.body["error"]["text"]) == (409, f"{file} is there already")
    for name in ("/tmp/run.mcap", f"{folder}/../run.mcap", f"{folder}/run.py"):
        outside = client.ask("POST", "/api/record", {"ports": [PORTS[0]], "file": name})
        assert outside.status == 409


def came_in(past: dict[str, Any], id: str) -> Any:
    """Return the first change by which a component came, None if it has not."""
    changes = (each for each in past["changes"] if any(c["id"] == id for c in each["components"]))
    return next(changes, None)


def test_the_past_reaches_back_to_what_the_manager_still_holds(flow: Shell) -> None:
    early = "/localhost/Early0.rtc"
    flow.ok("rtmgr -c 'ConfigSample?instance_name=Early0' /localhost/manager.mgr")
    flow.ok(f"rtexit {early}")
    with served(flow) as client, client.stream() as stream:
        began = stream.next("picture")["since"]
        past = client.ask("GET", "/api/past").body
        while (came := came_in(past, early)) is None:
            assert stream.next("past")["since"] < began
            past = client.ask("GET", "/api/past").body
        assert past["since"] <= came["time"] < began
        assert past["picture"]["components"] == []
        events = client.ask("GET", "/api/events").body["events"]
        about = [each["event"] for each in events if each["path"] == early]
        assert about == ["APPEARED", "VANISHED"]
        export = "/api/export?form=text"
        assert "Early0" in client.ask("GET", f"{export}&at={came['time']}").body
        assert "Early0" not in client.ask("GET", export).body
        unknown = client.ask("GET", f"{export}&at=12")
        assert unknown.status == 404
        assert "is not known" in unknown.body["error"]["text"]
        assert client.ask("GET", f"{export}&at=then").status == 400


def test_a_tool_is_seen_by_what_it_does_to_a_component(client: WebClient, flow: Shell) -> None:
    with client.stream() as stream:
        stream.until(lambda s: OUT in s.components)
        flow.ok(f"rtinject --const='{{data: {{vx: 0.5, va: 0.0}}}}' {GOAL}:velocity")
        stream.until(lambda s: any(each["event"] == "PORT_DISCONNECT" for each in s.events))
        flow.ok("rtmgr -c 'ConfigSample?instance_name=Last0' /localhost/manager.mgr")
        stream.until(lambda s: "/localhost/Last0.rtc" in s.components)
        flow.ok("rtexit /localhost/Last0.rtc")
    about = [(each["path"], each["event"]) for each in stream.events]
    assert [each for each in about if "Last0" not in each[0]] == [
        (GOAL, "PORT_CONNECT"), (GOAL, "PORT_DISCONNECT"),
    ]  # fmt: skip


def test_the_past_is_kept_as_pages_were_told(client: WebClient, flow: Shell) -> None:
    with client.stream() as stream:
        picture = stream.next("picture")
        flow.ok("rtmgr -c 'ConfigSample?instance_name=Brief0' /localhost/manager.mgr")
        stream.until(lambda s: "/localhost/Brief0.rtc" in s.components)
        flow.ok("rtexit /localhost/Brief0.rtc")
        stream.until(lambda s: "/localhost/Brief0.rtc" not in s.components)
    past = client.ask("GET", "/api/past").body
    assert past["since"] <= picture["since"]
    came = came_in(past, "/localhost/Brief0.rtc")
    went = next(
        each for each in past["changes"] if "/localhost/Brief0.rtc" in each["gone"]["components"]
    )
    assert came["time"] < went["time"]
    assert {each["event"] for each in came["events"]} >= {"APPEARED"}
    boxes = [
        client.post("/api/layout", {"at": each["time"]})["boxes"].keys() for each in (came, went)
    ]
    assert boxes[0] - boxes[1] == {"/localhost/Brief0.rtc"}
    answer = client.ask("POST", "/api/layout", {"at": "now"})
    assert answer.status == 400


def test_logs_are_followed_by_a_job(client: WebClient, flow: Shell) -> None:
    with client.stream() as stream:
        job = client.post("/api/logs", {"path": "/", "level": "INFO", "before": 5})
        assert job["command"] == "rtvlog --json --level=INFO --number=5 -- /"
        while not (news := stream.next("job")).get("rows"):
            pass
        assert {"time", "level", "manager", "component", "pid", "host", "message"} <= {
            *news["rows"][0]
        }
        flow.ok("rtmgr -c 'ConfigSample?manager_name=fresh' /localhost/manager.mgr")
        while not any(row["process"] == "fresh" for row in news.get("rows", ())):
            news = stream.next("job")
        client.post(f"/api/jobs/{job['id']}/stop", {})
        while stream.next("job")["status"] is None:
            pass
    for body in (
        {"level": "LOUD"},
        {"path": "", "level": "INFO"},
        {"level": "INFO", "before": "x"},
    ):
        assert client.ask("POST", "/api/logs", body).status == 400


def test_a_page_that_is_read_only_looks_and_changes_nothing(flow: Shell, folder: Path) -> None:
    with served(flow, f"--read-only --root {folder}") as client, client.stream("mine") as stream:
        stream.until(lambda s: OUT in s.components)
        client.post("/api/watch", {"page": "mine", "ports": PORTS})
        until(stream, PORTS[0], lambda sample: sample["at"])
        record = {"ports": [PORTS[0]], "file": f"{folder}/none.mcap"}
        inject = {"actions": [{"do": "inject", "port": PORTS[1], "value": "1"}]}
        for path, body in (("/api/record", record), ("/api/do", inject)):
            answer = client.ask("POST", path, body)
            assert (answer.status, answer.body["error"]["kind"]) == (403, "denied")
