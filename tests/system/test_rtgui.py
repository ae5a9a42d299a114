"""rtgui in a real terminal, as it is installed: keys, the service that it is, how it ends."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Iterator
from typing import Any

import pytest
from terminal import Terminal, opened

KEEPS_MANAGER = True
LAMP = '''
from typing import Annotated
import rtkit


class Lamp:
    """A lamp of nothing."""

    level: Annotated[float, rtkit.Range(0, 1, 0.25)] = 0.5

    def __init__(self):
        self.bulb = {"watts": 40.0}
'''


WELL = """
from pathlib import Path
from time import sleep


class Well:
    lamp: bool = True

    def get_depth(self) -> float:
        while not Path("looked").exists():
            sleep(0.02)
        return 7.5
"""
_SEQUENCES = re.compile(
    r"\x1b(?:\[[0-9;?<>=$]*[A-Za-z]|[()][A-Z0-9]|[=>]|[P\]][^\x1b\x07]*(?:\x07|\x1b\\\\))"
)


class Screen:
    """What a program has written, without how: a line that changes is written anew."""

    def __init__(self, terminal: Terminal) -> None:
        self._terminal = terminal
        self._said = ""

    def until(self, pattern: str) -> None:
        """Wait until something stands there that did not before."""
        while not (found := re.search(pattern, plain := _SEQUENCES.sub("", self._said))):
            more = self._terminal.more(10.0)
            assert more, f"{pattern} was never seen, but {plain[-2000:]}"
            self._said += more
        self._said = plain[found.end() :]


@pytest.fixture
def lamp(shell: Any) -> Iterator[Any]:
    """A shell with a lamp that is served."""
    (shell.folder / "lamp.py").write_text(LAMP, encoding="utf-8")
    process = shell.open("rtserve lamp:Lamp home/lamp --port 0 --http 0")
    _, shell.address, shell.web = process.stdout.readline().split()
    yield shell
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=30) == ("", "")


def test_a_panel_in_a_terminal(lamp: Any) -> None:
    environment = {**lamp.environment, "TERM": "xterm-256color", "TEXTUAL_ANIMATIONS": "none"}
    line = lamp.command("rtgui home/lamp --as panel")
    with opened(line, environment, lamp.folder) as terminal:
        screen = Screen(terminal)
        screen.until("home/lamp  ● live  as panel")
        screen.until(r"level [^\n]*0.5\b")
        terminal.type("\x1b[C")
        screen.until(r"level [^\n]*0.75\b")
        assert lamp.ok("rtget panel.level panel.input panel.focus") == (
            '0.75\n("level" 0.75)\n"level"\n'
        )
        lamp.ok("rtset panel.level 0.25")
        assert lamp.ok("rtget home/lamp.level") == "0.25\n"
        screen.until(r"level [^\n]*0.25\b")
        lamp.ok("rtset home/lamp.bulb.watts 60")
        screen.until(r"watts [^\n]*60\b")
        terminal.type("q")
        assert terminal.status() == 0
    assert lamp.run("rtget panel.level").err.startswith("rtget: panel.level: no-service: ")


@pytest.mark.parametrize("ending", [signal.SIGHUP, signal.SIGTERM])
def test_a_panel_that_is_ended_leaves_no_service(lamp: Any, ending: signal.Signals) -> None:
    environment = {**lamp.environment, "TERM": "xterm-256color"}
    line = lamp.command("rtgui home/lamp --as panel")
    with opened(line, environment, lamp.folder) as terminal:
        screen = Screen(terminal)
        screen.until(r"level [^\n]*0.5\b")
        os.kill(terminal.pid, ending)
        assert terminal.status() == 0
    why = "rtget: panel.level: no-service: no service named panel (there is home/lamp)\n"
    assert lamp.run("rtget panel.level").err == why


@pytest.mark.parametrize("way", ["--at {tcp} home/lamp.level", "{web}.level",
                                 "--at {web} level", "{tcp}/home/lamp.level"])  # fmt: skip
def test_a_part_behind_an_endpoint(lamp: Any, way: str) -> None:
    line = lamp.command("rtgui " + way.format(tcp=lamp.address, web=lamp.web))
    environment = {**lamp.environment, "TERM": "xterm-256color"}
    with opened(line, environment, lamp.folder) as terminal:
        screen = Screen(terminal)
        screen.until(r"level [^\n]*0.5\b")
        terminal.type("\x1b[F")
        screen.until(r"level [^\n]*● 1\b")
        terminal.type("q")
        assert terminal.status() == 0
    assert lamp.ok("rtget home/lamp.level") in ("1\n", "1.0\n")


def test_what_cannot_be_shown_is_said(lamp: Any) -> None:
    done = lamp.run("rtgui home/lamp")
    why = "rtgui: a panel needs a terminal; for values as text: rtget, rtlisten\n"
    assert (done.status, done.out, done.err) == (1, "", why)
    environment = {**lamp.environment, "TERM": "xterm"}
    line = ["sh", "-c", 'exec "$@" 2> why.txt', "sh", *lamp.command("rtgui home/lamp")]
    with opened(line, environment, lamp.folder) as terminal:
        assert (terminal.rest(), terminal.status()) == ("", 1)
    assert (lamp.folder / "why.txt").read_text("utf-8") == why
    with opened(lamp.command("rtgui home/lamb"), environment, lamp.folder) as terminal:
        assert "rtgui: home/lamb.gui: no-service: no service named home/lamb" in terminal.rest()
        assert terminal.status() == 1
    code = (
        "import sys; sys.modules['textual'] = None; "
        "from rtkit.cli.properties.rtgui import main; main()"
    )
    with opened([sys.executable, "-c", code, "home/lamp"], environment, lamp.folder) as terminal:
        assert "needs the package textual: pip install 'rtkit[gui]'" in terminal.rest()
        assert terminal.status() == 1


def test_who_is_slow_delays_nothing_and_who_is_stopped_is_stale(shell: Any) -> None:
    (shell.folder / "well.py").write_text(WELL, encoding="utf-8")
    process = shell.open("rtserve well:Well home/well")
    assert process.stdout.readline() == "/localhost/home/well\n"
    environment = {**shell.environment, "TERM": "xterm-256color"}
    with opened(shell.command("rtgui home/well"), environment, shell.folder) as terminal:
        screen = Screen(terminal)
        screen.until(r"lamp [^\n]*on\b")
        terminal.type(" ")
        screen.until(r"off\b")
        (shell.folder / "looked").touch()
        screen.until(r"7\.5")
        process.send_signal(signal.SIGSTOP)
        screen.until(r"no answer: what is shown is what was known last")
        screen.until(r"◷ stale")
        terminal.resize(60, 12)
        screen.until(r"lamp [^\n]*off\b[^\n]*◷ stale")
        process.send_signal(signal.SIGCONT)
        screen.until(r"● live")
        process.send_signal(signal.SIGSTOP)
        screen.until(r"no answer")
        terminal.type("q")
        assert terminal.status() == 0
    process.send_signal(signal.SIGCONT)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=30) == ("", "")
