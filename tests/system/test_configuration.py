"""Managers with an rtc.conf: what it makes them do, and what they tell of what it got wrong."""

from __future__ import annotations

import json
import os
import select
import signal
from typing import Any

import pytest
from waiting import told_pid

from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

MANAGER = "/localhost/manager.mgr"
SYSTEM = """
manager.components.precreate: ConsoleIn?instance_name=In0, \\
    ConsoleOut?instance_name=Out0&manager_name=s1
manager.components.preconnect: Out0.in?port=In0.out&dataflow_type=push
manager.components.preactivation: In0, Out0
naming.formats: %n.rtc, %h.host_cxt/%t/%n.rtc
exec_cxt.periodic.rate: 50
corba.nameservers: localhost
"""


def configure(shell: Any, text: str, name: str = "rtc.conf") -> None:
    (shell.folder / name).write_text(text)


def properties(shell: Any) -> dict[str, str]:
    (line,) = shell.ok(f"rtmgr -g --json {MANAGER}").splitlines()
    table: dict[str, str] = json.loads(line)["properties"]
    return table


def link(shell: Any, monkeypatch: pytest.MonkeyPatch, manager: str = "") -> Tree:
    for key, value in shell.environment.items():
        if key.startswith("RTKIT_"):
            monkeypatch.setenv(key, value)
    return connect(manager)


def test_a_whole_system_comes_up_with_its_manager(shell: Any) -> None:
    configure(shell, SYSTEM)
    shell.ok("rtmgr start")
    assert shell.ok("rtls -l /localhost/manager.mgr").splitlines() == [
        "Active  1/1  0/0  1/1  0/0  In0.rtc",
        "Active  1/1  1/1  0/0  0/0  Out0.rtc",
        "-       -    -    -    -    s1.mgr",
    ]
    host = os.uname().nodename
    assert shell.ok(f"rtls /localhost/{host}.host_cxt/ConsoleOut") == "Out0.rtc\n"
    described = json.loads(shell.ok("rtcat --json /localhost/Out0.rtc"))
    assert [context["rate"] for context in described["contexts"]] == [50.0]
    table = properties(shell)
    assert table["corba.nameservers"] == "localhost"
    assert table["exec_cxt.periodic.rate"] == "50"
    assert "net.nameservers" not in table


def test_what_fails_at_the_start_is_told_and_the_manager_runs(shell: Any) -> None:
    configure(
        shell,
        "manager.components.precreate: Nix, ConsoleIn?instance_name=In0\n"
        "manager.components.preconnect: In0.out?port=X.in\n"
        "manager.components.preactivation: In0,Y\n"
        "manager.modules.preload: no.py (noInit)\n"
        "namign.formats: %n\n",
    )
    status, out, err = shell.run("rtmgr start")
    assert (status, out) == (1, "")
    place = shell.folder / "rtc.conf"
    lines = err.splitlines()
    assert lines[0] == (
        f"rtmgr: warning: {place}:5: unknown property: namign.formats"
        " (did you mean naming.formats?)"
    )
    assert [line.partition(" (")[0] for line in lines[1:]] == [
        "rtmgr: manager.modules.preload: no.py (noInit)".partition(" (")[0],
        "rtmgr: manager.components.precreate: Nix",
        "rtmgr: manager.components.preconnect: In0.out?port=X.in",
        "rtmgr: manager.components.preactivation: Y",
        "rtmgr: manager manager runs",
    ]
    assert "component type Nix is not known" in err
    assert "no such port: X.in" in err
    assert shell.ok("rtls -l /localhost/In0.rtc").startswith("Active ")


def test_a_strict_start_leaves_nothing(shell: Any) -> None:
    configure(shell, "manager.components.precreate: ConsoleIn?manager_name=s1, Nix\n")
    status, _, err = shell.run("rtmgr start -o rtkit.start.strict:YES")
    assert status == 1
    assert err.splitlines()[-1] == ("rtmgr: the manager ends, because rtkit.start.strict is YES")
    assert shell.run("rtmgr status").status == 1
    assert list((shell.folder / "run").iterdir()) == []


@pytest.mark.parametrize(
    ("text", "options", "why"),
    [
        ("a.b: 1\nnonsense\n", "", "{folder}/rtc.conf:2: not KEY: VALUE: nonsense"),
        (
            "\n\nnaming.enable: perhaps",
            "",
            "{folder}/rtc.conf:3: naming.enable: neither YES nor NO: perhaps",
        ),
        ("", "-f absent.conf", "no such configuration file: absent.conf"),
        ("", "-o nonsense", "not KEY:VALUE: nonsense"),
        (
            "",
            "-o naming.formats:%x",
            "naming.formats: unknown %x in name template %x (known: %n %t %m %v %V %c %h %M %p %%)",
        ),
        (
            "",
            "-o corba.endpoints:0.0.0.0:2810",
            "corba.endpoints: other hosts could reach 0.0.0.0:2810, which takes TLS"
            " (net.tls, rtmgr start --tls); localhost:2810 can be had",
        ),
    ],
)
def test_a_manager_that_cannot_read_its_properties_does_not_start(
    shell: Any, text: str, options: str, why: str
) -> None:
    configure(shell, text)
    told = f"rtmgr: {why.format(folder=shell.folder)}\n"
    assert shell.run(f"rtmgr start {options}") == (1, "", told)
    assert list((shell.folder / "run").iterdir()) == []


def test_where_properties_come_from_and_who_wins(shell: Any) -> None:
    configure(shell, "manager.instance_name: folder")
    configure(shell, "manager.instance_name: environment", "env.conf")
    configure(shell, "manager.instance_name: line\nlogger.log_level: ERROR", "line.conf")
    for options, name in (
        ("", "folder"),
        ("-f line.conf", "line"),
        ("-f line.conf -o manager.instance_name:option", "option"),
        ("-i -f absent.conf", "manager"),
    ):
        shell.ok(f"rtmgr start {options}")
        shell.ok(f"rtmgr stop {name}")
    shell.environment["RTC_MANAGER_CONFIG"] = "env.conf"
    shell.ok("rtmgr start")
    shell.ok("rtmgr start typed")
    shell.ok("rtmgr stop environment")
    shell.ok("rtmgr stop typed")


def test_a_file_that_everybody_may_write_is_refused(shell: Any) -> None:
    configure(shell, "manager.name: evil")
    (shell.folder / "rtc.conf").chmod(0o666)
    told = f"rtmgr: file may be written by everybody, refused: {shell.folder}/rtc.conf\n"
    assert shell.run("rtmgr start") == (1, "", told)


@pytest.mark.parametrize(
    "line",
    [
        "rtmgr stop -f rtc.conf",
        "rtmgr -p 2811 -c ConsoleIn /localhost/manager.mgr",
        "rtmgr start -a -p 2811",
        "rtmgr start -c ConsoleIn",
    ],
)
def test_options_of_a_start_are_for_a_start(shell: Any, line: str) -> None:
    assert shell.run(line).status == 2


def test_properties_change_while_it_runs(manager: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    manager.ok(f"rtmgr -c ConsoleOut?manager_name=s1 {MANAGER}")
    manager.ok(f"rtmgr -s naming.formats=left/%n.rtc -c ConsoleIn -s naming.enable=no {MANAGER}")
    assert manager.ok("rtls /localhost/left") == "ConsoleIn0.rtc\n"
    manager.ok(f"rtmgr -c SeqIn {MANAGER}")
    assert "SeqIn0.rtc" not in manager.ok("rtls /localhost")
    assert "SeqIn0.rtc" in manager.ok(f"rtls {MANAGER}")
    manager.ok(f"rtmgr -s exec_cxt.periodic.rate=20 -c SeqOut?instance_name=Slow {MANAGER}")
    (context,) = json.loads(manager.ok(f"rtcat --json {MANAGER}/Slow.rtc"))["contexts"]
    assert context["rate"] == 20
    for text, why in (
        ("corba.endpoints=none", "takes effect only at start"),
        ("manager.pid=1", "read-only property"),
        ("nonsense=1", "unknown property: nonsense"),
        ("naming.enable=perhaps", "neither YES nor NO"),
        ("manager.cpu_affinity=4000", "cannot run on processors 4000"),
    ):
        status, out, err = manager.run(f"rtmgr -s {text} {MANAGER}")
        assert (status, out) == (1, "")
        assert err.startswith(f"rtmgr: Failed to set configuration: {text} (")
        assert why in err
    assert properties(manager)["manager.cpu_affinity"] == ""


def threads_on(pid: int) -> set[frozenset[int]]:
    tasks = os.listdir(f"/proc/{pid}/task")
    return {frozenset(os.sched_getaffinity(int(task))) for task in tasks}


def test_processors_are_those_of_all_threads_and_slaves(shell: Any) -> None:
    processor = max(os.sched_getaffinity(0))
    shell.ok(f"rtmgr start -o manager.cpu_affinity:{processor}")
    shell.ok(f"rtmgr -c ConsoleOut?manager_name=s1 -c ConsoleIn {MANAGER}")
    shell.ok("rtact /localhost/ConsoleOut0.rtc /localhost/ConsoleIn0.rtc")
    for slave in ("", "s1"):
        assert threads_on(told_pid(shell, slave)) == {frozenset({processor})}, slave


def test_what_is_logged_and_where(shell: Any) -> None:
    log = shell.folder / "more%p.log"
    shell.ok(f"rtmgr start -o logger.log_level:ERROR -o logger.file_name:{log}")
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    shell.ok(f"rtmgr -c ConsoleIn -c ConsoleOut?manager_name=s1 {MANAGER}")
    shell.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    shell.ok("rtact /localhost/ConsoleIn0.rtc /localhost/ConsoleOut0.rtc")
    shell.ok(f"rtmgr -s logger.log_level=INFO {MANAGER}")
    while '"component": "ConsoleOut0"' not in shell.log():
        pass
    shell.ok("rtmgr stop")
    assert (shell.folder / f"more{pid}.log").exists()


def test_a_component_has_files_of_its_own(shell: Any) -> None:
    configure(shell, "conf.default.speed: 3\nexec_cxt.periodic.rate: 25\n", "type.conf")
    configure(shell, "exec_cxt.periodic.rate: 75\n", "instance.conf")
    configure(
        shell,
        "exec_cxt.periodic.rate: 50\nexample.Motor.config_file: type.conf\n"
        "example.Left.config_file: instance.conf\nexample.Low.exec_cxt.periodic.rate: 5\n"
        "example.Motor.conf.default.speed: 4\n",
    )
    shell.ok("rtmgr start")
    makes = " ".join(
        f"-c Motor?instance_name={name}{more}"
        for name, more in (
            *(("Left", ""), ("Right", ""), ("Low", "")),
            ("Own", "'&exec_cxt.periodic.rate=10'"),
        )
    )
    shell.ok(f"rtmgr {makes} -c ConsoleIn?instance_name=Other {MANAGER}")
    rates = {}
    for name in ("Left", "Right", "Low", "Own", "Other"):
        (context,) = json.loads(shell.ok(f"rtcat --json /localhost/{name}.rtc"))["contexts"]
        rates[name] = context["rate"]
    assert rates == {"Left": 75, "Right": 25, "Low": 5, "Own": 10, "Other": 50}
    assert "speed     4" in shell.ok("rtconf /localhost/Low.rtc list -l")
    (shell.folder / "type.conf").chmod(0o666)
    status, _, err = shell.run(f"rtmgr -c Motor {MANAGER}")
    assert status == 1
    assert "may be written by everybody" in err


def test_a_manager_starts_again(shell: Any) -> None:
    configure(shell, SYSTEM)
    shell.ok("rtmgr start")
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    slave = told_pid(shell, "s1")
    shell.ok(f"rtmgr -c Controller?manager_name=s2 -s logger.log_level=DEBUG -d In0 {MANAGER}")
    shell.ok("rtconf /localhost/Controller0.rtc set gain 2.5")
    shell.ok("rtact /localhost/Controller0.rtc")
    before = shell.ok("rtls -lR /localhost")
    ended = os.pidfd_open(slave)
    assert shell.run("rtmgr -v restart") == (
        0,
        "",
        f"manager manager runs: pid {pid}, socket {shell.folder}/run/manager.sock\n",
    )
    assert select.select([ended], [], [], 0)[0], "its slave lives"
    os.close(ended)
    assert json.loads(shell.ok("rtmgr status --json"))["pid"] == pid
    assert shell.ok("rtls -lR /localhost") == before
    assert "2.5" in shell.ok("rtconf /localhost/Controller0.rtc get gain")
    properties = [line.split() for line in shell.ok(f"rtmgr -g {MANAGER}").splitlines()]
    assert ["logger.log_level:", "DEBUG"] in properties
    configure(shell, "nonsense")
    status, _, err = shell.run("rtmgr restart")
    assert (status, err) == (1, f"rtmgr: {shell.folder}/rtc.conf:1: not KEY: VALUE: nonsense\n")
    assert shell.run("rtmgr status").status == 1
    assert list((shell.folder / "run").iterdir()) == []


def test_a_manager_in_the_foreground_starts_again(shell: Any) -> None:
    with shell.open("rtmgr run -o manager.components.precreate:ConsoleIn") as process:
        try:
            while shell.run("rtls /localhost/ConsoleIn0.rtc").status:
                assert process.poll() is None
            shell.ok(f"rtmgr -d ConsoleIn0 {MANAGER}")
            shell.ok(f"rtmgr -c ConsoleOut {MANAGER}")
            shell.ok("rtmgr restart")
            assert shell.ok("rtls /localhost").split() == ["ConsoleOut0.rtc", "manager.mgr/"]
            process.send_signal(signal.SIGINT)
            assert process.wait(timeout=10) == 0
        finally:
            process.kill()


def test_restarting_needs_somebody_to_restart(shell: Any) -> None:
    told = "rtmgr: manager 'manager' is not running (start it with: rtmgr start)\n"
    assert shell.run("rtmgr restart") == (1, "", told)


def test_operations_from_python(manager: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    with link(manager, monkeypatch) as tree:
        assert tree.set("create_component", "ConsoleIn?instance_name=In0") == "In0"
        assert tree.get("get_components") == "In0"
        assert tree.get("get_factory_profiles").startswith("RTC:rtkit:example:ConsoleIn:Python:")
        slave = tree.set("fork", "")
        assert tree.get("get_slave_managers") == slave
        assert slave in manager.ok(f"rtls {MANAGER}")
        tree.set("delete_component", "In0")
        assert tree.get("get_components") == ""
        pidfd = os.pidfd_open(int(tree.get("manager.pid")))
        tree.set("shutdown", "")
    assert select.select([pidfd], [], [], 10)[0]
    os.close(pidfd)


def test_slaves_stay_if_the_properties_say_so(shell: Any) -> None:
    shell.ok("rtmgr start -o manager.shutdown_on_nortcs:NO")
    shell.ok(f"rtmgr -c ConsoleIn?manager_name=s1 -d ConsoleIn0 {MANAGER}")
    assert shell.ok(f"rtls {MANAGER}") == "s1.mgr/\n"
    assert shell.ok(f"rtmgr --fork --print {MANAGER}").startswith(f"{MANAGER}/manager_")
