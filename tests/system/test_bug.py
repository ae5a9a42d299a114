"""Bug navigation deployed: rtbug, and the commands that it is made of, all in slaves."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import signal
import time
from pathlib import Path
from typing import Any

import jsonrecords
import pytest
from bug.assembly import variants
from bug.environments import shipped
from bug.records import Row, trajectory_csv
from bug.simulation import simulate
from shells import ROOT, Shell
from terminal import opened

FOLDER = ROOT / "examples" / "bug"
WORLDS = ("one-box", "closed")
NAMES = ("bug2", "alg2", "distbug")
ONE = "rtbug run --world one-box --variant bug2 --sensors laser"


def _pure(world: str, variant: str, sensors: str, **more: Any) -> str:
    """Return the trajectory of the same run without processes."""
    run = simulate(shipped()[world], variants()[variant], sensors, **more)
    return trajectory_csv(Row(*row) for row in run.rows)


def _files(folder: Path) -> dict[str, bytes]:
    """Return the files below a folder, but for the PNGs that an installed renderer adds."""
    files = (each for each in folder.rglob("*") if each.is_file() and each.suffix != ".png")
    return {str(each.relative_to(folder)): each.read_bytes() for each in files}


@pytest.mark.timeout(240)
def test_a_dozen_deployments_are_right_and_as_without_processes(shell: Shell) -> None:
    """Each through its plan, every component in a slave: the same rows as in one process."""
    named = " ".join([*(f"--world {w}" for w in WORLDS), *(f"--variant {v}" for v in NAMES)])
    line = f"rtbug run {named} --sensors laser --sensors ir --out runs --json -v"
    outcome = shell.end_of(shell.open(line), 200.0)
    assert outcome.status == 0, outcome.err + shell.log()
    found = {
        (r["environment"], r["variant"], r["sensors"]): r for r in jsonrecords.checked(outcome.out)
    }
    assert len(found) == 12
    for (world, variant, sensors), record in found.items():
        folder = shell.folder / "runs" / world / f"{variant}-{sensors}-left"
        assert json.loads((folder / "result.json").read_text()) == record
        assert (folder / "trajectory.csv").read_text() == _pure(world, variant, sensors)
        assert (folder / "trajectory.svg").read_text().startswith("<svg")
        assert record["status"] == ("unreachable" if world == "closed" else "reached")
        assert record["collisions"] == 0
    table = list(csv.reader(io.StringIO((shell.folder / "runs" / "table.csv").read_text())))
    assert len(table) == 13
    assert table[1:] == sorted(table[1:])
    assert {p.name for p in (shell.folder / "runs").glob("*.svg")} == {f"{w}.svg" for w in WORLDS}
    # Another variant is set while it is inactive; other sensors are another adaptor.
    variant_change = outcome.err.partition("one-box/alg2-laser-left: ")[2].splitlines()
    assert variant_change[0].startswith("10 steps: deactivate 3, set 4, activate 3")
    assert "set BugNavigator0.variant=alg2" in outcome.err
    assert "delete LaserAdaptor0" in outcome.err
    assert "create IrAdaptor0" in outcome.err
    assert outcome.err.count("] create ") == 6


@pytest.mark.timeout(120)
def test_the_same_seed_gives_the_same_bytes_at_any_speed(shell: Shell) -> None:
    mine = {
        "mine": {"motion": "m-line", "leave": "m-line"}
    }  # what bug2 is, under a name of its own
    (shell.folder / "mine.json").write_text(json.dumps(mine))
    one = "rtbug run --world one-box --variants mine.json --variant mine --sensors laser"
    for out, speed in (("a", ""), ("b", "--speedup 100")):
        line = f"{one} --seed 3 --noise 0.01 {speed} --out {out}"
        assert shell.end_of(shell.open(line), 60.0).status == 0
    first, second = _files(shell.folder / "a"), _files(shell.folder / "b")
    assert first == second
    assert len(first) == 6
    (rows,) = (
        text.decode() for name, text in first.items() if name.endswith(".csv") and "left" in name
    )
    assert rows.startswith("t,x,y,theta,mode,odom_x,odom_y,odom_theta\n")
    assert rows != _pure("one-box", "bug2", "laser")
    pure = _pure("one-box", "bug2", "laser", seed=3, noise=0.01).splitlines()
    assert [line.rsplit(",", 3)[0] for line in rows.splitlines()] == pure


@pytest.mark.timeout(120)
def test_a_slave_that_is_killed_in_mid_run_costs_that_run_only(shell: Shell) -> None:
    process = shell.open(f"{ONE} --speedup 15 --out runs -v")
    environment = {**shell.environment, "RTKIT_MANAGER": "bug"}
    shell.environment = environment
    _until(lambda: "active" in shell.run("rtwait -t 1 /localhost/WorldSim0.rtc active").out.lower()
           or shell.run("rtwait -t 1 /localhost/WorldSim0.rtc active").status == 0)  # fmt: skip
    page = shell.run("rtcat /localhost/bug.mgr/bugnavigator.mgr").out
    os.kill(int(re.search(r"Process ID\D*(\d+)", page)[1]), signal.SIGKILL)  # type: ignore[index]
    outcome = shell.end_of(process, 100.0)
    assert outcome.status == 0, outcome.err
    assert "BugNavigator0 has ended (signal 9); the run begins again" in outcome.err
    folder = shell.folder / "runs" / "one-box" / "bug2-laser-left"
    assert (folder / "trajectory.csv").read_text() == _pure("one-box", "bug2", "laser")


def _until(is_so: Any, within_s: float = 30.0) -> None:
    until = time.monotonic() + within_s
    while not is_so():
        assert time.monotonic() < until


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
@pytest.mark.timeout(120)
def test_who_is_ended_leaves_nothing_half_done(shell: Shell, number: signal.Signals) -> None:
    process = shell.open(f"{ONE} --speedup 1 --out runs")
    shell.environment = {**shell.environment, "RTKIT_MANAGER": "bug"}
    _until(lambda: shell.run("rtwait -t 1 /localhost/WorldSim0.rtc active").status == 0)
    process.send_signal(number)
    outcome = shell.end_of(process, 60.0)
    assert outcome.status == -number
    assert "Traceback" not in outcome.err
    assert _files(shell.folder / "runs") == {}
    _until(lambda: not list((shell.folder / "run").glob("*.sock")))


@pytest.mark.timeout(120)
def test_a_run_is_drawn_live_and_ctrl_c_ends_it(shell: Shell) -> None:
    line = shell.command("rtbug run --world visited --variant rev1 --sensors laser --watch")
    environment = {**shell.environment, "TERM": "xterm"}
    with opened(line, environment, shell.folder) as terminal:
        terminal.until(r"\x1b\[Hvisited/rev1-laser-left: [0-9.]+ s, going to the goal")
        terminal.until("[\u2801-\u28ff]{5}")
        terminal.until("H1")
        terminal.type("\x03")
        assert "Traceback" not in terminal.rest()
        assert terminal.status() == -signal.SIGINT
    assert not list((shell.folder / "run").glob("*.sock"))


@pytest.mark.timeout(120)
def test_two_of_them_do_not_meet(shell: Shell) -> None:
    """The second one takes another manager, and a prefix for all names."""
    first = shell.open(f"{ONE} --speedup 10 --json")
    shell.environment = {**shell.environment, "RTKIT_MANAGER": "bug"}
    _until(lambda: shell.run("rtwait -t 1 /localhost/WorldSim0.rtc active").status == 0)
    second = shell.end_of(shell.open(f"{ONE} --json"), 60.0)
    assert shell.run("rtget bug2/MobileRobot0.status").status == 1
    outcome = shell.end_of(first, 60.0)
    assert (outcome.status, second.status) == (0, 0), outcome.err + second.err
    assert outcome.out == second.out


@pytest.mark.timeout(120)
def test_it_runs_beside_a_system_of_the_user(shell: Shell) -> None:
    shell.environment = {**shell.environment, "RTKIT_MODULE_PATH": str(FOLDER)}
    shell.ok("rtmgr start")
    assert shell.run(f"rtapply {FOLDER / 'system.yaml'}").status == 0
    assert shell.run(f"{ONE} -q", timeout_s=60.0) == (0, "", "")
    assert _status(shell) == "reached"
    shell.ok("rtmgr stop")


@pytest.mark.timeout(120)
def test_the_plain_commands_do_the_same(shell: Shell) -> None:
    """What rtbug does, by hand, and in one process instead of five."""
    (shell.folder / "rtc.conf").write_text("")
    shell.environment = {**shell.environment, "RTKIT_MODULE_PATH": str(FOLDER)}
    shell.ok("rtmgr start")
    system = FOLDER / "system.yaml"
    assert shell.run(f"rtapply {system} --set variant=alg1 --set world=visited").status == 0
    assert _status(shell) == "reached"
    assert _rows(shell) == _pure("visited", "alg1", "laser")
    wrong = shell.run("rtconf /localhost/BugNavigator0.rtc set variant bug9")
    assert (wrong.status, wrong.out) == (1, "")
    assert re.match(r"rtconf: variant cannot be 'bug9': it is one of bug1, [^\n]*\n$", wrong.err)
    shell.environment["RTKIT_PROFILE_PATH"] = str(FOLDER)
    for assembly, why in (
        ('{"leave": "m-line"}', "leave and motion are both m-line or neither"),
        ('{"by": "free range"}', "by free range needs a gain above 0 m"),
    ):
        (shell.folder / "values.yaml").write_text(json.dumps({"variant": assembly}))
        checked = shell.run(f"rtprofile check {system} --values values.yaml")
        assert checked.status == 1
        assert checked.out.count(why) == 1
        refused = shell.run(f"rtapply {system} --values values.yaml")
        assert refused.status == 1
        assert refused.err.count(why) == 1
        assert refused.err.count("\n") == 1
    text = shell.run("rtget MobileRobot0.hits MobileRobot0.goal MobileRobot0.state").out
    assert text.count("\n") == 3
    assert "(0.0 5.0)" in text
    assert shell.run("rtget MobileRobot0.path").out.count("(") > 50
    together = system.read_text().replace("manager_name=", "manager_name=all&was=")
    (shell.folder / "together.yaml").write_text(together)
    assert shell.run(f"rtteardown --exit {system}").status == 0
    assert shell.run("rtapply together.yaml --set variant=alg1 --set speedup=200").status == 0
    assert _status(shell) == "reached"
    assert _rows(shell) == _pure("one-box", "alg1", "laser")


def _status(shell: Shell) -> str:
    _until(lambda: '""' not in shell.run("rtget MobileRobot0.status").out)
    return shell.run("rtget MobileRobot0.status").out.strip().strip('"')


def _rows(shell: Shell) -> str:
    """Return the trajectory that a service port tells."""
    answer = shell.ok("rtcall --json /localhost/MobileRobot0.rtc:record.rows 0 10000")
    rows = json.loads(answer)["result"]
    return trajectory_csv(Row(*(row[k] for k in ("t", "x", "y", "theta", "mode"))) for row in rows)
