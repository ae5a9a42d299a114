"""A manager that follows the events of a system itself: whoever dies, it goes on."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import rts_text
from waiting import told_pid

from rtkit.resources import resource
from rtkit.tree.client import Tree
from rtkit.tree.plan_locks import PlanLocks

FILE = resource("profiles", "systems", "sensor-controller-motor.xml")
SYSTEM = "RTSystem:rtkit:sensor-controller-motor:1.0"
STATES = {
    "states": "standby, explore, degraded",
    "transitions": "standby -start-> explore; explore -motor_lost-> degraded;"
    " explore -hurry-> degraded; * -stop-> standby",
    "state.standby": "*=Inactive; Sensor0=Active",
    "state.degraded": "Motor0=Absent; Controller0=Inactive",
    "event.motor_lost": "lost Motor0",
    "event.hurry": "Controller0.configuration.default.max_speed > 5",
}


def robot(folder: Path, name: str = "robot.xml", **changed: str) -> Path:
    """Write the profile of a robot with states."""
    told = {**STATES, **{key.replace("__", "."): text for key, text in changed.items()}}
    file = folder / name
    file.write_text(rts_text.with_properties(Path(FILE).read_text(), told))
    return file


def done(shell: Any, line: str) -> None:
    """Have done what tells its steps on stderr."""
    ended = shell.run(line)
    assert ended.status == 0, ended


def followed(shell: Any, file: Path) -> Mapping[str, Any]:
    """Return what the manager tells of the system."""
    told = json.loads(shell.run(f"rtstate --json {file}").out)["followed"]
    assert isinstance(told, dict)
    return told


def watching(shell: Any) -> Any:
    """Watch what is told of systems."""
    watch = shell.open("rtwatch -v -f system_state /")
    while "listening" not in watch.stderr.readline():
        pass
    return watch


def event(watch: Any) -> str:
    """Return the next event that is told of a system."""
    return str(watch.stdout.readline().partition(f" {SYSTEM} ")[2].strip())


def line(follower: Any) -> str:
    """Return the next transition that rtstate tells."""
    return str(follower.stdout.readline().partition("] ")[2].strip())


def test_it_goes_on_when_the_shell_dies_and_when_the_manager_does(manager: Any, tree: Tree) -> None:
    shell = manager
    file = robot(shell.folder)
    done(shell, f"rtstate --goto explore {file}")
    follower = shell.open(f"rtstate --follow {file}")
    assert line(follower) == "explore (is so)"
    follower.kill()
    follower.wait(30)
    watch = watching(shell)
    os.kill(told_pid(shell, "motor"), signal.SIGKILL)
    assert event(watch) == "degraded (explore -motor_lost-> degraded)"
    told = shell.ok(f"rtstate {file}")
    assert "\nfollowed by its manager: explore -motor_lost-> degraded\n" in told
    done(shell, f"rtstate --goto explore {file}")
    assert event(watch) == "explore (degraded -by others-> explore)"
    # It is followed after a restart on command, too.
    done(shell, "rtmgr restart")
    os.kill(told_pid(shell, "motor"), signal.SIGKILL)
    assert event(watch) == "degraded (explore -motor_lost-> degraded)"
    done(shell, f"rtstate --goto explore {file}")
    assert event(watch) == "explore (degraded -by others-> explore)"
    # What was due when it died is made by the next one.
    with PlanLocks("rtapply other.xml", 0.0, lambda _: None) as locks:
        locks.take(tree)
        done(shell, "rtconf /localhost/Controller0.rtc set max_speed 9")
        assert event(watch).startswith("WAITS ")
        os.kill(told_pid(shell), signal.SIGKILL)
    done(shell, "rtmgr start")
    told = event(watch)
    while not told.startswith("degraded"):
        told = event(watch)
    assert told == "degraded (explore -hurry-> degraded)"
    watch.terminate()
    watch.wait(30)


def test_one_profile_of_a_name_is_followed_until_it_is_ended(manager: Any) -> None:
    shell = manager
    file = robot(shell.folder)
    other = robot(shell.folder, "other.xml", state__standby="*=Inactive")
    done(shell, f"rtapply {file}")
    follower = shell.open(f"rtstate --follow {file}")
    assert line(follower) == "explore (is so)"
    refused = shell.run(f"rtstate --follow {other}")
    assert refused.status == 1
    assert f"follows {SYSTEM} as another profile tells it ({file})" in refused.err
    again = shell.open(f"rtstate --follow {file}")
    assert line(again) == "explore (is so)"
    assert shell.run("rtstate --unfollow sensor-controller-motor").status == 0
    for each in (follower, again):
        assert each.wait(30) == 1
        assert each.stderr.read() == f"rtstate: {SYSTEM} is followed no more\n"
    assert json.loads(shell.ok("rtget --raw /localhost/manager.mgr.rtkit.follow")) == []
    os.kill(told_pid(shell, "motor"), signal.SIGKILL)
    assert "between states" in shell.run(f"rtstate {file}").out


def test_what_wants_it_is_followed_once_it_is_up_and_until_it_is_taken_down(manager: Any) -> None:
    shell = manager
    file = robot(shell.folder, follow="true")
    watch = watching(shell)
    done(shell, f"rtapply {file}")
    assert event(watch) == "FOLLOWED"
    assert event(watch) == "explore (explore (is so))"
    (told,) = json.loads(shell.ok("rtget --raw /localhost/manager.mgr.rtkit.follow"))
    assert (told["system"], told["state"], told["count"]) == (SYSTEM, "explore", 1)
    assert told["table"]["explore"]["motor_lost"] == "degraded"
    done(shell, f"rtteardown --exit {file}")
    assert event(watch) == "NOT_FOLLOWED"
    assert shell.ok("rtls /localhost").strip() == "manager.mgr/"
    done(shell, f"rtresurrect {file}")
    assert event(watch) == "FOLLOWED"
    watch.terminate()
    watch.wait(30)


def test_it_waits_for_commands_that_carry_plans_out(manager: Any, tree: Tree) -> None:
    shell = manager
    file = robot(shell.folder)
    done(shell, f"rtstate --goto explore {file}")
    follower = shell.open(f"rtstate --follow {file}")
    assert line(follower) == "explore (is so)"
    watch = watching(shell)
    with PlanLocks("rtapply other.xml", 0.0, lambda _: None) as locks:
        locks.take(tree)
        os.kill(told_pid(shell, "motor"), signal.SIGKILL)
        assert event(watch).startswith("WAITS (rtapply other.xml (")
        assert followed(shell, file)["waits_for"].startswith("rtapply other.xml (")
        assert followed(shell, file)["is_led"] is False
    assert line(follower) == "explore -motor_lost-> degraded"
    assert event(watch).startswith("degraded ")
    done(shell, f"rtstate --goto explore {file}")
    assert event(watch).startswith("explore ")
    # A manager that waits so ends all the same when it is to.
    with PlanLocks("rtapply other.xml", 0.0, lambda _: None) as locks:
        locks.take(tree)
        os.kill(told_pid(shell, "motor"), signal.SIGKILL)
        assert event(watch).startswith("WAITS ")
        done(shell, "rtmgr stop")
    for each in (watch, follower):
        each.terminate()
        each.wait(30)


def test_what_fails_ends_it_and_stays_visible(manager: Any) -> None:
    shell = manager
    file = robot(shell.folder, state__degraded="Motor0=Absent; Controller0.max_speed=rubbish")
    done(shell, f"rtstate --goto explore {file}")
    follower = shell.open(f"rtstate --follow {file}")
    assert line(follower) == "explore (is so)"
    watch = watching(shell)
    os.kill(told_pid(shell, "motor"), signal.SIGKILL)
    assert follower.wait(30) == 1
    err = follower.stderr.read()
    assert err.startswith("rtstate: explore -motor_lost-> degraded: ")
    assert "rubbish" in err
    assert event(watch).startswith("TRANSITION_FAILED (explore -motor_lost-> degraded: ")
    assert event(watch) == "NOT_FOLLOWED (that transition failed)"
    os.kill(told_pid(shell), signal.SIGKILL)
    done(shell, "rtmgr start")
    told = followed(shell, file)
    assert told["is_over"]
    assert "rubbish" in told["error"]
    watch.terminate()
    watch.wait(30)
