"""Commands in a real terminal: columns, colours, progress, Ctrl-C, another size, a closed pipe."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest
from terminal import opened

ROOT = Path(__file__).parents[2]
SYSTEM = ROOT / "profiles" / "systems" / "sensor-controller-motor.xml"
MANAGER = "/localhost/manager.mgr"
GREEN = "\x1b[32m\x1b[1m"
BAR = re.compile("[━╸╺]")


def terminal(shell: Any, line: str, columns: int = 80, **variables: str) -> Any:
    environment = {**shell.environment, "TERM": "xterm-256color", **variables}
    return opened(shell.command(line), environment, shell.folder, columns)


@pytest.fixture
def twelve(manager: Any) -> Any:
    """A manager with twelve components, one of them active."""
    manager.ok(f"rtmgr {MANAGER} " + " ".join(["-c ConsoleIn"] * 12))
    manager.ok("rtact /localhost/ConsoleIn0.rtc")
    return manager


def seen(line: str, shell: Any, columns: int = 80, **variables: str) -> str:
    with terminal(shell, line, columns, **variables) as screen:
        text: str = screen.rest()
        assert screen.status() == 0
    return text


def test_how_it_looks(twelve: Any) -> None:
    wide, narrow = (seen("rtls /localhost", twelve, columns) for columns in (200, 30))
    assert len(wide.splitlines()) == 1 + len(wide) // 200
    assert len(narrow.splitlines()) > 6
    assert GREEN in seen("rtls -l /localhost", twelve)
    for variables in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        assert "\x1b" not in seen("rtls -l /localhost", twelve, **variables)
    assert "\x1b" not in twelve.ok("rtls -l /localhost")


def test_a_watch_follows_the_terminal_s_size_and_ends_at_ctrl_c(twelve: Any) -> None:
    with terminal(twelve, "rtls --watch=0.05 /localhost", 40) as screen:
        screen.until(r"ConsoleIn0\.rtc +ConsoleIn1\.rtc *\r\n")
        screen.resize(200)
        screen.until(r"ConsoleIn0\.rtc +(ConsoleIn\d+\.rtc +){5,}")
        screen.type("\x03")
        assert "Traceback" not in screen.rest()
        assert screen.status() == -signal.SIGINT


def test_progress_is_for_terminals(manager: Any) -> None:
    for line in (f"rtresurrect {SYSTEM}", f"rtstart {SYSTEM}"):
        with terminal(manager, line) as screen:
            told = screen.rest()
            assert screen.status() == 0
        assert BAR.search(told), line
        plain = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", told)
        assert plain.count("Executing") == (3 if "rtstart" in line else 0)
    again = manager.run(f"rtstop {SYSTEM}")
    assert not BAR.search(again.err)
    assert [text.split()[0] for text in again.err.splitlines()] == ["Executing"] * 3


def test_a_recording_tells_how_far_it_is(manager: Any) -> None:
    manager.ok(f"rtmgr {MANAGER} -c ConsoleIn?instance_name=In0")
    manager.ok("rtact /localhost/In0.rtc")
    line = "rtlog -f run.mcap -i -e 3 /localhost/In0.rtc:out"
    with terminal(manager, line) as screen:
        screen.until("Recording 3 entries")
        screen.until(BAR.pattern)
        assert screen.status() == 0
    assert manager.run(line.replace("run", "again")).err == "Recording 3 entries.\n"
    export = manager.command("rtlog --export csv -f run.mcap")
    environment = {**manager.environment, "TERM": "xterm-256color"}
    with opened(["sh", "-c", f"{shlex.join(export)} > out"], environment, manager.folder) as screen:
        screen.until(BAR.pattern)
        assert screen.status() == 0
    with opened(export, environment, manager.folder) as screen:
        assert not BAR.search(screen.rest()), "what is exported shows how far it is"


def test_ctrl_c_leaves_the_line_clean(manager: Any) -> None:
    manager.ok(f"rtmgr {MANAGER} -c ConsoleIn?instance_name=In0")
    with terminal(manager, "rtlog -f run.mcap /localhost/In0.rtc:out") as screen:
        screen.until(BAR.pattern)
        screen.type("\x03")
        told: str = screen.rest()
        assert screen.status() == -signal.SIGINT
    assert told.rstrip().endswith("rtlog: interrupted")
    assert "\x1b[?25h" in told, "the cursor is hidden"


def test_a_reader_that_leaves(twelve: Any) -> None:
    first, second = os.pipe()
    with subprocess.Popen(
        twelve.command("rtls -R /"), stdout=second, stderr=subprocess.PIPE, env=twelve.environment
    ) as process:
        os.close(first)
        os.close(second)
        assert process.stderr is not None
        assert process.stderr.read() == b""
        assert process.wait() == 141
