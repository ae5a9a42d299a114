"""What a manager that does not run left on the disk, read as it would tell it."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest

from rtkit.deployment.facts import ComponentFacts, Snapshot
from rtkit.link import places
from rtkit.logs.outputs import head
from rtkit.manager.core.desired import DesiredState
from rtkit.manager.predecessor.last_known import last_known
from rtkit.manager.store.store import Store
from rtkit.rtc.profiles import ConnectorProfile, PortRef, TypeProfile
from rtkit.rtc.serde import encode

CRASH = """Fatal Python error: Segmentation fault

Current thread 0x0000000000000002 (most recent call first):
  File "/home/me/arm.py", line 15 in move
"""
DEAD = 2**22 + 5
"""A process id that the kernel never gives."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_STATE_DIR", str(tmp_path))
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    return tmp_path


def kept(*, places_of: dict[str, str], zombie: ComponentFacts | None = None) -> None:
    desired = DesiredState()
    for instance, place in places_of.items():
        create = f"Arm?instance_name={instance}" + f"&manager_name={place}" * bool(place)
        desired.made(instance, create, (f"localhost/{instance}.rtc",), None)
    if zombie is not None:
        desired.lost(zombie)
    wire = ConnectorProfile("w", "w", (PortRef("A", "out"), PortRef("B", "in")))
    desired.put("wire", "w", wire)
    store = Store(places.store_file("m"))
    store.write(desired.changes())
    store.close()


def facts(instance: str, **more: Any) -> ComponentFacts:
    return ComponentFacts(instance, TypeProfile("Arm"), "", since=5.0, **more)


def held(name: str, *instances: str, pid: int = DEAD) -> None:
    lines = [{"slave": name}, *(encode(facts(each)) for each in instances), {"rubbish": 1}]
    text = "".join(f"{json.dumps(line)}\n" for line in lines)
    Path(places.runtime_dir(), f"m.{pid}.held").write_text(text)


def crashed(slave: str, pid: int = DEAD) -> float:
    path = places.output_file("m", slave)
    Path(path).write_bytes(head(slave or "m", pid) + CRASH.encode())
    return os.stat(path).st_mtime


def known() -> Snapshot:
    found = last_known("m")
    assert found is not None
    return found


def component(instance: str) -> ComponentFacts:
    found = known().component(instance)
    assert found is not None
    return found


def test_nothing_was_left(folder: Path) -> None:
    assert last_known("m") is None
    Path(places.store_file("m")).write_bytes(b"rubbish")
    assert last_known("m") is None
    assert Path(places.store_file("m")).read_bytes() == b"rubbish"


def test_what_the_manager_itself_held_ended_with_it(folder: Path) -> None:
    kept(places_of={"A": "", "B": "s"})
    a = component("A")
    assert (a.zombie, a.process, a.names) == ("ended with its manager", "m", ("localhost/A.rtc",))
    assert (a.type.type_name, a.since, a.restart_status.restarts) == ("Arm", 0.0, 0)
    assert component("B").zombie == "ended while no manager ran"
    states = {each.name: (each.state, each.reason) for each in known().processes}
    assert states == {"m": ("lost", "ended"), "s": ("lost", "ended while no manager ran")}
    assert [each.connector_id for each in known().connectors] == ["w"]


def test_a_crash_of_the_manager_is_the_end_of_what_it_held(folder: Path) -> None:
    kept(places_of={"A": "", "B": "s"})
    at = crashed("")
    assert component("A").zombie == "signal 11 at arm.py:15 in move"
    assert abs(component("A").since - at) < 1
    assert component("B").zombie == "ended while no manager ran"


def test_a_crash_of_a_slave_that_no_manager_saw(folder: Path) -> None:
    kept(places_of={"A": "", "B": "s"})
    held("s", "B")
    assert (component("B").zombie, component("B").since) == ("ended while no manager ran", 5.0)
    at = crashed("s")
    assert component("B").zombie == "signal 11 at arm.py:15 in move"
    assert abs(component("B").since - at) < 1
    assert component("B").create == "Arm?instance_name=B&manager_name=s"


def test_one_that_its_manager_saw_die_and_who_was_with_it(folder: Path) -> None:
    dead = ComponentFacts("B", TypeProfile("Arm"), "s", zombie="signal 9", since=7.0)
    kept(places_of={"B": "s", "C": "s"}, zombie=dead)
    assert [(component(each).zombie, component(each).since) for each in ("B", "C")] == [
        ("signal 9", 7.0),
        ("signal 9", 7.0),
    ]
    states = {each.name: (each.state, each.reason) for each in known().processes}
    assert states["s"] == ("lost", "signal 9")
