"""A component that its author runs by hand is in the tree, in a debugger, and leaves no trace."""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from waiting import told_pid, until

import rtkit
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong
from rtkit.errors import Malformed, Refused, RtkitError, Unreachable

KEEPS_MANAGER = True

SCRIPT = '''
import rtkit
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong


class Scale(Component):
    """Scales what comes."""

    in_ = InPort(TimedLong, "in")
    out = OutPort(TimedLong)
    factor = Parameter(2)
    rate = 100.0

    def on_activated(self, context):
        print("factor", self.factor, flush=True)

    def on_execute(self, context):
        if self.factor == 7:
            breakpoint()
        if self.factor == 8:
            print("read", input(), flush=True)

    def on_finalize(self):
        print("finalised", flush=True)


def ScaleInit(manager):
    manager.register_factory(Scale)


if __name__ == "__main__":
    rtkit.run(Scale)
    print("returned", flush=True)
'''
PATH = "/localhost/Scale0.rtc"


class Script:
    """A script that is run by hand."""

    def __init__(self, shell: Any, *arguments: str, by: tuple[str, ...] = ()) -> None:
        (shell.modules / "Scale.py").write_text(SCRIPT)
        self.process = subprocess.Popen(
            [sys.executable, *by, str(shell.modules / "Scale.py"), *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=shell.environment,
            cwd=shell.folder,
        )

    def type(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text)
        self.process.stdin.flush()

    def interrupt(self) -> tuple[str, str]:
        """Type Ctrl-C; return what it wrote until its end, which must be a good one."""
        self.process.send_signal(signal.SIGINT)
        return self.end()

    def end(self) -> tuple[str, str]:
        out, err = self.process.communicate(timeout=20.0)
        assert self.process.returncode == 0, err
        return out, err


@pytest.fixture
def scripts(manager: Any) -> Iterator[Any]:
    opened: list[Script] = []

    def start(*arguments: str, by: tuple[str, ...] = ()) -> Script:
        opened.append(Script(manager, *arguments, by=by))
        return opened[-1]

    yield start
    for script in opened:
        script.process.kill()
        script.process.communicate()
    (manager.modules / "Scale.py").unlink(missing_ok=True)


def shown(shell: Any, mark: str) -> str:
    """Wait until the listing has a line with that mark; return the line."""

    def find() -> str:
        lines = shell.ok("rtls -l /localhost").splitlines()
        return next((line for line in lines if mark in line), "")

    return until(find, f"a line with {mark!r}")


def is_gone(shell: Any) -> bool:
    left = [path.name for path in (shell.folder / "run").glob("*.guest.beats")]
    return not left and "Scale0" not in shell.ok("rtls /localhost")


def test_it_is_in_the_tree_connected_saved_and_leaves_with_ctrl_c(
    manager: Any, scripts: Any
) -> None:
    script = scripts("--activate", "--set", "factor=5", "--rate", "50", "-o", "a=b")
    shown(manager, "Active  2/0")
    manager.ok("rtmgr -c 'Scale?instance_name=S1&manager_name=s' /localhost/manager.mgr")
    manager.ok(f"rtcon /localhost/S1.rtc:out {PATH}:in")
    saved = manager.ok("rtcryo")
    assert "Scale?a=b&amp;conf.default.factor=5" in saved
    assert "manager_name=manager_%25p" in saved
    assert f'"{os.path.realpath(manager.modules / "Scale.py")}"' in saved
    (manager.folder / "saved.xml").write_text(saved)
    assert manager.ok("rtplan -s any saved.xml").startswith("nothing to do")
    assert manager.run("rtconf /localhost/Scale0.rtc get factor").out.strip() == "5"
    out, err = script.interrupt()
    assert out.splitlines() == ["factor 5", "finalised", "returned"]
    assert f"{PATH} is in the tree; Ctrl-C ends it" in err
    until(lambda: is_gone(manager), "no trace")
    assert "Active  2/1" not in manager.ok("rtls -l /localhost")
    manager.ok("rtexit /localhost/S1.rtc")
    (manager.folder / "saved.xml").unlink()


def test_at_a_breakpoint_it_is_in_a_debugger_and_goes_on(manager: Any, scripts: Any) -> None:
    script = scripts("--activate", "--set", "factor=7")
    line = shown(manager, "in a debugger since")
    assert "(Scale.py:20 in on_execute)" in line
    outcome = manager.run(f"rtdeact --timeout 0.3 {PATH}")
    assert outcome.status == 1
    assert "in a debugger" in outcome.err
    script.type("Scale.on_execute = lambda *_: None\nc\n")
    until(lambda: "in a debugger" not in manager.ok("rtls -l /localhost"), "its going on")
    script.process.send_signal(signal.SIGINT)
    assert script.process.wait(timeout=20.0) == 0  # and stops in the debugger no more
    assert script.end()[0].endswith("finalised\nreturned\n")


@pytest.mark.parametrize(
    ("factor", "typed"), [("7", "q\n"), ("8", "hello\n")], ids=["debugger quit", "input"]
)
def test_the_terminal_is_its_own(manager: Any, scripts: Any, factor: str, typed: str) -> None:
    script = scripts("--activate", "--set", f"factor={factor}")
    script.type(typed)
    if factor == "8":
        assert [script.process.stdout.readline() for _ in range(2)] == [
            "factor 8\n",
            "read hello\n",
        ]
        out, _ = script.interrupt()  # while it waits for the next line
    else:
        out, _ = script.end()
    assert out.endswith("finalised\nreturned\n")
    until(lambda: is_gone(manager), "no trace")


def test_debugger_and_profiler_see_what_the_component_does(manager: Any, scripts: Any) -> None:
    debugged = scripts("--activate", by=("-m", "pdb"))
    debugged.type("b 18\nc\n")
    assert "(Scale.py:18 in on_execute)" in shown(manager, "in a debugger since")
    debugged.process.kill()
    until(lambda: is_gone(manager), "no trace")
    profiled = scripts("--activate", by=("-m", "cProfile"))
    shown(manager, "Active")
    out, _ = profiled.interrupt()
    assert "(on_execute)" in out


def test_it_is_ended_from_outside(manager: Any, scripts: Any) -> None:
    script = scripts()
    shown(manager, "Scale0")
    manager.ok(f"rtexit {PATH}")
    out, err = script.end()
    assert out == "finalised\nreturned\n"
    assert "was ended" in err


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        (["--manager", "nobody"], 1, "manager 'nobody' is not running (start it with: rtmgr start"),
        (["--set", "factor=x"], 1, "factor cannot be 'x': it is no integer"),
        (["--rate", "fast"], 1, "not a number: 'fast'"),
        (["--set", "factor"], 2, "not KEY=VALUE: 'factor'"),
    ],
)
def test_what_cannot_be_is_one_clear_line(
    scripts: Any, arguments: list[str], status: int, text: str
) -> None:
    process = scripts(*arguments).process
    _, err = process.communicate(timeout=20.0)
    assert process.returncode == status
    assert text in err.splitlines()[-1]
    assert "Traceback" not in err


class Here(Component):
    """Is run in the process of the tests."""

    in_ = InPort(TimedLong, "in")
    out = OutPort(TimedLong)
    factor = Parameter(2)


@pytest.fixture
def here(manager: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_PORT"):
        monkeypatch.setenv(name, manager.environment[name])
    return manager


def test_in_a_notebook_it_runs_beside(here: Any) -> None:
    async def cell() -> str:
        first = rtkit.run(Here, parameters={"factor": 3}, activate=True)
        with rtkit.run(Here, activate=True) as again:  # the cell is run again
            assert (repr(first), first.is_running) == ("</localhost/Here0.rtc: has left>", False)
            assert again.component.configuration.values["factor"] == 2
            return here.ok("rtls -l /localhost")

    assert "Active  2/0  1/0  1/0  0/0  Here0.rtc" in asyncio.run(cell())
    assert "Here0" not in here.ok("rtls /localhost")


@pytest.mark.parametrize(
    ("wished", "error", "why"),
    [
        ({"manager": "nobody"}, Unreachable, "rtmgr start nobody"),
        ({"name": "a/b"}, RtkitError, "characters"),
        ({"parameters": {"factor": "x"}}, Malformed, "no integer"),
        ({"context": "Odd"}, Refused, "not known"),
    ],
)
def test_from_python_errors_are_raised_and_nothing_is_left(
    here: Any, wished: dict[str, Any], error: type[RtkitError], why: str
) -> None:
    with pytest.raises(error, match=why):
        rtkit.run(Here, wait=False, **wished)
    assert "Here" not in here.ok("rtls /localhost")
    assert list(Path(here.folder, "run").glob("*.guest.*")) == []


def test_a_name_is_taken_once(here: Any) -> None:
    with rtkit.run(Here, name="A", wait=False), rtkit.run(Here, wait=False) as other:
        assert other.path == "/localhost/Here0.rtc"
        with pytest.raises(Refused, match="A exists already"):
            rtkit.run(type("Other", (Here,), {}), name="A", wait=False)


def test_it_outlives_its_manager_with_its_connections(shells: Any) -> None:
    with shells() as shell:
        script = Script(shell, "--activate", "--start")
        until(lambda: not shell.run("rtls").status, "a manager")
        shown(shell, "Active  2/0")
        shell.ok("rtmgr -c 'Scale?instance_name=S1&manager_name=s' /localhost/manager.mgr")
        shell.ok(f"rtcon /localhost/S1.rtc:out {PATH}:in")
        os.kill(told_pid(shell), signal.SIGKILL)
        assert script.process.stderr is not None
        until(lambda: "the manager is gone" in script.process.stderr.readline(), "its notice")
        shell.ok("rtmgr start")
        shown(shell, "2/1  1/1  1/0  0/0  Scale0.rtc")
        shell.ok("rtmgr stop")
        out, _ = script.end()
        assert out.splitlines() == ["factor 2", "finalised", "returned"]
