"""Starts and stops with orders and preconditions on live processes."""

from __future__ import annotations

import os
import select
import signal
import subprocess
from pathlib import Path
from typing import Any

import rts_text
from waiting import told_pid

KEEPS_MANAGER = True
STEP = """
import os
from rtkit.component import Component


class Step(Component):
    def on_activated(self, context):
        self._note("up")
        if os.path.exists(self._file("gate")):
            with open(self._file("gate")) as gate:
                gate.read()

    def on_deactivated(self, context):
        self._note("down")

    def _note(self, what):
        with open(os.environ["RTKIT_STATE_DIR"] + "/story", "a") as story:
            story.write(f"{self.instance} {what}\\n")

    def _file(self, kind):
        return os.environ["RTKIT_STATE_DIR"] + f"/{kind}-{self.instance}"


def StepInit(manager):
    manager.register_factory(Step)
"""
PATH = "/localhost/{}.rtc"
EC = "in execution context main"


def name(instance: str) -> str:
    return f'rts:componentId="RTC:::Step:" rts:instanceName="{instance}" rts:id="main"'


def entry(instance: str, sequence: int, condition: str = "") -> str:
    condition = condition or '<rts:WaitTime rts:waitTime="0"/>'
    return (
        f'<rts:targets rts:sequence="{sequence}" xsi:type="rtsExt:condition_ext">{condition}'
        f"<rts:TargetComponent {name(instance)}/></rts:targets>"
    )


def wait(ms: int) -> str:
    return f'<rts:WaitTime rts:waitTime="{ms}"/>'


def after(instance: str, timing: str = "SYNC", timeout: int = 0) -> str:
    return (
        f'<rts:Preceding rts:sendingTiming="{timing}" rts:timeout="{timeout}">'
        f"<rts:PrecedingComponents {name(instance)}/></rts:Preceding>"
    )


class Steps:
    """A live system of components A, B … each in a process of its own, brought up."""

    def __init__(
        self, shell: Any, *activation: str, names: str = "ABCD", optional: str = ""
    ) -> None:
        self.shell = shell
        self.story = Path(shell.folder / "state" / "story")
        (shell.modules / "Step.py").write_text(STEP)
        parts = [
            rts_text.component(
                name,
                {"create": f"Step?manager_name=slave{name}", "module": "Step.py:StepInit"},
                type_id="RTC:::Step:",
                required=name not in optional,
                context="main",
            )
            for name in names
        ]
        order = f"<rts:Activation>{''.join(activation)}</rts:Activation>"
        text = rts_text.system("Steps", *parts, order)
        (shell.folder / "steps.xml").write_text(text, encoding="utf-8")
        assert shell.run("rtresurrect steps.xml") == (0, "", "")

    def told(self) -> list[str]:
        """Return what happened, and forget it."""
        lines = self.story.read_text().splitlines() if self.story.exists() else []
        self.story.unlink(missing_ok=True)
        return lines

    def gate(self, instance: str) -> Path:
        """Have on_activated of a component wait until something is written here."""
        path: Path = self.shell.folder / "state" / f"gate-{instance}"
        os.mkfifo(path)
        return path

    def pid(self, instance: str) -> int:
        return told_pid(self.shell, f"slave{instance}")

    def kill(self, instance: str) -> None:
        end_process(self.pid(instance))


def end_process(pid: int) -> None:
    """Kill a process and return when it has ended."""
    pidfd = os.pidfd_open(pid)
    os.kill(pid, signal.SIGKILL)
    assert select.select([pidfd], [], [], 10)[0]
    os.close(pidfd)


def read_until(command: subprocess.Popen[str], what: str) -> str:
    """Return the first line of stderr that holds `what`."""
    assert command.stderr is not None
    for line in command.stderr:
        if what in line:
            return line
    raise AssertionError(f"it ended without {what!r}")


def end(command: subprocess.Popen[str]) -> tuple[int, str]:
    _, err = command.communicate(timeout=20)
    return command.returncode, err


def test_all_four_kinds(manager: Any) -> None:
    steps = Steps(
        manager,
        entry("A", 5),
        entry("B", 1),
        entry("C", 6, wait(300)),
        entry("C", 6, after("B", timeout=2000)),
        entry("D", 7, after("C", "ASYNC")),
        entry("E", 8, after("D")),
        names="ABCDE",
    )
    planned = [
        f"{{1}} [Order 1] Activate /localhost/B.rtc {EC} (Required)",
        f"{{2}} [Order 5] Activate /localhost/A.rtc {EC} (Required)",
        f"{{3}} [Order 6/Wait 300ms, Sync to /localhost/B.rtc] Activate /localhost/C.rtc {EC}"
        " (Required)",
        f"{{4}} [Order 7/After /localhost/C.rtc's action] Activate /localhost/D.rtc {EC}"
        " (Required)",
        f"{{5}} [Order 8/Sync to /localhost/D.rtc] Activate /localhost/E.rtc {EC} (Required)",
    ]
    assert manager.ok("rtstart --dry-run steps.xml").splitlines()[5:] == planned
    done = manager.run("rtstart steps.xml")
    assert (done.status, done.out) == (0, "")
    assert done.err.splitlines() == [f"Executing {line}" for line in planned]
    story = steps.told()
    assert story[:2] == ["B up", "A up"]
    assert sorted(story[2:]) == ["C up", "D up", "E up"]
    assert story.index("D up") < story.index("E up")
    assert manager.run("rtcheck steps.xml") == (0, "", "")
    assert manager.run("rtstop steps.xml").status == 0
    assert steps.told() == ["E down", "D down", "C down", "A down", "B down"]


def test_who_is_told_only_after_another_does_not_wait_for_it(manager: Any) -> None:
    steps = Steps(
        manager,
        entry("A", 1, wait(1)),
        entry("B", 2, after("A", "ASYNC")),
        entry("C", 3, after("A")),
        names="ABC",
    )
    gate = steps.gate("A")
    command = manager.open("rtstart steps.xml")
    read_until(command, "{2}")
    with gate.open("w") as stream:
        listed = manager.ok("rtls -l /localhost")
        assert "Inactive" in next(line for line in listed.splitlines() if line.endswith("A.rtc"))
        stream.write("go")
    assert read_until(command, "{3}").startswith("Executing {3} [Order 3/Sync to /localhost/A.rtc]")
    assert end(command) == (0, "")
    assert steps.told()[-1] == "C up"


def test_ctrl_c_in_the_middle_of_a_waiting_plan(manager: Any) -> None:
    steps = Steps(
        manager,
        entry("A", 1),
        entry("B", 2, wait(1)),
        entry("C", 3, wait(600_000)),
        entry("D", 4, after("C")),
    )
    command = manager.open("rtstart steps.xml")
    read_until(command, "Executing {2}")
    command.send_signal(signal.SIGINT)
    status, err = end(command)
    assert status == -signal.SIGINT
    (line,) = err.splitlines()
    assert line.startswith("rtstart: interrupted; not run: ")
    assert "{3}, {4}; active now: /localhost/A.rtc" in line
    assert not {"C up", "D up"} & set(steps.told())
    assert manager.run("rtstop steps.xml").status == 0


def test_a_component_killed_while_others_wait_for_it_is_named(manager: Any) -> None:
    steps = Steps(
        manager,
        entry("B", 1, after("A", timeout=200)),
        entry("C", 2, after("B", "ASYNC")),
        names="ABC",
        optional="A",
    )
    steps.gate("A")
    command = manager.open("rtstart steps.xml")
    read_until(command, "Executing {1}")
    steps.kill("A")
    status, err = end(command)
    assert status == 1
    assert err.splitlines() == [
        "rtstart: Action failed: /localhost/A.rtc: slave slaveA ended: signal 9",
        "rtstart: Error executing plan: Preceding condition timed out: action {2} waited 200ms for:"
        " Sync to /localhost/A.rtc (it is zombie (signal 9)); not run: {2}, {3}; active now: none",
    ]
    assert steps.told() in ([], ["A up"])


def test_one_that_dies_after_it_was_ready_is_waited_for_again(manager: Any) -> None:
    steps = Steps(
        manager,
        entry("A", 1),
        entry("B", 2, wait(1)),
        entry("C", 3, after("A")),
        entry("C", 3, after("B")),
        names="ABC",
        optional="AB",
    )
    gate = steps.gate("B")
    command = manager.open("rtstart --timeout 60 steps.xml")
    read_until(command, "Executing {2}")
    steps.kill("A")
    gate.write_text("go")
    manager.ok("rtmgr -c 'Step?instance_name=A&manager_name=slaveA' /localhost/manager.mgr")
    manager.ok("rtact /localhost/A.rtc")
    assert read_until(command, "Executing {3}")
    assert end(command) == (0, "")
    told = steps.told()
    assert told[0] == "A up"
    assert sorted(told) == ["A up", "A up", "B up", "C up"]


def test_a_killed_component_holds_up_no_stop(manager: Any) -> None:
    steps = Steps(manager, entry("A", 1), names="AB")
    file = manager.folder / "steps.xml"
    order = f"<rts:Deactivation>{entry('B', 1, after('A'))}</rts:Deactivation>"
    file.write_text(file.read_text().replace("</rts:RtsProfile>", f"{order}</rts:RtsProfile>"))
    assert manager.run("rtstart steps.xml").status == 0
    steps.kill("A")
    stopped = manager.run("rtstop steps.xml")
    assert stopped.status == 0
    assert stopped.err.splitlines()[-1].startswith(
        "Executing {2} [Order 1/Sync to /localhost/A.rtc]"
    )
    assert steps.told()[-1] == "B down"


def test_a_manager_killed_while_a_plan_waits(manager: Any) -> None:
    Steps(manager, entry("B", 1, wait(600_000)), entry("C", 2, after("B")), names="ABC")
    command = manager.open("rtstart --timeout 2 steps.xml")
    read_until(command, "Executing {1}")
    pid = told_pid(manager)
    end_process(pid)
    status, err = end(command)
    assert status == 1
    assert err.startswith("rtstart: manager ")
    assert "; not run: " in err
    assert "; how far it got is not known (" in err
    manager.ok("rtmgr start")
