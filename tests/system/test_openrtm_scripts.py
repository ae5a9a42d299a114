"""Components written for OpenRTM-aist-Python that are run as scripts, as their authors do."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from openrtm_files import HEAD
from waiting import until

BODY = """
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._d_in = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._inIn = OpenRTM_aist.InPort("in", self._d_in)
        self.gain = [1]

    def onInitialize(self):
        self.addInPort("in", self._inIn)
        self.bindParameter("gain", self.gain, "2")
        return RTC.RTC_OK

    def onExecute(self, ec_id):
        if self._inIn.isNew():
            print("got", self._inIn.read().data * self.gain[0], flush=True)
        return RTC.RTC_OK

    def onFinalize(self):
        print("finalised", flush=True)
        return RTC.RTC_OK
"""
MAIN = """

def MyModuleInit(manager):
    EchoInit(manager)
    component = manager.createComponent("Echo")
    print("made", component.getInstanceName(), flush=True)


if __name__ == "__main__":
    import sys
    mgr = OpenRTM_aist.Manager.init(sys.argv)
    mgr.setModuleInitProc(MyModuleInit)
    mgr.activateManager()
    mgr.runManager()
    print("returned", flush=True)
"""
PATH = "/localhost/Echo0.rtc"


@pytest.fixture
def module(tmp_path: Path) -> Path:
    file = tmp_path / "Echo.py"
    file.write_text(HEAD.format(name="Echo", body=BODY, more="") + MAIN)
    return file


@pytest.fixture(params=["run", "path"])
def script(shell: Any, module: Path, request: pytest.FixtureRequest) -> Iterator[Any]:
    """Return a function that runs the module in one of the two ways."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: str) -> subprocess.Popen[str]:
        environment = dict(shell.environment)
        words = [str(Path(sys.executable).with_name("rtkit")), "openrtm", "run", str(module)]
        if request.param == "path":
            environment["PYTHONPATH"] = shell.ok("rtkit openrtm path").strip()
            words = [sys.executable, str(module)]
        started.append(
            subprocess.Popen(
                [*words, *arguments],
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                env=environment,
                cwd=shell.folder,
            )
        )
        return started[-1]

    yield start
    for each in started:
        each.kill()
        each.communicate()


def line_of(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def test_a_script_starts_a_manager_and_leaves_with_ctrl_c(shell: Any, script: Any) -> None:
    process = script()
    assert line_of(process) == "made Echo0", process.communicate()[1]
    shell.ok(f"rtact {PATH}")
    assert shell.run(f"rtinject -c 21 {PATH}:in") == (0, "", "")
    assert line_of(process) == "got 42"
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=20)[0].splitlines() == ["finalised", "returned"]
    assert process.returncode == 0
    assert "Echo0" not in shell.ok("rtls /localhost")


def test_a_script_joins_the_manager_that_runs_and_ends_with_its_components(
    shell: Any, script: Any
) -> None:
    shell.ok("rtmgr start")
    first = script()
    assert line_of(first) == "made Echo0"
    second = script()
    assert line_of(second) == "made Echo1"
    shell.ok("rtexit /localhost/Echo0.rtc")
    shell.ok("rtexit /localhost/Echo1.rtc")
    for process in (first, second):
        assert process.communicate(timeout=20)[0].splitlines() == ["finalised", "returned"]
        assert process.returncode == 0


def test_what_rtc_conf_says_of_components_holds(shell: Any, script: Any, tmp_path: Path) -> None:
    (tmp_path / "echo.conf").write_text("conf.default.gain: 5\n")
    (tmp_path / "my.conf").write_text(
        "exec_cxt.periodic.rate: 50\n"
        "manager.components.precreate: Echo\n"
        "manager.components.preactivation: Echo1\n"
        f"example.Echo.config_file: {tmp_path}/echo.conf\n"
    )
    process = script("-f", str(tmp_path / "my.conf"), "-o", "naming.formats: %n.rtc")
    assert line_of(process) == "made Echo0", process.communicate()[1]
    until(lambda: "Active" in shell.run("rtls -l /localhost/Echo1.rtc").out, "Echo1 is active")
    assert shell.ok("rtget localhost/Echo1.rtc.contexts.0.rate").split()[-1] == "50.0"
    assert shell.ok("rtconf /localhost/Echo1.rtc get gain").strip() == "5"


def test_two_scripts_may_start_the_manager_at_the_same_time(script: Any) -> None:
    made = []
    for process in (script(), script()):
        while (line := line_of(process)) == "finalised":  # the name was taken meanwhile
            pass
        made.append(line)
    assert sorted(made) == ["made Echo0", "made Echo1"]


def test_nothing_of_it_is_there_for_others(shell: Any, module: Path) -> None:
    shell.ok("rtmgr start")
    shell.ok(f"rtmgr -l {module}:EchoInit -c Echo /localhost/manager.mgr")
    other = shell.modules / "Other.py"
    other.write_text("import OpenRTM_aist_no\n\ndef OtherInit(manager):\n    pass\n")
    told = shell.run(f"rtmgr -l {other}:OtherInit /localhost/manager.mgr")
    assert told.status == 1
    assert "No module named 'OpenRTM_aist_no'" in told.err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("import no_such_module", "ModuleNotFoundError: No module named 'no_such_module'"),
        ("1 / 0", "ZeroDivisionError: division by zero"),
        ("open('no-such-file')", "FileNotFoundError: [Errno 2] No such file or directory"),
        ("def f(:", "SyntaxError: "),
    ],
)
def test_what_a_script_raises_is_told_as_its_own_with_the_line(
    shell: Any, tmp_path: Path, text: str, told: str
) -> None:
    file = tmp_path / "Wrong.py"
    file.write_text(f"import OpenRTM_aist\n{text}\n")
    outcome = shell.run(f"rtkit openrtm run {file}")
    assert outcome.status == 1
    assert f"the script failed: {told}" in outcome.err
    assert f"{file}:2" in outcome.err
    assert "bug in rtkit" not in outcome.err
