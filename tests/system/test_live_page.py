"""rttop on a terminal: what stands there, keys, sizes, and how it is left."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from page import Page
from terminal import Terminal, opened

MANAGER = "/localhost/manager.mgr"
LIVE = {1049}
CLEAN = {25}


@pytest.fixture
def system(manager: Any) -> Any:
    """A shell with an active source in a slave, and a sink."""
    manager.ok(f"rtmgr {MANAGER} -c ConsoleIn?manager_name=s -c ConsoleOut")
    manager.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    manager.ok("rtact /localhost/ConsoleIn0.rtc")
    return manager


@contextmanager
def top(system: Any, **more: str) -> Iterator[tuple[Terminal, Page]]:
    """Open what rttop shows on a terminal of 80 x 24."""
    environment = {**system.environment, "TERM": "xterm", **more}
    with opened(system.command("rttop"), environment, system.folder) as terminal:
        yield terminal, Page(terminal)


def kill(shell: Any, line: str) -> None:
    os.kill(json.loads(shell.ok(line))["pid"], signal.SIGKILL)


def test_what_happens_is_shown_and_keys_work(system: Any) -> None:
    with top(system) as (terminal, page):
        page.until(lambda lines: "ConsoleIn0" in lines[2] and "/10.0" in lines[2])
        assert page.lines[2].startswith(">ConsoleIn0.rtc")
        assert all(len(line) <= 80 for line in page.lines)
        terminal.type("d")
        page.row("ConsoleIn0.rtc is deactivated")
        page.until(lambda lines: "Inactive" in lines[2])
        terminal.type("\x1b[Ba")
        page.row(">ConsoleOut0.rtc")
        page.row("ConsoleOut0.rtc is activated")
        terminal.type("r")
        page.row("ConsoleOut0.rtc: precondition not met")
        terminal.type(">>")
        page.row("RATE/Hzv")
        terminal.type("h")
        page.row("deactivate it")
        terminal.type("h")
        page.row("RATE/Hzv")
        kill(system, f"rtcat --json {MANAGER}/s.mgr")
        page.row("signal 9")
        page.resize(60, 8)
        page.until(lambda lines: lines[-1].startswith("q quit") and "Console" in lines[3])
        assert all(len(line) <= 60 for line in page.lines)
        kill(system, "rtmgr status --json")
        page.row("was killed; waiting")
        system.ok("rtmgr start")
        page.row("is back")
        terminal.type("q")
        page.rest()
        assert (terminal.status(), page.modes) == (0, CLEAN)


def test_it_leaves_the_terminal_as_it_was(system: Any) -> None:
    with top(system) as (terminal, page):
        page.row("ConsoleIn0.rtc")
        assert page.modes == LIVE
        os.kill(terminal.pid, signal.SIGTERM)
        page.rest()
        assert (terminal.status(), page.modes) == (-signal.SIGTERM, CLEAN)
    with top(system, NO_COLOR="1") as (terminal, page):
        page.row("ConsoleIn0.rtc  Active")
        terminal.type("\x03")
        page.rest()
        assert (terminal.status(), page.modes) == (-signal.SIGINT, CLEAN)
        assert "rttop: interrupted" in page.said
        assert not re.search("\x1b\\[[1-9;]+m", page.said)


def test_it_is_stopped_and_goes_on(system: Any) -> None:
    environment = {**system.environment, "TERM": "xterm", "PS1": "READY> ", "HISTFILE": ""}
    line = shlex.join(system.command("rttop"))
    (system.folder / "top").write_text(f"exec {line}\n")
    argv = ["bash", "--norc", "--noprofile", "-i"]
    with opened(argv, environment, system.folder) as terminal:
        page = Page(terminal)
        page.row("READY> ")
        before = terminal.modes()
        terminal.type("sh top\n")
        page.until(lambda lines: page.modes == LIVE and "ConsoleIn0" in "".join(lines))
        terminal.type("\x1a")
        page.until(lambda lines: page.modes == CLEAN and "READY>" in "".join(lines))
        assert "Stopped" in page.said
        assert terminal.modes() == before
        terminal.type("fg\n")
        page.until(lambda lines: page.modes == LIVE and "ConsoleIn0" in "".join(lines))
        terminal.type("q")
        page.until(lambda _lines: page.modes == CLEAN)
        terminal.type("exit\n")
        page.rest()
        assert terminal.status() == 0
