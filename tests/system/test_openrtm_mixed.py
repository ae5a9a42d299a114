"""Components written for OpenRTM-aist beside native ones: same data, services, tools, profiles."""

from __future__ import annotations

import itertools
import json
import os
import re
import signal
from pathlib import Path
from typing import Any

import pytest
from openrtm_mixed import TYPES, write_both
from waiting import until

PLACE = "/localhost/manager.mgr"
ROUND = ("New0", "Old0", "New1", "Old1")
"""Components in the order in which values pass through them: two of each kind, in turns."""
VALUES = {
    "long": "7",
    "doubles": "[1.5, -2.25]",
    "text": '"日本 \\" x"',
    "wide": '"ワイド"',
    "octets": "[1, 2, 255]",
    "chars": '["a", "b"]',
    "flags": "[true, false]",
    "pose": '{"data": {"position": {"x": 1.5, "y": 2}, "heading": 0.25}}',
    "speed": '{"data": {"vx": 1, "vy": 2, "va": 3}}',
    "image": '{"width": 2, "height": 1, "bpp": 8, "format": "GRAY8", "pixels": [0, 255]}',
    "part": '{"name": "cup", "weight": 0.5, "mode": "DRIVE", "free": [1, 2]}',
}


def make(manager: Any, folder: Path, *, in_slaves: bool) -> None:
    """Have the components of the round made, in one process or each in a slave of its own."""
    old, new = write_both(folder)
    manager.ok(f"rtbuild {folder / 'Cell.idl'} -o {folder}")
    creates = " ".join(
        f"-c '{each[:3]}?instance_name={each}{f'&manager_name=at{each}' if in_slaves else ''}'"
        for each in ROUND
    )
    manager.ok(f"rtmgr -l {old}:OldInit -l {new}:NewInit {creates} {PLACE}")


def wire(manager: Any, *names: str) -> None:
    """Connect the data ports of these pairs, and the services of each with its neighbours."""
    for one, other in itertools.pairwise(ROUND):
        for name in names:
            manager.ok(f"rtcon /localhost/{one}.rtc:{name}_out /localhost/{other}.rtc:{name}_in")
    for one, other in itertools.pairwise((*ROUND, ROUND[0])):
        manager.ok(f"rtcon /localhost/{one}.rtc:needed /localhost/{other}.rtc:provided")


def activate(manager: Any) -> None:
    manager.ok(f"rtact {' '.join(f'/localhost/{each}.rtc' for each in ROUND)}")


@pytest.fixture(params=["one process", "slaves"])
def system(manager: Any, tmp_path: Path, request: pytest.FixtureRequest) -> Any:
    make(manager, tmp_path, in_slaves=request.param == "slaves")
    wire(manager, *TYPES)
    activate(manager)
    return manager


def printed(manager: Any, component: str) -> list[str]:
    log = manager.ok(f"rtvlog --no-follow -n 100 /localhost/{component}.rtc")
    return re.findall(r"(?:weighed|missing) .*", log)


def test_values_and_calls_pass_both_ways_and_look_alike(system: Any) -> None:
    for each in ROUND:
        shown = until(lambda each=each: (found := printed(system, each))[1:] and found, each)
        assert shown == ["weighed 0.25 in DRIVE of 1", "missing hat 3"]
    for name, value in VALUES.items():
        ends = [system.open(f"rtprint -v -n 1 /localhost/{each}.rtc:{name}_out") for each in ROUND]
        for end in ends:
            assert "is connected" in end.stderr.readline()
        system.ok(f"rtinject -c '{value}' /localhost/{ROUND[0]}.rtc:{name}_in")
        texts = [end.communicate(timeout=30)[0] for end in ends]
        assert texts[0].strip(), name
        assert texts == [texts[0]] * len(ROUND), name


def test_a_recording_of_one_is_played_into_the_other(system: Any, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    ports = " ".join(f"/localhost/{each}.rtc:part_out" for each in ROUND)
    recording = system.open(f"rtlog -v -i -e 4 -f {file} {ports}")
    assert "is connected" in recording.stderr.readline()
    system.ok(f"rtinject -c '{VALUES['part']}' /localhost/{ROUND[0]}.rtc:part_in")
    recording.communicate(timeout=30)
    rows = [json.loads(line) for line in system.ok(f"rtlog --export json -f {file}").splitlines()]
    assert [row["value"] for row in rows] == [rows[0]["value"]] * len(ROUND)
    assert rows[0]["value"]["name"] == "cup"
    for stream, into, out in (("Old0", "New0", "Old0"), ("New0", "Old0", "New1")):
        printing = system.open(f"rtprint -v -n 1 /localhost/{out}.rtc:part_out")
        assert "is connected" in printing.stderr.readline()
        played = system.run(f"rtlog -p -f {file} /localhost/{into}.rtc:part_in.{stream}_part_out")
        assert played.status == 0, played.err
        assert "cup" in printing.communicate(timeout=30)[0]


def outline(value: Any) -> Any:
    """Return the keys of plain data, and the types of what they have."""
    if isinstance(value, dict):
        return {key: outline(each) for key, each in value.items()}
    if isinstance(value, list):
        return [outline(each) for each in value]
    return type(value).__name__


def test_both_are_described_alike(manager: Any, tmp_path: Path) -> None:
    make(manager, tmp_path, in_slaves=False)
    old, new = (
        json.loads(manager.ok(f"rtcat --json /localhost/{e}.rtc")) for e in ("Old0", "New0")
    )
    assert old["ports"] == new["ports"]
    assert new["sets"].pop("__type__") == {"gain": "int"}  # what OpenRTM takes, it takes, too
    assert outline(old) == outline(new)
    for each in ("Old", "New"):
        manager.ok(f"rtprofile from {tmp_path / each}.py:{each}Init -o {tmp_path / each}.yaml")
    texts = [(tmp_path / f"{each}.yaml").read_text() for each in ("Old", "New")]
    own = re.compile(r"Old|New|rtc:?(?:creation|update)Date.*|updateDate.*|creationDate.*")
    assert own.sub("", texts[0]) == own.sub("", texts[1])


def test_a_mixed_system_is_saved_and_restored(system: Any, tmp_path: Path) -> None:
    file = tmp_path / "mixed.xml"
    system.ok("rtconf /localhost/Old0.rtc set gain 5")
    system.ok("rtconf /localhost/New0.rtc set gain 5")
    system.ok(f"rtcryo -o {file}")
    system.ok(f"rtteardown --exit {file}")
    system.ok(f"rtresurrect {file}")
    assert system.run(f"rtstart {file}").status == 0
    assert system.run(f"rtcheck {file}").status == 0
    assert [system.ok(f"rtconf /localhost/{e}.rtc get gain") for e in ("Old0", "New0")] == [
        "5\n", "5\n",
    ]  # fmt: skip


@pytest.mark.parametrize(("victim", "first", "second"), [
    ("New1", "New0", "Old0"),
    ("Old0", "New1", "Old1"),
])  # fmt: skip
def test_the_end_of_a_slave_leaves_the_others_at_work(
    manager: Any, tree: Any, tmp_path: Path, victim: str, first: str, second: str
) -> None:
    make(manager, tmp_path, in_slaves=True)
    wire(manager, "long")
    activate(manager)
    (pid,) = [each.pid for each in tree.snapshot().processes if each.name == f"at{victim}"]
    os.kill(pid, signal.SIGKILL)
    rows = until(
        lambda: (shown := manager.run("rtls -l /localhost").out) and "signal 9" in shown and shown,
        f"{victim} is shown as gone",
    )
    assert rows.count("Active") == len(ROUND) - 1
    printing = manager.open(f"rtprint -v -f data -n 1 /localhost/{second}.rtc:long_out")
    assert "is connected" in printing.stderr.readline()
    manager.ok(f"rtinject -c 5 /localhost/{first}.rtc:long_in")
    assert printing.communicate(timeout=30)[0] == "5\n"
