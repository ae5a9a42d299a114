"""What the page does beside wires and states: each is a command line, and is taken back."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from shells import Shell
from webkit import Stream, WebClient, served

MANAGER, SLAVE = "/localhost/manager.mgr", "/localhost/manager.mgr/s1.mgr"
IN, OUT, CONFIG = "/localhost/In0.rtc", "/localhost/Out0.rtc", "/localhost/C0.rtc"
WHOLE = "/localhost/Both.rtc"


class Room:
    """A server over three components, with its stream read as far as is needed."""

    def __init__(self, shell: Shell, client: WebClient, stream: Stream) -> None:
        self.shell = shell
        self.client = client
        self.stream = stream

    def until(self, condition: Callable[[Stream], Any]) -> None:
        self.stream.until(condition)

    def do(self, do: str, **given: object) -> list[Any]:
        """Have an action done; return what takes it back."""
        undo = self.client.do({"do": do, **given})["undo"]
        return undo if undo is not None else []

    def refusal(self, do: str, **given: object) -> str:
        """Return why an action is not even planned."""
        answer = self.client.ask("POST", "/api/do", {"actions": [{"do": do, **given}]})
        assert answer.status >= 400, answer
        return str(answer.body["error"]["text"])

    def failure(self, do: str, **given: object) -> str:
        """Return what the command of an action says that cannot be done."""
        (step,) = self.client.post("/api/do", {"actions": [{"do": do, **given}]})["steps"]
        assert step["ok"] is False, step
        return str(step["error"])

    def component(self, id: str) -> Any:
        return self.stream.components[id]


@pytest.fixture
def room(manager: Shell) -> Iterator[Room]:
    manager.ok(
        "rtmgr -c 'ConsoleIn?instance_name=In0' -c 'ConsoleOut?instance_name=Out0'"
        " -c 'ConfigSample?instance_name=C0' /localhost/manager.mgr"
    )
    with served(manager) as client, client.stream() as stream:
        stream.until(lambda s: CONFIG in s.components)
        yield Room(manager, client, stream)


def test_sets_are_added_copied_renamed_and_removed(room: Room) -> None:
    def sets(stream: Stream) -> Any:
        return stream.components[CONFIG]["sets"]

    assert "__widget__" in sets(room.stream)
    undo = room.do("add_set", component=CONFIG, set="gentle", source="default",
                   values={"int_param0": "3"})  # fmt: skip
    room.until(lambda s: "gentle" in sets(s))
    assert room.shell.ok(f"rtconf -s gentle {CONFIG} get int_param0") == "3\n"
    before = sets(room.stream)["gentle"]
    renamed = room.client.do(
        {"do": "remove_set", "component": CONFIG, "set": "gentle"},
        {"do": "add_set", "component": CONFIG, "set": "kind", "values": before},
    )
    room.until(lambda s: "kind" in sets(s) and "gentle" not in sets(s))
    room.client.do(*renamed["undo"])
    room.until(lambda s: sets(s).get("gentle") == before and "kind" not in sets(s))
    room.client.do(*undo)
    room.until(lambda s: "gentle" not in sets(s))
    assert room.failure("remove_set", component=CONFIG, set="default").endswith(
        "configuration set default was not added at run time"
    )
    assert "no configuration set 'x'" in room.refusal("remove_set", component=CONFIG, set="x")
    assert "already" in room.refusal("add_set", component=CONFIG, set="default", source="default")


def test_contexts_drive_others_and_let_them_go(room: Room) -> None:
    def guests(stream: Stream) -> Any:
        return stream.components[CONFIG]["contexts"][0]["participants"]

    undo = room.do("attach", component=CONFIG, context="0", participant=IN)
    room.until(lambda s: guests(s) == [IN])
    assert "Participants" in room.shell.ok(f"rtcat -l {CONFIG}")
    assert "takes part" in room.refusal("attach", component=CONFIG, participant=IN)
    (again,) = room.client.do(*undo)["undo"]
    room.until(lambda s: guests(s) == [])
    assert again["do"] == "attach"


def test_composites_are_made_changed_and_dissolved(room: Room) -> None:
    room.shell.ok(f"rtcon -i w {IN}:out {OUT}:in")

    def ports(stream: Stream) -> Any:
        return [each["name"] for each in stream.components.get(WHOLE, {}).get("ports", ())]

    made = {"process": MANAGER, "name": "Both", "members": [IN], "ports": [f"{IN}:out"]}
    undo = room.do("compose", **made, options="exec_cxt.periodic.rate=50")
    room.until(lambda s: ports(s) == ["In0.out"])
    added = room.do("add_member", component=WHOLE, member=OUT, ports=["in"])
    room.until(lambda s: ports(s) == ["In0.out", "Out0.in"])
    hidden = room.do("remove_member", component=WHOLE, member=OUT, ports=["in"])
    room.until(lambda s: ports(s) == ["In0.out"])
    room.client.do(*hidden)
    room.until(lambda s: ports(s) == ["In0.out", "Out0.in"])
    room.client.do(*added)
    room.until(lambda s: room.component(WHOLE)["members"] == [IN])
    again = room.client.do(*undo)["undo"]
    room.until(lambda s: WHOLE not in s.components)
    assert "w" in room.stream.connectors
    room.client.do(*again)
    room.until(lambda s: ports(s) == ["In0.out"])
    assert room.component(WHOLE)["contexts"][0]["rate_hz"] == 50
    assert "no composite" in room.refusal("dissolve", component=IN)


def test_who_was_active_before_a_composite_is_active_when_it_is_undone(room: Room) -> None:
    def words(*ids: str) -> Any:
        return [room.stream.components.get(id, {}).get("word") for id in ids]

    room.do("activate", component=IN)
    room.until(lambda _: words(IN, OUT) == ["Active", "Inactive"])
    undo = room.do("compose", process=MANAGER, name="Both", members=[IN, OUT])
    room.until(lambda _: words(WHOLE, IN, OUT) == ["Inactive"] * 3)
    again = room.client.do(*undo)["undo"]
    room.until(lambda _: words(WHOLE, IN, OUT) == [None, "Active", "Inactive"])
    assert [each["do"] for each in again] == ["compose"]

    undo = room.client.do(*again)["undo"]
    room.do("activate", component=WHOLE)
    room.until(lambda _: words(WHOLE, IN, OUT) == ["Active"] * 3)
    dissolved = room.do("dissolve", component=WHOLE)
    room.until(lambda _: words(WHOLE, IN, OUT) == [None, "Inactive", "Inactive"])
    room.client.do(*dissolved)
    room.until(lambda _: words(WHOLE, IN, OUT) == ["Active"] * 3)

    room.do("activate", component=CONFIG)
    room.until(lambda _: words(CONFIG) == ["Active"])
    room.do("deactivate", component=WHOLE)
    added = room.do("add_member", component=WHOLE, member=CONFIG)
    room.until(lambda _: words(WHOLE, CONFIG) == ["Inactive", "Inactive"])
    room.client.do(*added)
    room.until(lambda _: words(WHOLE, CONFIG) == ["Inactive", "Active"])


def test_zombies_are_forgotten_at_once(room: Room) -> None:
    room.shell.ok(f"rtmgr -c 'ConsoleIn?instance_name=A&manager_name=s1' {MANAGER}")
    room.shell.ok(f"rtmgr -c 'ConsoleIn?instance_name=B&manager_name=s2' {MANAGER}")
    room.until(lambda s: {f"{MANAGER}/s1.mgr", f"{MANAGER}/s2.mgr"} <= set(s.processes))
    for name in ("s1", "s2"):
        os.kill(room.stream.processes[f"{MANAGER}/{name}.mgr"]["pid"], signal.SIGKILL)
    room.until(lambda s: [c["look"] for c in s.components.values()].count("zombie") == 2)
    planned = room.client.post("/api/do", {"actions": [{"do": "forget_zombies"}], "dry_run": True})[
        "steps"
    ][0]
    assert planned["text"] == "Forget 2 zombies: /localhost/A.rtc, /localhost/B.rtc"
    room.do("forget_zombies")
    room.until(lambda s: "/localhost/A.rtc" not in s.components)
    assert room.refusal("forget_zombies") == "There is no zombie"


def test_modules_and_slaves_come_and_go(room: Room) -> None:
    def loaded() -> list[str]:
        answer = room.client.ask("GET", f"/api/offers?manager={MANAGER}").body
        return [each["path"] for each in answer["loaded"]]

    undo = room.do("unload", manager=MANAGER, path="ConsoleIn.py", init="ConsoleInInit")
    assert "ConsoleIn.py" not in loaded()
    room.client.do(*undo)
    assert "ConsoleIn.py" in loaded()
    known = set(room.stream.processes)
    room.do("fork", manager=MANAGER)
    room.until(lambda s: len(s.processes) > len(known))
    (slave,) = set(room.stream.processes) - known
    room.shell.ok(f"rtmgr -c 'ConsoleIn?instance_name=In9&manager_name=s1' {MANAGER}")
    room.until(lambda s: "/localhost/In9.rtc" in s.components)
    body = {"actions": [{"do": "end_slave", "process": SLAVE}], "dry_run": True}
    (step,) = room.client.post("/api/do", body)["steps"]
    assert step["text"].endswith("and with it the component /localhost/In9.rtc")
    room.do("end_slave", process=SLAVE)
    room.until(lambda s: "/localhost/In9.rtc" not in s.components)
    room.do("end_slave", process=slave)
    room.until(lambda s: slave not in s.processes)
    assert "stop the manager" in room.refusal("end_slave", process=MANAGER)


def test_managers_are_stopped_started_and_restarted(room: Room) -> None:
    room.shell.ok(f"rtcon -i w {IN}:out {OUT}:in")
    room.until(lambda s: "w" in s.connectors)
    body = {"actions": [{"do": "stop_manager", "manager": MANAGER}], "dry_run": True}
    (step,) = room.client.post("/api/do", body)["steps"]
    assert f"3 components: {IN}, {OUT}, {CONFIG}" in step["text"]
    assert f"from {IN}:out to {OUT}:in" in step["text"]
    undo = room.do("stop_manager", manager=MANAGER, keep=True)
    room.until(lambda s: not s.managers)
    again = room.client.do(*undo)["undo"]
    room.until(lambda s: "w" in s.connectors)
    before = room.component(IN)["since"]
    room.do("restart_manager", manager=MANAGER)
    room.until(lambda s: IN in s.components and s.components[IN]["since"] > before)
    room.until(lambda s: "w" in s.connectors)
    assert again == [{"do": "stop_manager", "manager": MANAGER, "keep": True}]
    level = {"manager": MANAGER, "key": "logger.log_level"}
    undo = room.do("set_property", **level, value="DEBUG", before="INFO")
    assert room.shell.ok(f"rtconf {MANAGER} get logger.log_level") == "DEBUG\n"
    room.client.do(*undo)
    assert room.shell.ok(f"rtconf {MANAGER} get logger.log_level") == "INFO\n"
