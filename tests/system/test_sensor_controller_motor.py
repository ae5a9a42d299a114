"""The robot of three processes: up, saved, down, up again; killed, repaired; broken off."""

from __future__ import annotations

import json
import os
import re
import select
import signal
from typing import Any

import pytest
from waiting import told_pid

from rtkit.profile.read import read_rts
from rtkit.resources import resource

KEEPS_MANAGER = True
FILE = resource("profiles", "systems", "sensor-controller-motor.xml")
SLOW = """
import os
import time
from rtkit.component import Component


class Slow(Component):
    def on_initialize(self):
        fd = os.open(os.environ["RTKIT_STATE_DIR"] + "/begun", os.O_WRONLY)
        os.write(fd, b"x")
        time.sleep(0.5)


def SlowInit(manager):
    manager.register_factory(Slow)
"""


def up(shell: Any, file: str = FILE) -> None:
    assert shell.run(f"rtresurrect {file}") == (0, "", "")


def listing(shell: Any, path: str = "/localhost") -> dict[str, Any]:
    lines = shell.ok(f"rtls --json {path}").splitlines()
    records = [json.loads(line) for line in lines]
    return {record["path"].rpartition("/")[2]: record for record in records}


def pids(shell: Any) -> dict[str, int]:
    """Return the process of each component, by name."""
    made = {"Sensor0": "sensor", "Controller0": "controller", "Motor0": "motor"}
    path = "/localhost/manager.mgr"
    for name, slave in made.items():
        assert shell.ok(f"rtls -1 {path}/{slave}.mgr").split()[0] == f"{name}.rtc"
    return {name: told_pid(shell, slave) for name, slave in made.items()}


def without_dates(file: Any) -> str:
    return re.sub(r'rts:(creation|update)Date="[^"]*"', "", file.read_text())


def kill(pid: int) -> None:
    pidfd = os.pidfd_open(pid)
    os.kill(pid, signal.SIGKILL)
    assert select.select([pidfd], [], [], 10)[0]
    os.close(pidfd)


def test_each_component_has_a_process(manager: Any) -> None:
    up(manager)
    assert len(set(pids(manager).values())) == 3


def test_saved_torn_down_and_brought_up_it_is_the_same(manager: Any) -> None:
    up(manager)
    manager.ok("rtconf /localhost/Motor0.rtc set patience 0.75")
    manager.ok("rtcryo -o first.xml")
    assert manager.run("rtteardown --exit first.xml") == (0, "", "")
    assert list(listing(manager)) == ["manager.mgr"]
    up(manager, "first.xml")
    manager.ok("rtcryo -o second.xml")
    first, second = (manager.folder / name for name in ("first.xml", "second.xml"))
    assert without_dates(first) == without_dates(second)
    assert "0.75" in first.read_text()
    assert read_rts(first.read_bytes(), strict=True).notes == ()


def test_the_robot_drives(manager: Any) -> None:
    up(manager)
    assert manager.run(f"rtstart {FILE}").status == 0
    assert manager.run(f"rtcheck {FILE}") == (0, "", "")
    stopped = manager.run(f"rtstop {FILE}")
    assert [line.split()[3] for line in stopped.err.splitlines()] == [
        "/localhost/Sensor0.rtc",
        "/localhost/Motor0.rtc",
        "/localhost/Controller0.rtc",
    ]
    assert {r["state"] for r in listing(manager).values() if "state" in r} == {"Inactive"}


def test_a_killed_slave_is_repaired_and_nothing_else_touched(manager: Any) -> None:
    up(manager)
    manager.run(f"rtstart {FILE}")
    before = pids(manager)
    kill(before["Controller0"])
    outcome = manager.run(f"rtcheck {FILE}")
    assert outcome.status == 1
    assert outcome.err.splitlines()[0] == (
        "Required component missing: /localhost/Controller0.rtc (zombie: signal 9)"
    )
    up(manager)
    after = pids(manager)
    assert {n for n in after if after[n] != before[n]} == {"Controller0"}
    states = {n: r["state"] for n, r in listing(manager).items() if "state" in r}
    assert states == {
        "Controller0.rtc": "Inactive",
        "Motor0.rtc": "Active",
        "Sensor0.rtc": "Active",
    }
    assert manager.run(f"rtstart {FILE}").status == 0
    assert manager.run(f"rtcheck {FILE}") == (0, "", "")


def test_stand_ins_take_the_places_of_the_real_ones(manager: Any) -> None:
    assert manager.run(f"rtresurrect --stand-in {FILE}") == (0, "", "")
    assert len(set(pids(manager).values())) == 3
    assert all(r["is_stand_in"] for r in listing(manager).values() if "state" in r)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('"Motor?', '"Nothing?', "component type Nothing is not known"),
        ("localhost/Motor0", "10.0.0.9/Motor0", "no such host: 10.0.0.9 (component Motor0)"),
        (
            'rts:portName="Motor0.velocity"',
            'rts:portName="Motor0.none"',
            "Required port not found: none (on /localhost/Motor0.rtc)",
        ),
        ('"Motor?', '"Sensor?', "ID of component at /localhost/Motor0.rtc is"),
        ("RTC:rtkit:example:Motor:1.0", "RTC:rtkit:example:Motor:2.0", "ID of component at"),
        ('"Motor?', '"Motor?x&amp;', "Motor0: rtkit.create: option 'x' is not KEY=VALUE"),
    ],
)
def test_a_profile_that_cannot_live_leaves_nothing(
    manager: Any, old: str, new: str, why: str
) -> None:
    with open(FILE, encoding="utf-8") as stream:
        text = stream.read()
    assert old in text
    (manager.folder / "bad.xml").write_text(text.replace(old, new))
    outcome = manager.run("rtresurrect bad.xml")
    assert (outcome.status, outcome.out) == (1, "")
    assert len(outcome.err.splitlines()) == 1
    assert why in outcome.err
    assert list(listing(manager)) == ["manager.mgr"]
    assert manager.ok("rtls -1 /localhost/manager.mgr") == ""


def test_ctrl_c_leaves_nothing(manager: Any) -> None:
    (manager.modules / "Slow.py").write_text(SLOW)
    with open(FILE, encoding="utf-8") as stream:
        text = stream.read().replace('"Motor?', '"Slow?')
    (manager.folder / "slow.xml").write_text(text)
    begun = manager.folder / "state" / "begun"
    os.mkfifo(begun)
    command = manager.open("rtresurrect slow.xml")
    with open(begun, "rb") as stream:
        assert stream.read(1) == b"x"
    command.send_signal(signal.SIGINT)
    out, err = command.communicate(timeout=20)
    assert (command.returncode, out) == (-signal.SIGINT, "")
    assert err == "rtresurrect: interrupted; removed again: Controller0, Motor0, Sensor0\n"
    assert manager.ok("rtls -1 /localhost/manager.mgr") == ""


def test_a_stopped_slave_is_told_not_waited_for_in_silence(manager: Any) -> None:
    up(manager)
    pid = pids(manager)["Controller0"]
    os.kill(pid, signal.SIGSTOP)
    try:
        outcome = manager.run(f"rtstart --timeout 2 {FILE}")
        assert outcome.status == 1
        assert "Required action failed:" in outcome.err
        assert "active now: none" in outcome.err
    finally:
        os.kill(pid, signal.SIGCONT)
