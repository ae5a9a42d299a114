"""rtplan and rtapply on real processes: up, changed, moved, killed, back."""

from __future__ import annotations

import json
import os
import re
import signal
from pathlib import Path
from typing import Any

from waiting import told_pid

from rtkit.resources import resource

FILE = resource("profiles", "systems", "sensor-controller-motor.xml")


def steps(shell: Any, file: str) -> list[str]:
    return [step["text"] for step in json.loads(shell.ok(f"rtplan --json {file}"))["steps"]]


def test_a_robot_is_brought_up_changed_moved_repaired_and_left_alone(manager: Any) -> None:
    shell = manager
    assert shell.run(f"rtplan --detailed-exitcode {FILE}").status == 2
    done = shell.run(f"rtapply {FILE}")
    assert (done.status, done.out) == (0, "")
    assert "activate Motor0" in done.err
    assert shell.run(f"rtcheck {FILE}") == (0, "", "")
    assert shell.ok(f"rtplan --detailed-exitcode {FILE}").startswith("nothing to do")
    assert shell.run(f"rtapply {FILE}") == (0, "", "")

    # A parameter that differs stops its component, and no other.
    shell.ok("rtconf /localhost/Controller0.rtc set gain 7")
    pids = {name: told_pid(shell, name) for name in ("sensor", "controller", "motor")}
    changed = ["deactivate Controller0", "set Controller0.gain=1.0", "activate Controller0"]
    assert steps(shell, FILE) == changed
    assert shell.run(f"rtapply {FILE}").status == 0
    assert "gain           1.0" in shell.ok("rtconf /localhost/Controller0.rtc list -l")

    # A plan that was saved is carried out as it is, once.
    shell.ok("rtconf /localhost/Controller0.rtc set gain 7")
    shell.ok(f"rtplan --out p {FILE}")
    assert shell.run("rtapply p").status == 0
    assert "Controller0.gain=1.0 (was 7" in shell.run("rtapply p").err

    # What is killed is made again, with its connections; the others run on.
    os.kill(pids["motor"], signal.SIGKILL)
    while not any(step.startswith("create Motor0") for step in steps(shell, FILE)):
        pass
    assert shell.run(f"rtapply {FILE}").status == 0
    assert shell.run(f"rtcheck {FILE}") == (0, "", "")
    assert told_pid(shell, "sensor") == pids["sensor"]
    assert told_pid(shell, "controller") == pids["controller"]

    # One that is to be elsewhere is made anew there.
    moved = shell.folder / "moved.xml"
    text = Path(FILE).read_text()
    moved.write_text(re.sub(r"manager_name=motor\b", "manager_name=wheels", text))
    assert "create Motor0 on manager in slave wheels" in steps(shell, str(moved))
    assert shell.run(f"rtapply {moved}").status == 0
    assert steps(shell, str(moved)) == []
    assert told_pid(shell, "sensor") == pids["sensor"]
    assert told_pid(shell, "wheels") != pids["motor"]


def test_a_killed_apply_is_run_again_and_finishes(manager: Any) -> None:
    shell = manager
    running = shell.open(f"rtapply --parallel 1 {FILE}")
    assert "[1/" in running.stderr.readline()
    # While it lives, nobody else applies anything; killed, it is in nobody's way.
    running.send_signal(signal.SIGSTOP)
    told = rf"rtapply: manager 'manager' is in use by rtapply {FILE} \(\S+, pid {running.pid} on "
    busy = (
        f"rtapply --wait 0.1 {FILE}",
        f"rtteardown --wait 0.1 {FILE}",
        f"rtstate --goto run {FILE}",
    )
    for command in busy:
        refused = shell.run(command)
        assert refused.status == 1
        assert re.search(told.replace("rtapply", command.split()[0], 1), refused.err)
    waiting = shell.open(f"rtresurrect --wait 30 {FILE}")
    assert waiting.stderr.readline().startswith("waits: manager 'manager' is in use by rtapply ")
    running.send_signal(signal.SIGKILL)
    running.communicate(timeout=30)
    assert shell.end_of(waiting).status == 0
    assert shell.run(f"rtapply {FILE}").status == 0
    assert shell.run(f"rtcheck {FILE}") == (0, "", "")


BROKEN = """
from rtkit.component import Component


class Broken(Component):
    def on_initialize(self):
        raise RuntimeError("no wheels")


def BrokenInit(manager):
    manager.register_factory(Broken)
"""


def test_what_is_not_found_is_told_beforehand_and_what_fails_is_taken_back(manager: Any) -> None:
    shell = manager
    bad = shell.folder / "bad.xml"
    bad.write_text(re.sub(r"Motor\?", "Moto?", Path(FILE).read_text()))
    failed = shell.run(f"rtapply --exit-detail {bad}")
    assert (failed.status, failed.out) == (7, "")
    assert "Motor0.rtc: component type Moto is not known (looked in" in failed.err
    assert "(did you mean Motor?)" in failed.err
    assert shell.ok("rtls -1 /localhost").split() == ["manager.mgr/"]

    (shell.modules / "Broken.py").write_text(BROKEN)
    bad.write_text(re.sub(r"Motor\?", "Broken?", Path(FILE).read_text()))
    failed = shell.run(f"rtapply --rollback --parallel 1 {bad}")
    assert failed.status == 1
    assert "no wheels" in failed.err
    assert "way back: " in failed.err
    assert failed.err.endswith("; everything is as it was before\n")
    assert shell.ok("rtls -1 /localhost").split() == ["manager.mgr/"]

    # What the steps took that were done is noted, and counts when there is enough of it.
    times = Path(shell.environment["RTKIT_STATE_DIR"], "step-times.json")
    means = json.loads(times.read_text())["means"]
    assert means["create_slave Controller"][0] == 1
    means["create_slave"][0] = means["delete"][0] = 20
    times.write_text(json.dumps({"version": 1, "means": means}))
    assert "measured: create_slave\n" in shell.ok(f"rtplan {FILE}")
