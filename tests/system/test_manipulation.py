"""The supervised manipulator in slaves of its own, talked to by live properties alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from xml.etree import ElementTree

import pytest
from shells import ROOT, Shell

FOLDER = ROOT / "examples" / "manipulation"
PATIENCE_S = 40.0
pytestmark = pytest.mark.timeout(150)  # dozens of commands each, on a busy machine


@pytest.fixture
def bring_up(shell: Shell) -> Callable[..., Shell]:
    """Bring the system up at a site, quick enough for a test."""

    def bring(**values: object) -> Shell:
        shell.environment["RTKIT_MODULE_PATH"] += f"{os.pathsep}{FOLDER}"
        shell.ok("rtmgr start")
        sets = " ".join(f"--set {key}={value}" for key, value in {"speed": 5, **values}.items())
        done = shell.run(f"rtapply {sets} {FOLDER / 'system.yaml'}")
        assert done.status == 0, done.err
        return shell

    return bring


def say(shell: Shell, sentence: str) -> str:
    shell.ok(f'rtset table.command "{sentence}"')
    return shell.ok("rtget table.said").strip()


def until(shell: Shell, name: str, wanted: str) -> None:
    """Wait for a property to have a value."""
    with shell.open(f"rtlisten -t {PATIENCE_S} table.{name}") as listening:
        assert listening.stdout is not None
        assert any(wanted in line for line in listening.stdout), f"never {wanted}"
        listening.terminate()


def operator(shell: Shell, *command: str) -> str:
    """Run a committed operator with the commands of this interpreter."""
    bin = os.path.dirname(sys.executable)
    path = f"{bin}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        command,
        env={**shell.environment, "PATH": path},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_an_operator_has_the_doorway_cleared(bring_up: Callable[..., Shell]) -> None:
    shell = bring_up(site="doorway", seed=2)
    told = operator(shell, "sh", str(FOLDER / "operators" / "doorway.sh")).splitlines()
    assert told[-1] == "take A to (9 3): done, cost 39"
    assert "a and b tie at 39" in told[5]
    assert shell.ok("rtget table.site.things").startswith('(("A" (9 3)')
    assert shell.ok("rtget table.evaluations").strip() == "33"
    late = shell.run("rtset table.questions.q1 aside")
    assert (late.status, "unknown" in late.err) == (1, True)


def test_an_operator_in_python_switches_and_a_kill_changes_nothing(
    bring_up: Callable[..., Shell],
) -> None:
    shell = bring_up(site="switch")
    script = str(FOLDER / "operators" / "switch.py")
    told = operator(shell, sys.executable, script).splitlines()
    assert "a and b and c and d tie at 31" in told[0]
    assert told[-1] == "switch A B X Y: done, cost 31"
    shell.ok("rtconf /localhost/Manipulator0.rtc set speed 0.5")
    assert "switch B A X Y" in say(shell, "switch B A X Y")
    question = shell.ok("rtget table.questions.open").split()[0].strip("(")
    offered = shell.ok(f"rtget table.questions.{question}.details").split()
    shell.ok(f"rtset table.questions.{question} a")
    until(shell, "holding", "B")
    found = shell.ok("rtcat /localhost/manager.mgr/supervisor.mgr")
    pid = next(line.split()[-1] for line in found.splitlines() if "Process ID" in line)
    os.kill(int(pid), signal.SIGKILL)
    shell.ok("rtwait -t 20 /localhost/Supervisor0.rtc active")
    shell.ok("rtconf /localhost/Manipulator0.rtc set speed 5")
    until(shell, "state", "idle")
    said = shell.ok("rtget table.said").strip()
    assert said == f"switch B A X Y: done, cost {offered[2]}"
    assert "switch" in shell.ok("rtget table.definitions")
    rows = shell.ok("rtget table.results")
    assert rows.count('"done"') == 2


def test_what_is_felt_is_named_and_what_is_wrong_is_told(bring_up: Callable[..., Shell]) -> None:
    shell = bring_up(site="corridor")
    say(shell, "go to (9 2)")
    until(shell, "state", "stopped")
    assert shell.ok("rtget table.site.unknown").strip() == '("unknown1")'
    assert shell.ok("rtget table.said").strip() == "stopped: something is at (6 2); its name?"
    shell.ok("rtset table.questions.q1 box")
    until(shell, "state", "idle")
    assert shell.ok("rtget table.said").strip() == "go to (9 2): done, cost 18"
    for name, value, why in (
        ("command", "tak box to (1 1)", "did you mean take?"),
        ("command", "define swing = go to (1 1); swing", "cannot end: swing calls swing"),
        ("prices.move", "-1", "below 0"),
        ("prices.move", "0", "greater than 0"),
        ("state", "idle", "read-only"),
        ("questions.q1", "box", "unknown"),
    ):
        refused = shell.run(f'rtset -- table.{name} "{value}"')
        assert refused.status == 1
        assert why in refused.err
    say(shell, "designate object at (1 4) <A&B>")
    say(shell, "take <A&B> to (9 4)")
    for name in ("site", "explored", "way", "tree"):
        drawn = shell.ok(f"rtget --raw table.picture.{name}")
        assert ElementTree.fromstring(drawn).tag.endswith("svg")
