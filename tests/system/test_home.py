"""The home of standard services: one profile brings it up, whatever moves its robots."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from pagekit import ROOT
from waiting import until

RUNS_PROCESSES = True
DEMO = ROOT / "examples" / "home" / "demo.py"


def test_a_home_is_lit_photographed_and_known_by_whatever_robots(tmp_path: Path) -> None:
    given = ("r1=LeggedRobot", "r2=DifferentialRobot", "pace=4")  # the other way about by default
    words = [word for each in given for word in ("--set", each)]
    done = subprocess.run(
        [sys.executable, DEMO, tmp_path, *words], capture_output=True, text=True, timeout=55
    )
    assert done.returncode == 0, done.stderr
    assert {each.name for each in tmp_path.iterdir()} == {
        "ball.png", "butler.svg", "dark.png", "home.svg",
    }  # fmt: skip


def test_a_home_that_cannot_be_is_refused_in_a_sentence(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, DEMO, tmp_path / "out", "--set", "r1=Unicycle"],
        capture_output=True, text=True, timeout=55,
    )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.startswith("demo-home: impossible: r1 cannot be")
    assert "component type Unicycle is not known" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("ending", [signal.SIGTERM, signal.SIGKILL])
def test_a_home_that_is_ended_leaves_nothing(tmp_path: Path, ending: signal.Signals) -> None:
    with (
        tempfile.TemporaryDirectory() as short,  # paths of sockets are
        subprocess.Popen(
            [sys.executable, DEMO, tmp_path / "out"],
            env={**os.environ, "TMPDIR": short}, stdout=subprocess.PIPE, text=True,
        ) as demo,
    ):  # fmt: skip
        assert demo.stdout is not None
        assert demo.stdout.readline().startswith("deployed")
        (folder,) = Path(short).iterdir()
        demo.send_signal(ending)
        was_killed = ending == signal.SIGKILL
        assert demo.wait(20) == (-ending if was_killed else 128 + ending)
        if was_killed:
            until(lambda: not any(Path(short).iterdir()), "the folder is gone")
        assert not list(Path(short).iterdir())
        assert not [each for each in Path("/proc").glob("[0-9]*/environ") if _holds(each, folder)]


def _holds(environment: Path, folder: Path) -> bool:
    try:
        return f"={folder}/run".encode() in environment.read_bytes()
    except OSError:  # another user's, or it has ended
        return False
