"""Logs of another host, whose clock is 30 s ahead and drifts by 100 ppm, merged with those here."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

import clockkit
import jsonrecords
import pytest
from clockkit import WallClock
from forked import Commands
from robotkit import AT, BOUND_S, Robot
from shells import opened_shell
from waiting import until

from rtkit.keys.authority import issue, revoke

AHEAD_S, PPM, TIMES = 30, 100, 4
ECHO = '''
from rtkit.component import Component


class Echo(Component):
    """Say how often it was activated, and a password."""

    times = 0

    def on_activated(self, context):
        self.times += 1
        self.logger.info("%s %d password=hunter2", self.instance, self.times)


def EchoInit(manager):
    manager.register_factory(Echo)
'''

pytestmark = pytest.mark.skipif(bool(clockkit.missing()), reason=clockkit.missing())


@pytest.fixture(scope="module")
def robot(commands: Commands) -> Iterator[Robot]:
    """A robot whose clock is wrong, and a manager here, each with a component."""
    with opened_shell(commands) as shell:
        (shell.modules / "Echo.py").write_text(ECHO)
        robot = Robot(shell)
        robot.clock = WallClock(shell, robot.more)
        robot.clock.drift(AHEAD_S, PPM)
        assert robot.there(f"rtmgr start -a --tls {AT}:0") == (0, "", "")
        robot.port = robot.port_of("manager")
        shell.ok("rtmgr start")
        assert robot.there("rtmgr -c 'Echo?instance_name=Far' /localhost/manager.mgr").err == ""
        shell.ok("rtmgr -c 'Echo?instance_name=Near' /localhost/manager.mgr")
        yield robot
        assert robot.there("rtmgr stop") == (0, "", "")
        shell.ok("rtmgr stop")


def _cause_and_effect(robot: Robot) -> None:
    """Have something happen here, then there because of it, and so on."""
    for _ in range(TIMES):
        for path in ("/localhost/Near.rtc", "AT/Far.rtc"):
            assert robot.by("owner1", f"rtact {path}").err == ""
        for path in ("/localhost/Near.rtc", "AT/Far.rtc"):
            assert robot.by("owner1", f"rtdeact {path}").err == ""


def _order(lines: list[str]) -> list[str]:
    """Return what was said in its order, where the times and bounds of the records fit."""
    said = []
    for line in lines:
        record = json.loads(line)
        if record["source"] in ("Near", "Far"):
            said.append(" ".join(record["message"].split()[:2]))
    return said


def test_causes_come_before_their_effects_whatever_the_clocks_say(robot: Robot) -> None:
    with robot.keys_of("owner1"):
        follow = robot.shell.open(f"rtvlog --json -v -n 0 /localhost {robot.path}/Far.rtc")
    assert follow.stderr is not None
    assert f"clock of {robot.path[1:]}: +30." in follow.stderr.readline()
    assert "following" in follow.stderr.readline()
    _cause_and_effect(robot)
    wanted = [f"{who} {time}" for time in range(1, TIMES + 1) for who in ("Near", "Far")]
    done = robot.by("owner1", "rtvlog --json --no-follow /localhost AT/")
    assert done.status == 0
    assert _order(done.out.splitlines()) == wanted
    assert "clock of" in done.err
    jsonrecords.checked(done.out)
    for line in done.out.splitlines():
        record = json.loads(line)
        if record["host"] == "localhost":
            assert (record["offset_s"], record["bound_s"]) == (0, 0)
            continue
        # What the clock there showed says when it was: the time told is wrong by no more than told.
        told_s = datetime.fromisoformat(f"{record['time'][:-4]}Z").timestamp()
        right_s = robot.clock.right(told_s + record["offset_s"])
        assert abs(told_s - right_s) <= record["bound_s"] + 1e-6, record
    assert follow.stdout is not None
    lines: list[str] = []
    while f"Far {TIMES}" not in "".join(lines[-1:]):
        lines.append(follow.stdout.readline())
    assert _order(lines) == wanted
    follow.send_signal(signal.SIGINT)
    follow.communicate(timeout=BOUND_S)


def test_time_stamps_say_whose_clock_they_are(robot: Robot) -> None:
    assert robot.by("owner1", "rtmgr -c ConsoleIn AT/manager.mgr").err == ""
    assert robot.by("owner1", "rtact AT/ConsoleIn0.rtc").err == ""
    shown = robot.by("anna", "rtprint --json -n 3 AT/ConsoleIn0.rtc:out").out.splitlines()
    for record in map(json.loads, shown):
        clock, tm = record["clock"], record["value"]["tm"]
        assert clock["host"] == "robot1"
        stamp_s = tm["sec"] + tm["nsec"] * 1e-9
        right_s = robot.clock.right(stamp_s)
        assert abs(stamp_s - clock["offset_s"] - right_s) <= clock["bound_s"] + 1e-3
        received_s = datetime.fromisoformat(f"{record['received'][:-4]}Z").timestamp()
        assert -1.0 < received_s - right_s < BOUND_S  # by the clock here
    told = robot.by("anna", "rtprint -n 1 AT/ConsoleIn0.rtc:out").err
    assert told.startswith("rtprint: clock of robot1: +30.0")
    assert told.endswith(", not taken off its time stamps\n")
    stats = robot.by("anna", "rtprint --stats -n 3 AT/ConsoleIn0.rtc:out").out
    assert "clock     of robot1, +30.0" in stats
    assert robot.by("anna", "rtlog -f run.mcap -t 1 AT/ConsoleIn0.rtc:out").status == 0
    info = json.loads(robot.by("anna", "rtlog --info --json -f run.mcap").out)
    (channel,) = info["channels"]
    assert (channel["clock"], round(channel["offset_s"])) == ("robot1", AHEAD_S)
    began_s, first_s = (
        datetime.fromisoformat(f"{info[name][:-4]}Z").timestamp() for name in ("began", "first")
    )
    assert -1.0 < first_s - began_s < BOUND_S


def test_secrets_in_logs_are_for_administrators(robot: Robot) -> None:
    assert robot.by("owner1", "rtact AT/Far.rtc").err == ""
    assert robot.by("owner1", "rtdeact AT/Far.rtc").err == ""
    assert "hunter2" in robot.by("owner1", "rtvlog --no-follow AT/Far.rtc").out
    shown = robot.by("anna", "rtvlog --no-follow AT/Far.rtc").out
    assert "password=(hidden)" in shown
    assert "hunter2" not in shown


def test_a_manager_shows_its_own_logs_only(robot: Robot) -> None:
    (robot.shell.folder / "robot.state/other.log").write_text(
        '{"time": "2026-01-01T00:00:00.000000Z", "level": "INFO", "process": "other", "pid": 1,'
        ' "logger": "rtkit", "message": "not yours"}\n'
    )
    assert "not yours" not in robot.by("owner1", "rtvlog --no-follow AT/").out
    with robot.at_home():
        assert "not yours" in robot.shell.ok("rtvlog --no-follow /localhost")


@pytest.mark.parametrize(
    "text", ["{}", "[", '{"level": 1}', "[" * 9000, '{"level":"NO","sources":[],"text":null,'
    '"since_s":1e999,"about":[["a",1,[]]],"most":1,"mark":""}']
)  # fmt: skip
def test_odd_questions_for_logs_are_refused(robot: Robot, text: str) -> None:
    with robot.connected("anna") as client:
        assert client.ask("%40x%2Flogs", text).error == "malformed"


def test_whoever_follows_goes_on_when_the_port_is_back_and_misses_nothing(robot: Robot) -> None:
    assert robot.there("rtmgr -c 'Echo?instance_name=Gap' /localhost/manager.mgr").err == ""
    with robot.keys_of("anna"):
        follow = robot.shell.open(f"rtvlog -v --json {robot.path}/Gap.rtc")
    assert follow.stderr is not None
    assert follow.stdout is not None
    until(lambda: "following" in follow.stderr.readline(), "it follows")
    for number in range(1, 9):
        if number in (3, 6):
            os.kill(robot.gateway(), signal.SIGKILL)
        assert robot.there("rtact /localhost/Gap.rtc").err == ""
        assert robot.there("rtdeact /localhost/Gap.rtc").err == ""
        if number in (5, 8):
            until(lambda: "is back" in follow.stderr.readline(), "it is told of the return")
    heard: list[str] = []
    while "Gap 8" not in heard:
        record = json.loads(follow.stdout.readline())
        heard += [" ".join(record["message"].split()[:2])] * (record["source"] == "Gap")
    assert heard == [f"Gap {number}" for number in range(1, 9)]
    follow.send_signal(signal.SIGINT)
    follow.communicate(timeout=BOUND_S)
    assert robot.there("rtmgr -d Gap /localhost/manager.mgr").err == ""


def test_whoever_is_let_in_no_longer_follows_no_longer(robot: Robot) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", robot.keys)
        issue("zoe", "viewer", [], 30, f"{robot.keys}.zoe")
        with robot.keys_of("zoe"):
            follow = robot.shell.open(f"rtvlog -v {robot.path}/")
        assert follow.stderr is not None
        until(lambda: "following" in follow.stderr.readline(), "it follows")
        revoke("zoe")
    told = Path(robot.keys, "revoked.crl").read_bytes()
    Path(f"{robot.keys}.robot1", "revoked.crl").write_bytes(told)
    _, said = follow.communicate(timeout=BOUND_S)
    assert follow.returncode == 1
    assert "the certificate of zoe is revoked" in said
