"""The commands on real processes."""

from __future__ import annotations

import json
import os
import select
import shlex
import signal
from pathlib import Path
from typing import Any

import pytest
from waiting import told_pid, until

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
PROBE = '''
import time
from rtkit.component import Component, InPort, OutPort, Parameter, TimedLong


class Probe(Component):
    """Does what its parameters say."""

    rate = 100.0
    into = InPort(TimedLong)
    out = OutPort(TimedLong)
    fail = Parameter("")
    delay = Parameter(0.0)

    def on_activated(self, context):
        time.sleep(self.delay)
        if self.fail == "activation":
            raise ValueError("no such speed")

    def on_execute(self, context):
        if self.fail == "execution":
            raise ValueError("too fast")


def ProbeInit(manager):
    manager.register_factory(Probe)
'''


@pytest.fixture
def probe(manager: Any) -> Any:
    """A shell with a manager that can make components of type Probe."""
    (manager.modules / "Probe.py").write_text(PROBE)
    return manager


def test_a_manager_s_life(shell: Any) -> None:
    told = "rtmgr: manager 'manager' is not running (start it with: rtmgr start)\n"
    assert shell.run("rtmgr status") == (1, "", told)
    assert shell.run("rtls") == (1, "", told.replace("rtmgr:", "rtls:"))
    assert shell.run("rtls --exit-detail").status == 5

    outcome = shell.run("rtmgr -v start")
    socket = str(shell.folder / "run" / "manager.sock")
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    assert outcome == (0, "", f"manager manager runs: pid {pid}, socket {socket}\n")
    again = f"rtmgr: manager 'manager' is running already (pid {pid})\n"
    assert shell.run("rtmgr start") == (1, "", again)

    status = dict(line.split(maxsplit=1) for line in shell.ok("rtmgr status").splitlines()[2:])
    assert status["Components"] == "0"
    assert status["Socket"] == socket

    pidfd = os.pidfd_open(pid)
    assert shell.ok("rtmgr stop") == ""
    assert select.select([pidfd], [], [], 0)[0], "its process has not ended"
    os.close(pidfd)
    assert shell.run("rtmgr stop").status == 1


def test_managers_of_other_names(shell: Any) -> None:
    shell.ok("rtmgr start one")
    shell.ok("rtmgr start two")
    assert shell.ok("rtls") == "localhost/\n"  # others, though not the usual one
    shell.environment["RTKIT_MANAGER"] = "two"
    assert shell.ok("rtls /localhost") == "one.mgr/\ntwo.mgr/\n"
    assert shell.run("rtmgr start ../evil").status == 1
    shell.ok("rtmgr stop one")
    assert shell.ok("rtmgr status").splitlines()[0] == "Name        two"


def test_a_manager_in_the_foreground(shell: Any) -> None:
    with shell.open("rtmgr run") as process:
        try:
            assert shell.run("rtmgr start other").status == 0
            while shell.run("rtmgr status").status:
                assert process.poll() is None
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=10) == 0
        finally:
            process.kill()


def test_components_from_birth_to_death(manager: Any) -> None:
    line = "-c SeqOut -c SeqIn?manager_name=s1 -c ConfigSample?instance_name=Conf"
    assert manager.ok(f"rtmgr {line} --print {MANAGER}") == (
        "/localhost/SeqOut0.rtc\n/localhost/SeqIn0.rtc\n/localhost/Conf.rtc\n"
    )
    names = ["Conf.rtc", "SeqIn0.rtc", "SeqOut0.rtc", "manager.mgr/"]
    assert manager.ok("rtls /localhost").split() == names
    assert manager.ok(f"rtls {MANAGER}/s1.mgr") == "SeqIn0.rtc\n"
    assert told_pid(manager, "s1") != told_pid(manager)

    manager.ok("rtcon -i wire /localhost/SeqOut0.rtc:Long /localhost/SeqIn0.rtc:Long")
    manager.ok("rtact /localhost/SeqOut0.rtc /localhost/SeqIn0.rtc")
    assert manager.ok("rtls -l /localhost").splitlines()[1].split() == [
        "Active",
        "16/1",
        "16/1",
        "0/0",
        "0/0",
        "SeqIn0.rtc",
    ]
    described = manager.ok("rtcat -ll /localhost/SeqIn0.rtc:Long")
    assert " -Connected to  /localhost/SeqOut0.rtc:Long\n" in described
    assert "  ID                          wire\n" in described

    manager.ok("rtdis -i wire /localhost/SeqIn0.rtc")
    manager.ok("rtdeact /localhost/SeqOut0.rtc /localhost/SeqIn0.rtc")
    manager.ok(f"rtmgr -d SeqIn0 -d SeqOut0 -d Conf {MANAGER}")
    assert manager.ok("rtls -R /localhost") == ".:\nmanager.mgr/\n\n./manager.mgr:\n\n"


@pytest.mark.parametrize("name", ["größe 部品", "a*b$c#d", "50%", "'x' \\"])
def test_names_with_all_kinds_of_characters(manager: Any, name: str) -> None:
    create = shlex.quote("ConsoleOut?instance_name=" + name.replace("%", "%25"))
    path = shlex.quote(f"/localhost/{name}.rtc")
    assert manager.ok(f"rtmgr --print -c {create} {MANAGER}") == f"/localhost/{name}.rtc\n"
    manager.ok(f"rtact {path}")
    assert manager.ok(f"rtcat {path}").startswith(f"{name}.rtc  Active\n")
    assert manager.ok(f"rtls {path}") == f"{name}.rtc\n"
    manager.ok(f"rtmgr -d {shlex.quote(name)} {MANAGER}")


def test_modules_come_and_go_in_one_line(probe: Any) -> None:
    path = probe.modules / "Probe.py"
    other = probe.modules / "Other.py"
    other.write_text(PROBE.replace("Probe", "Other"))
    chain = (
        f"-l {path}:ProbeInit -u {path} -l {path}:ProbeInit -c Probe?instance_name=a"
        f" -l {other}:OtherInit -c Other?instance_name=b -d a -u {path}"
    )
    probe.ok(f"rtmgr {chain} {MANAGER}/")
    assert probe.ok("rtls /localhost").split() == ["b.rtc", "manager.mgr/"]
    lines = probe.ok(f"rtcat {MANAGER}").splitlines()
    assert f"  Filepath: {other}" in lines
    assert f"  Filepath: {path}" not in lines


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        ("-c Nix", "Failed to create component: Nix ("),
        ("-d Nix", "Failed to delete component: Nix ("),
        ("-u Nix.py", "Failed to unload module: Nix.py ("),
        ("-l Nix.py:NixInit", "Failed to load module: Nix.py:NixInit ("),
        ("-s manager.pid=1", "Failed to set configuration: manager.pid=1 ("),
    ],
)
def test_what_a_manager_refuses(manager: Any, arguments: str, why: str) -> None:
    status, out, err = manager.run(f"rtmgr {arguments} {MANAGER}")
    assert (status, out) == (1, "")
    assert err.startswith(f"rtmgr: {why}")
    assert err.count("\n") == 1


def test_a_component_that_fails_tells_why(probe: Any) -> None:
    probe.ok(f"rtmgr -c Probe -c Probe?manager_name=s1 {MANAGER}")
    for number, place in enumerate(("manager", "s1")):
        path = f"/localhost/Probe{number}.rtc"
        probe.ok(f"rtconf {path} set fail activation")
        status, _, err = probe.run(f"rtact {path}")
        assert status == 1, place
        assert "no such speed" in err
        assert probe.ok(f"rtls -l {path}").startswith("Error ")
        (cause,) = (each for each in probe.ok(f"rtcat {path}").splitlines() if "Cause" in each)
        assert "no such speed" in cause
        assert "Probe.py:" in cause
        refused = f"rtact: precondition not met (state is Error): {path}\n"
        assert probe.run(f"rtact {path}") == (1, "", refused)
        probe.ok(f"rtreset {path}")
        probe.ok(f"rtconf {path} set fail=")
        probe.ok(f"rtact {path}")


def test_a_setting_reaches_an_active_component(probe: Any) -> None:
    probe.ok(f"rtmgr -c Probe {MANAGER}")
    probe.ok("rtact /localhost/Probe0.rtc")
    probe.ok("rtconf /localhost/Probe0.rtc set fail execution")
    while probe.ok("rtls -l /localhost/Probe0.rtc").startswith("Active"):
        pass
    assert "too fast" in probe.ok("rtcat /localhost/Probe0.rtc")


def test_a_slow_transition_is_waited_for_or_not(probe: Any) -> None:
    probe.ok(f"rtmgr -c Probe -c Probe {MANAGER}/ ")
    probe.ok("rtconf /localhost/Probe0.rtc set delay 0.7")
    probe.ok("rtconf /localhost/Probe1.rtc set delay 0.7")
    probe.ok("rtact --no-wait /localhost/Probe1.rtc")
    assert probe.ok("rtls -l /localhost/Probe1.rtc").startswith("Inactive")
    status, _, err = probe.run("rtact --timeout 0.2 --exit-detail /localhost/Probe0.rtc")
    assert status == 5
    assert err.endswith(": /localhost/Probe0.rtc\n")
    probe.ok("rtact /localhost/Probe0.rtc /localhost/Probe1.rtc")
    assert probe.ok("rtls -l /localhost/Probe0.rtc").startswith("Active")


def test_a_killed_slave_leaves_zombies_with_the_reason(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleOut -c ConsoleOut?manager_name=s1 {MANAGER}")
    os.kill(told_pid(manager, "s1"), signal.SIGKILL)
    while "*" not in manager.ok("rtls /localhost"):
        pass
    line = manager.ok("rtls -l /localhost/ConsoleOut1.rtc")
    assert line == "-  -  -  -  -  *ConsoleOut1.rtc  (signal 9)\n"
    for command in ("rtact", "rtcat", "rtconf", "rtdis"):
        told = f"{command}: Zombie object: /localhost/ConsoleOut1.rtc (signal 9)"
        if command == "rtcat":
            told += "; rtvlog /localhost/ConsoleOut1.rtc shows what it logged"
        assert manager.run(f"{command} /localhost/ConsoleOut1.rtc") == (1, "", f"{told}\n")
    manager.ok(f"rtmgr -d ConsoleOut1 {MANAGER}")
    assert manager.ok("rtls /localhost").split() == ["ConsoleOut0.rtc", "manager.mgr/"]


def test_a_stopped_slave_is_marked_and_does_not_hold_up_others(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleOut -c ConsoleOut?manager_name=s1 {MANAGER}")
    pid = told_pid(manager, "s1")
    os.kill(pid, signal.SIGSTOP)
    try:
        while "(stopped)" not in manager.ok("rtls -l /localhost"):
            pass
        assert manager.ok("rtls -l /localhost/ConsoleOut1.rtc").endswith("  (stopped)\n")
        status, _, err = manager.run("rtact /localhost/ConsoleOut0.rtc /localhost/ConsoleOut1.rtc")
        assert status == 1
        assert "it is stopped: /localhost/ConsoleOut1.rtc" in err
        assert manager.ok("rtls -l /localhost/ConsoleOut0.rtc").startswith("Active")
    finally:
        os.kill(pid, signal.SIGCONT)
    while "(stopped)" in manager.ok("rtls -l /localhost"):
        pass
    manager.ok("rtact /localhost/ConsoleOut1.rtc")


def test_a_stopped_manager_is_told_in_time_and_a_wait_for_it_can_be_broken_off(
    manager: Any,
) -> None:
    pid = told_pid(manager)
    os.kill(pid, signal.SIGSTOP)
    try:
        told = "rtls: manager 'manager' does not answer within 0.3 s\n"
        assert manager.run("rtls --timeout 0.3") == (1, "", told)
        script = (
            "import os, signal, sys, threading\n"
            "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "from rtkit.cli.tree.rtls import main\n"
            "from rtkit.link import unix\n"
            "connecting = unix.connect_to_manager\n"
            "def connect_and_interrupt(path, timeout_s):\n"
            "    end = connecting(path, timeout_s)\n"
            "    os.kill(os.getpid(), signal.SIGINT)\n"
            "    return end\n"
            "unix.connect_to_manager = connect_and_interrupt\n"
            "sys.argv[0] = 'rtls'\n"
            "sys.exit(main())\n"
        )
        command = manager.command("rtls --timeout 600")
        command[2] = script
        manager.commands = None
        manager.command = lambda _: command
        assert manager.run("rtls") == (-signal.SIGINT, "", "rtls: interrupted\n")
    finally:
        del manager.__dict__["command"]
        os.kill(pid, signal.SIGCONT)


def test_a_profile_stands_in_for_a_component(manager: Any) -> None:
    profile = Path(__file__).parents[2] / "profiles"
    found = sorted(file for file in profile.rglob("*.xml") if "RtcProfile" in file.read_text())
    assert found, "no RTC profile ships"
    manager.ok(f"rtmgr -c {found[0]}?instance_name=Stand {MANAGER}")
    assert manager.ok("rtls -l /localhost/Stand.rtc").endswith("Stand.rtc  (stand-in)\n")
    manager.ok("rtact /localhost/Stand.rtc")


def test_all_commands_are_verbs_of_one(manager: Any) -> None:
    assert manager.ok("rtkit ls /localhost") == "manager.mgr/\n"
    assert manager.run("rtkit ls /no") == (
        1,
        "",
        "rtkit ls: /no: no such host: no (add it: rthost add no USER@ADDRESS)\n",
    )
    assert manager.run("rtkit sl").status == 2


def test_arguments_that_are_no_text(manager: Any) -> None:
    assert manager.run("rtls /\udcff").err.startswith("rtls: /\\udcff: no such host: \\udcff (")
    status, _, err = manager.run(f"rtmgr -c \udcff {MANAGER}")
    assert status == 1
    assert err.startswith("rtmgr: Failed to create component: \\udcff (")
    assert manager.run("rtconf /localhost/No.rtc set a \udcff").status == 1


def test_a_listing_loads_nothing_that_it_does_not_need(manager: Any) -> None:
    heavy = ("asyncio", "dataclasses", "logging", "lxml", "rich", "shutil", "socket", "subprocess")
    manager.commands = None  # what a fork has loaded, its parent had
    command = manager.command("rtls -l /localhost")
    loaded = f"print([name for name in {heavy} if name in sys.modules], file=sys.stderr)"
    command[2] = command[2].replace("sys.exit(main())", f"main(sys.argv[1:]); {loaded}")
    manager.command = lambda _: command
    assert manager.run("rtls").err == "[]\n"
    del manager.__dict__["command"]


def test_what_is_asked_for_and_is_there_otherwise(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleIn?instance_name=M%C3%B6 {MANAGER}")
    assert manager.run(f"rtmgr -c ConsoleIn?instance_name=Mö {MANAGER}") == (0, "", "")
    note = "rtmgr: note: Mö exists already, in manager: nothing was made\n"
    line = f"rtmgr -c ConsoleIn?instance_name=Mö&manager_name=s {MANAGER}"
    assert manager.run(line) == (0, "", note)
    asked = "ConsoleOut?instance_name=M%C3%B6"
    told = f"rtmgr: Failed to create component: {asked} (Mö exists already, as ConsoleIn)\n"
    assert manager.run(f"rtmgr -c {asked} {MANAGER}") == (1, "", told)
    assert manager.ok("rtls -R /localhost/manager.mgr") == ".:\nMö.rtc\n\n"


@pytest.mark.parametrize(
    ("create", "why"),
    [
        ("ConsolIn", "component type ConsolIn is not known (did you mean ConsoleIn?)"),
        ("consolein?manager_name=s", "consolein is not known (did you mean ConsoleIn?)"),
        ("Nix", "is not known; there are: Camera, ConfigSample, ConsoleIn,"),
        ("ConsoleIn?language=Klingon", "language Klingon is not supported (supported: Python)"),
        ("ConsoleIn?manager=localhost:99999", "manager address is not host:port"),
        ("ConsoleIn?manager=", "option 'manager' has no value"),
        ("ConsoleIn?instance_name=", "option 'instance_name' has no value"),
        ("ConsoleIn?instance_name=*x", "instance name begins with *, the mark of zombies: *x"),
        ("ConsoleIn?instance_name=%F6", "%F6 is no UTF-8"),
    ],
)
def test_create_strings_that_mean_nothing(manager: Any, create: str, why: str) -> None:
    outcome = manager.run(f"rtmgr -c {create} {MANAGER}")
    assert (outcome.status, outcome.out) == (1, "")
    assert outcome.err.startswith(f"rtmgr: Failed to create component: {create} (")
    assert why in outcome.err
    listing = "rtls -R /localhost/manager.mgr"  # a slave that was started for it ends behind it
    until(lambda: manager.ok(listing) == ".:\n\n", "nothing is left of it")
