"""The plugin of pytest in projects of strangers, whose tests fail, are interrupted and killed."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from shells import ROOT, Shell, processes_of, wait_for_end

EXAMPLE = ROOT / "examples" / "ci"

SCALE = """
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong


class Scale(Component):
    factor = Parameter(2)
    into = InPort(TimedLong)
    out = OutPort(TimedLong)

    def on_activated(self, context):
        print("scaling by", self.factor)
        self.check()

    def check(self):
        if self.factor < 0:
            raise ValueError("negative")


def ScaleInit(manager):
    manager.register_factory(Scale)
"""
CREATE = 'rtmanager.load("Scale.py"); rtmanager.create("Scale?manager_name=other")'


@pytest.fixture
def project(shell: Shell) -> Shell:
    """A shell in the folder of a project that has the component Scale, and no test yet."""
    (shell.folder / "Scale.py").write_text(SCALE)
    (shell.folder / "tmp").mkdir()
    shell.environment["TMPDIR"] = str(shell.folder / "tmp")
    for name in [name for name in shell.environment if name.startswith("PYTEST_")]:
        del shell.environment[name]
    return shell


def started(project: Shell, tests: str, *arguments: str) -> subprocess.Popen[str]:
    (project.folder / "test_it.py").write_text(tests)
    line = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *arguments]
    return subprocess.Popen(
        line,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=project.environment,
        cwd=project.folder,
    )


def run(project: Shell, tests: str, *arguments: str) -> str:
    """Run pytest to its end and return what it printed; nothing may be left then."""
    out, _ = started(project, tests, *arguments).communicate(timeout=60)
    assert [*processes_of(project.run_id), *(project.folder / "tmp").glob("rtk*")] == []
    return out


def test_a_failure_is_reported_with_what_lived_and_was_logged(project: Shell) -> None:
    project.environment["RTKIT_CWD"] = "/localhost/elsewhere"
    out = run(
        project,
        "import os, pytest, signal, subprocess, sys\n"
        "from rtkit.testing import Trial\n"
        "from Scale import Scale\n"
        "def test_live(rtmanager):\n"
        f"    {CREATE}\n"
        "    rtmanager.configure('/localhost/Scale0.rtc', factor=-1)\n"
        "    rtmanager.activate('/localhost/Scale0.rtc')\n"
        "@pytest.fixture\n"
        "def late(rtmanager):\n"
        "    rtmanager.create('Nobody')\n"
        "def test_setup(late):\n    pass\n"
        "@pytest.fixture\n"
        "def trial():\n"
        "    with Trial(Scale, {'conf.default.factor': '-1'}) as trial:\n"
        "        yield trial\n"
        "def test_trial(trial):\n    trial.activate()\n"
        "def test_nothing():\n    assert 0\n"
        "def test_killed(rtmanager):\n"
        f"    {CREATE}\n"
        "    manager = os.pidfd_open(rtmanager.snapshot().pid)\n"
        "    signal.pidfd_send_signal(manager, signal.SIGKILL)\n"
        "    assert rtmanager.snapshot() is None\n"
        "LS = [sys.executable, '-c', 'from rtkit.cli.tree.rtls import main; main()']\n"
        "def test_commands(rtmanager):\n"
        f"    {CREATE}\n"
        "    os.posix_spawnp('sleep', ['sleep', '1000'], os.environ)\n"
        "    assert b'Scale0.rtc' in subprocess.run([*LS, '/localhost'], stdout=-1).stdout\n",
    )
    where = r"ValueError: negative \(Scale.py:\d+ in check, called by on_activated\)"
    status = r"- rtkit: status -+\nmanager manager, pid \d+: 1 components\n  "
    assert re.search(rf"{status}/localhost/Scale0.rtc  Error  {where}\n-+ rtkit: log -", out), out
    assert re.search(r"\[Scale0 \S+\] INFO: scaling by -1\n", out)
    assert re.search(rf"\[Scale0 \S+\] ERROR: on_activated failed: {where}\nTraceback", out)
    assert re.search(r"manager manager, pid \d+: 0 components\n", out), "of the fixture"
    assert re.search(rf"- rtkit: trial -+\nScale0 is in Error: {where}\n", out)
    assert "no manager runs any more\n" in out
    assert out.count("- rtkit: ") == 2 + 2 + 1 + 2
    assert "4 failed, 1 passed, 1 error" in out, "of the one that is killed no error of its end"


def test_a_system_is_brought_up_and_described_at_a_failure(project: Shell) -> None:
    for name in ("Heating.xml", "Thermostat.py"):
        shutil.copy(EXAMPLE / name, project.folder)
    (project.folder / "broken.xml").write_text("<rts:RtsProfile>")
    out = run(
        project,
        "import pytest\n"
        "DRIVERS = ('Thermometer0', 'Heater0')\n"
        "def test_drivers(rtsystem):\n"
        "    tree = rtsystem('Heating.xml', stand_in=DRIVERS)\n"
        "    shown = tree.snapshot().components\n"
        "    assert {each.instance for each in shown if each.is_stand_in} == {*DRIVERS}\n"
        "    assert tree.check('Heating.xml')\n"
        "    with pytest.raises(TimeoutError):\n"
        "        tree.read('/localhost/Thermostat0.rtc:power', timeout_s=0.1)\n"
        "def test_all(rtsystem, rtmanager):\n"
        "    assert rtsystem('Heating.xml', stand_in=True, state='Inactive') is rtmanager\n"
        "    values = {'Thermostat0.target': 19.5}\n"
        "    rtsystem('Heating.xml', stand_in=True, values=values, prefix='b.')\n"
        "    facts = rtmanager.component('/localhost/b.Thermostat0.rtc')\n"
        "    assert facts.sets['default']['target'] == '19.5'\n"
        "    assert 0\n"
        "def test_modules(rtsystem):\n"
        "    rtsystem('Heating.xml')\n"
        "def test_name(rtsystem):\n"
        "    rtsystem('Heating.xml', stand_in=['Heatr0'])\n"
        "def test_file(rtsystem):\n"
        "    rtsystem('Hearing.xml')\n"
        "def test_text(rtsystem):\n"
        "    rtsystem('broken.xml')\n",
    )
    assert "5 failed, 1 passed" in out, out
    plan = "- rtkit: plan -+\nplan: 5 steps, cost 20 .*\n +1  create Thermometer0 on manager"
    assert re.search(plan, out), out
    assert "  /localhost/Thermostat0.rtc  Inactive  stand-in\n" in out
    errors = re.findall(r"^E +rtkit\S+: (.*)$", out, re.MULTILINE)
    for error, told in zip(
        errors,
        [
            r"impossible: Thermometer0 cannot be .*: no module Thermometer.py \(",
            r"no component named Heatr0 \(",
            r"cannot read Hearing.xml: No such file or directory",
            r".*/broken.xml:1: ",
        ],
        strict=True,
    ):
        assert re.match(told, error)
    assert "rtkit/api/" not in out, "the inside of rtkit is no part of the report"


AT_ONCE = f"""
import pytest
@pytest.mark.parametrize("factor", range(4))
def test_it(rtmanager, factor):
    {CREATE}
    rtmanager.configure("/localhost/Scale0.rtc", factor=factor)
    assert rtmanager.ls() == ["Scale0.rtc", "manager.mgr"]
    assert rtmanager.component("/localhost/Scale0.rtc").sets["default"]["factor"] == str(factor)
"""


def test_the_example_for_build_servers_is_run_as_it_stands(project: Shell) -> None:
    """Its tests run beside others at once, and meet none of them."""
    (project.folder / "mine").mkdir()
    for name in ("Heating.xml", "Thermostat.py", "test_heating.py"):
        shutil.copy(EXAMPLE / name, project.folder / "mine")
    shutil.move(project.folder / "Scale.py", project.folder / "mine")
    (project.folder / "mine" / "test_at_once.py").write_text(AT_ONCE)
    project.environment["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    (workflow,) = (EXAMPLE / ".github/workflows").iterdir()
    (job,) = yaml.safe_load(workflow.read_text())["jobs"].values()
    assert all(("run" in step) != ("uses" in step) for step in job["steps"])
    commands = [step["run"] for step in job["steps"] if "run" in step]
    assert commands[0].startswith("python -m pip install ")
    assert commands[-1] == "python -m pytest -n 4"
    out = ""
    for command in commands[1:]:
        shell = ["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", command]
        place = {"cwd": project.folder / "mine", "env": project.environment}
        out += subprocess.run(shell, check=True, stdout=-1, text=True, timeout=60, **place).stdout
    assert "6 passed" in out
    assert out.startswith("::warning file=Heating.xml,line="), "drivers have no profiles here"
    assert json.loads((project.folder / "mine" / "check.sarif").read_text())["version"] == "2.1.0"
    assert len((EXAMPLE / "test_heating.py").read_text().splitlines()) <= 15


WAIT = f"""
import signal
def test_long(rtmanager):
    {CREATE}
    rtmanager.activate("/localhost/Scale0.rtc")
    print("begun", flush=True)
    signal.pause()
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_nothing_outlives_a_pytest_that_is_ended(project: Shell, number: signal.Signals) -> None:
    with started(project, WAIT, "-s") as tests:
        assert tests.stdout is not None
        assert tests.stdout.readline() == "begun\n"
        processes = processes_of(project.run_id)
        assert len(processes) >= 4, "pytest, manager, zygote, slave"
        tests.send_signal(number)
        assert wait_for_end(processes, 20.0) == []


def test_what_is_not_used_is_not_imported(project: Shell) -> None:
    (project.folder / "conftest.py").write_text(
        "import sys\n"
        "def pytest_sessionfinish():\n"
        "    print(sorted(name for name in sys.modules if name.partition('.')[0] == 'rtkit'))\n"
    )
    out = run(project, "def test_it():\n    assert 0\n", "-s")
    assert "['rtkit', 'rtkit.testing', 'rtkit.testing.plugin']" in out
    assert "1 failed" in out


@pytest.mark.parametrize(
    ("owner", "why"),
    [
        ("me", "not the number of a process"),
        (str(2**22 + 1), "that process has ended"),
        ("1:99999999999", "that process has ended"),
    ],
)
def test_a_manager_does_not_begin_that_ought_to_have_ended(
    shell: Shell, owner: str, why: str
) -> None:
    shell.environment["RTKIT_ENDS_WITH"] = owner
    outcome = shell.run("rtmgr start")
    assert outcome.status == 1
    assert outcome.err == f"rtmgr: RTKIT_ENDS_WITH={owner}: {why}\n"
    assert not list(Path(shell.folder, "run").glob("*.sock"))
