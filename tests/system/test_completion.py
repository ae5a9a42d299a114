"""TAB in bash, zsh and fish as they are: what the finished line hands to its command."""

from __future__ import annotations

import os
import shlex
import shutil
import socket
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from terminal import Terminal, opened

SHELLS = {
    "bash": (["bash", "--norc", "-i"], 'eval "$(rtkit shell-init bash)"'),
    "zsh": (["zsh", "-f", "-i"], 'eval "$(rtkit shell-init zsh)"'),
    "fish": (["fish", "--no-config", "-i"], "rtkit shell-init fish | source"),
}
STANDS_IN = {
    "bash": "{0}() {{ printf 'got<%s>' \"$@\"; echo; }}",
    "zsh": "{0}() {{ printf 'got<%s>' \"$@\"; echo; }}",
    "fish": "function {0}; printf 'got<%s>' $argv; echo; end",
}
NAMES = (
    "rtls", "rtcat", "rtcon", "rtdis", "rtconf", "rtact", "rtresurrect", "rtget", "rtset",
    "rtlisten", "rtserve", "rtplan", "rtapply",
)  # fmt: skip
ODD = 'My "odd" $1 robot\'s'
HOST = "/localhost/"
ARM = """
from typing import Literal


class Arm:
    def __init__(self):
        self.angle = 0.5
        self.name = "left"
        self.mode: Literal["slow", "fast"] = "slow"

    def hold(self, what: Literal["tool", "cup"], force: float):
        pass
"""

LINES: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("rtls /loc\t", (HOST,)),
    ("rtls --rec\t", ("--recurse",)),
    (f"rtls {HOST}In\t", (f"{HOST}In.rtc",)),
    (f"rtls {HOST}My\t", (f"{HOST}{ODD}.rtc",)),
    (f'rtls "{HOST}My\t', (f"{HOST}{ODD}.rtc",)),
    (f"rtcat {HOST}In.rtc:\t", (f"{HOST}In.rtc:out",)),
    (f"rtcon {HOST}In.rtc:o\t {HOST}O\t", (f"{HOST}In.rtc:out", f"{HOST}Out.rtc:in")),
    (f"rtcat '{HOST}Out.rtc:\t", (f"{HOST}Out.rtc:in",)),
    (f"rtdis -i w\t {HOST}In.rtc:\t", ("-i", "wire", f"{HOST}In.rtc:out")),
    (f"rtact {HOST}O\t", (f"{HOST}Out.rtc",)),
    (f"rtact {HOST}In\t", (f"{HOST}In",)),  # it is active already
    (f"rtconf {HOST}In.rtc g\t v\t", (f"{HOST}In.rtc", "get", "values")),
    (f"rtconf {HOST}In.rtc set values=\t", (f"{HOST}In.rtc", "set", "values=0")),
    (f"rtconf {HOST}In.rtc -s d\t", (f"{HOST}In.rtc", "-s", "default")),
    (f"rtget {HOST}I\tsta\t", (f"{HOST}In.rtc.state",)),
    ("rtlisten ar\tan\t arm.angle.me\t", ("arm.angle", "arm.angle.meta")),
    (f"rtget localhost.l\t {HOST}ar\tna\t", ("localhost.load", f"{HOST}arm.name")),
    (f"rtset {HOST}In.rtc.state I\t", (f"{HOST}In.rtc.state", "Inactive")),
    ("rtset arm.name \t", ("arm.name", "left")),
    ("rtset arm.mode f\t", ("arm.mode", "fast")),
    ("rtset arm.hold '(c\t", ("arm.hold", "(cup force)")),
    ("rtserve ./arm.py\t --po\t", ("./arm.py:Arm", "--port")),
    ("rtplan --det\t sys\t", ("--detailed-exitcode", "system.xml")),
    ("rtapply -s I\t", ("-s", "Inactive")),
    ("rtresurrect sys\t", ("system.xml",)),
    ("rtresurrect so\tx", ("some where/x",)),
)


def told(terminal: Terminal) -> tuple[str, ...]:
    """Return the arguments that a command was called with."""
    told = terminal.until(r"got<((?:[^\r]|\r(?!\n))*)>\r?\n")[1]
    return tuple(told.split(">got<"))


@contextmanager
def begun(shell: str, environment: dict[str, str], folder: Path) -> Iterator[Terminal]:
    """Start a shell that has our functions; commands in it only tell their arguments."""
    argv, take = SHELLS[shell]
    with opened(argv, environment, folder, 200) as terminal:
        terminal.type(f"{take}\r")
        for name in NAMES:
            terminal.type(STANDS_IN[shell].format(name) + "\r")
        terminal.type("echo be''gun\r")
        yield terminal


@pytest.mark.timeout(180)  # 78 lines in three shells, a process for each TAB
@pytest.mark.skipif(not all(map(shutil.which, SHELLS)), reason="a shell is absent")
def test_tab_in_real_shells(manager: Any) -> None:
    made = "-c ConsoleIn?instance_name=In -c ConsoleOut?instance_name=Out"
    manager.ok(f"rtmgr {HOST}manager.mgr {made}")
    odd = shlex.quote(f"ConsoleOut?instance_name={ODD}")
    manager.ok(f"rtmgr {HOST}manager.mgr -c {odd}")
    manager.ok(f"rtcon -i wire {HOST}In.rtc:out {HOST}Out.rtc:in")
    manager.ok(f"rtact {HOST}In.rtc")
    home = manager.folder / "home"
    (home / "some where").mkdir(parents=True)
    (home / "arm.py").write_text(ARM)
    serving = manager.open(f"rtserve {home}/arm.py:Arm arm")
    serving.stdout.readline()
    for name in ("system.xml", "sys.txt"):
        (home / name).touch()
    environment = {
        **manager.environment,
        "HOME": str(home),
        "PATH": os.pathsep.join([os.path.dirname(sys.executable), os.environ["PATH"]]),
        "TERM": "xterm",
        "RTKIT_COMPLETION_TIMEOUT": "30",
    }
    with ExitStack() as stack:
        stack.callback(lambda: manager.end_of(serving))
        stack.callback(serving.terminate)
        terminals = {
            shell: stack.enter_context(begun(shell, environment, home)) for shell in SHELLS
        }
        for terminal in terminals.values():
            terminal.until("[\r\n]begun")
        for line, expected in LINES:
            for terminal in terminals.values():
                terminal.type(f"{line}\r")
            for shell, terminal in terminals.items():
                assert told(terminal) == expected, (shell, line)
        for terminal in terminals.values():
            check_working_directory(terminal)
            check_listing(terminal)


def check_listing(terminal: Terminal) -> None:
    """All ways to go on are shown when there are several."""
    terminal.type("rtcon \t\t")
    terminal.until(r"(?s)In\.rtc:.*Out\.rtc:|Out\.rtc:.*In\.rtc:")


def check_working_directory(terminal: Terminal) -> None:
    terminal.type(f"rtcwd {HOST}\rrtls In\t\r")
    assert told(terminal) == ("In.rtc",)


@pytest.mark.skipif(os.getuid() != 0, reason="only root gives folders away")
@pytest.mark.parametrize(
    "line",
    [
        "rtkit complete bash 9 ' =' 'rtls /localhost/'",
        "rtkit complete bash 9 ' =' 'rtget ar'",
        "rtls /localhost",
        "rtget arm.x",
    ],
)
def test_nobody_connects_to_sockets_in_the_folder_of_another_user(
    shell: Any, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(shell.environment, "RTKIT_RUNTIME_DIR")
    monkeypatch.setitem(shell.environment, "XDG_RUNTIME_DIR", str(shell.folder))
    folder = shell.folder / "rtkit"
    folder.mkdir(mode=0o755)
    with socket.socket(socket.AF_UNIX) as endpoint, socket.socket(socket.AF_UNIX) as service:
        for end, name in ((endpoint, "manager.sock"), (service, "arm.ps")):
            end.bind(str(folder / name))
            end.listen()
            end.setblocking(False)
        os.chown(folder, 65534, 65534)
        status, out, err = shell.run(line)
        assert (status, out) == (1, "")
        assert f"folder belongs to another user: {folder}" in err
        for end in (endpoint, service):
            with pytest.raises(BlockingIOError):
                end.accept()
