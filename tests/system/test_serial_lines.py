"""Serial lines with the real commands, at both ends of a cable of terminal devices."""

from __future__ import annotations

import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from serialkit import Cable

EMBEDDED = Path(__file__).parents[2] / "examples" / "embedded"
MODULE = """
class Arm:
    def __init__(self):
        self.angle = 0.5
        self.name = "left"
"""


@pytest.fixture
def cable(shell: Any) -> Iterator[Cable]:
    (shell.folder / "arm.py").write_text(MODULE, encoding="utf-8")
    cable = Cable(str(shell.folder))
    yield cable
    cable.close()


def test_an_object_is_served_and_asked_over_a_serial_line(shell: Any, cable: Cable) -> None:
    serving = shell.open("rtserve arm:Arm arm --serial far --allow-set angle")
    assert serving.stdout.readline() == "/localhost/arm  serial:far\n"
    at = "--at serial:near"
    assert shell.ok(f"rtget {at} properties angle arm/name") == '(angle name)\n0.5\n"left"\n'
    assert shell.ok(f"rtset {at} angle -0.25") == ""
    assert shell.ok("rtget arm.angle") == "-0.25\n"
    listening = shell.open(f"rtlisten {at} -n 2 angle")
    assert listening.stdout.readline() == "-0.25\n"
    shell.ok("rtset arm.angle 3")
    assert listening.communicate(timeout=30) == ("3\n", "")
    assert listening.returncode == 0
    lost = shell.open(f"rtlisten {at} angle")
    assert lost.stdout.readline() == "3\n"
    cable.unplug(cable.near)
    assert lost.communicate(timeout=30)[1] == (
        "rtlisten: angle: no-service: the connection has ended: near is unplugged or closed\n"
    )
    cable.plug(cable.near)
    for line, status, told in (
        (f"rtset {at} name right", 1, "name: denied: SET by nobody: name"),
        (f"rtget {at} nope", 4, "nope: unknown: no such property: nope"),
        (
            "rtget --at serial:none angle",
            5,
            "angle: no-service: cannot open none: No such file or directory",
        ),
        ("rtget --at serial:arm.py angle", 1, "angle: conflict: not a serial line: arm.py"),
    ):
        outcome = shell.run(line.replace(" ", " --exit-detail ", 1))
        assert (outcome.status, outcome.out) == (status, ""), line
        assert outcome.err == f"{line.split()[0]}: {told}\n"
    serving.send_signal(signal.SIGTERM)
    assert serving.communicate(timeout=30)[1] == ("denied: SET name by ''\n")


@pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler")
def test_the_small_device_is_asked_as_its_readme_says(shell: Any) -> None:
    for path in (*EMBEDDED.glob("*.[ch]"), EMBEDDED / "Makefile"):
        shutil.copy(path, shell.folder)
    subprocess.run(["make", "-s"], cwd=shell.folder, check=True, timeout=60)
    line = [str(shell.folder / "device"), "--pty"]
    device = subprocess.Popen(line, stdout=subprocess.PIPE, text=True)
    try:
        assert device.stdout is not None
        _ask(shell, f"serial:{device.stdout.readline().strip()}")
    finally:
        device.kill()
        device.communicate()


def _ask(shell: Any, device: str) -> None:
    names = shell.ok(f"rtget {device}")
    assert names.startswith("(speed location colour mode ")
    assert shell.ok(f"rtset {device}/speed 0.5 --echo") == "0.5\n"
    assert shell.ok(f"rtget --at {device} speed arm") == "0.5\n(angle joint)\n"
    outcome = shell.run(f"rtset {device}/speed 2")
    assert (outcome.status, outcome.out) == (1, "")
    assert outcome.err == (f"rtset: {device}/speed: bad-value: of another type, or out of range\n")
    uptimes = shell.ok(f"rtlisten '{device}?check=1/uptime' -n 3").split()
    assert len(set(uptimes)) == 3
