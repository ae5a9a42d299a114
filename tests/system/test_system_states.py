"""rtstate on real processes: led to states, and following events when a process is killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import rts_text
from waiting import told_pid

from rtkit.resources import resource

FILE = resource("profiles", "systems", "sensor-controller-motor.xml")
STATES = {
    "states": "standby, explore, slow, degraded",
    "transitions": "standby -start-> explore; explore -driven-> slow;"
    " explore -motor_lost-> degraded; slow -motor_lost-> degraded; * -stop-> standby",
    "state.standby": "*=Inactive; Sensor0=Active",
    "state.slow": "Controller0.max_speed=0.1",
    "state.degraded": "Motor0=Absent; Controller0=Inactive",
    "event.motor_lost": "lost Motor0",
    "event.driven": "Motor0.ports.pose.count > 3",
}


def test_a_robot_is_led_from_state_to_state_and_follows_its_events(manager: Any) -> None:
    shell = manager
    robot = shell.folder / "robot.xml"
    robot.write_text(rts_text.with_properties(Path(FILE).read_text(), STATES))
    assert shell.run(f"rtstate {robot}").status == 1
    assert shell.run(f"rtstate --goto standby {robot}").status == 0
    assert "* standby   is so\n" in shell.ok(f"rtstate {robot}")
    sensor = told_pid(shell, "sensor")

    follower = shell.open(f"rtstate --follow -n 3 {robot}")

    def state() -> str:
        return str(follower.stdout.readline().partition("] ")[2].strip())

    assert state() == "standby (is so)"
    watch = shell.open(f"rtwatch -v -n 3 -f system_state --system {robot} /")
    assert watch.stderr.readline() == "listening\n"
    assert shell.run(f"rtstate --event start {robot}").status == 0
    assert state() == "standby -by others-> explore"
    # A property has a value.
    assert state() == "explore -driven-> slow"
    # A lost component.
    os.kill(told_pid(shell, "motor"), signal.SIGKILL)
    assert state() == "slow -motor_lost-> degraded"
    assert follower.wait(30) == 0
    assert follower.stderr.read() == ""
    assert watch.wait(30) == 0
    system = "RTSystem:rtkit:sensor-controller-motor:1.0"
    assert [line.partition("] ")[2] for line in watch.stdout.read().splitlines()] == [
        f"{system} state explore (was standby)",
        f"{system} state slow (was explore)",
        f"{system} state degraded (was slow)",
    ]
    assert "* degraded  is so\n" in shell.ok(f"rtstate {robot}")
    assert shell.run(f"rtstate --goto explore {robot}").status == 0
    assert told_pid(shell, "sensor") == sensor
