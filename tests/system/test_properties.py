"""What the properties of a manager come to: each that has an effect shows it on real processes."""

from __future__ import annotations

import json
import os
import re
import select
import shlex
import time
from typing import Any

import pytest

from rtkit.tree.connect import connect

MANAGER = "/localhost/manager.mgr"
GATE = """
import os, signal, time
from rtkit.component import Component


class Gate(Component):
    rate = 100.0

    def pass_through(self, name):
        gate = os.path.join(os.environ["RTKIT_STATE_DIR"], name)
        while not os.path.exists(gate):
            time.sleep(0.005)

    def on_activated(self, context):
        self.pass_through("activation")

    def on_deactivated(self, context):
        self.pass_through("deactivation")

    def on_reset(self, context):
        self.pass_through("reset")

    def on_execute(self, context):
        if os.path.exists(os.path.join(os.environ["RTKIT_STATE_DIR"], "fail")):
            raise ValueError("told to")


class Deaf(Component):
    def on_initialize(self):
        signal.signal(signal.SIGTERM, signal.SIG_IGN)


class Seen(Component):
    rate = 50.0

    def on_execute(self, context):
        self.logger.info("%s on %s", context, sorted(os.sched_getaffinity(0)))


def GateInit(manager):
    for each in (Gate, Deaf, Seen):
        manager.register_factory(each)
"""


@pytest.fixture
def gates(shell: Any) -> Any:
    """A shell whose manager finds the module of this file."""
    (shell.modules / "Gate.py").write_text(GATE)
    shell.environment["RTKIT_MODULE_PATH"] = str(shell.modules)
    return shell


def start(shell: Any, *properties: str, name: str = "") -> None:
    given = " ".join(f"-o {shlex.quote(each)}" for each in properties)
    shell.ok(f"rtmgr start {name} {given}")


def known(shell: Any, path: str) -> dict[str, Any]:
    facts: dict[str, Any] = json.loads(shell.ok(f"rtcat --json {path}"))
    return facts


def state(shell: Any, path: str) -> str:
    return str(json.loads(shell.ok(f"rtls --json {path}"))["state"])


def until(shell: Any, path: str, wanted: str) -> None:
    while state(shell, path) != wanted:
        pass


def open_gate(shell: Any, name: str) -> None:
    (shell.folder / "state" / name).touch()


# what the manager is called


def test_names_of_the_manager(shell: Any) -> None:
    start(shell, "manager.naming_formats:%h.host_cxt/%n.mgr, all/%M-%p.mgr", "config.version:7")
    pid = json.loads(shell.ok("rtmgr status --json"))["pid"]
    host = os.uname().nodename
    for path in (
        MANAGER,
        f"/localhost/{host}.host_cxt/manager.mgr",
        f"/localhost/all/manager-{pid}.mgr",
    ):
        shell.ok(f"rtmgr -c ConsoleIn {path}")
        assert known(shell, path)["pid"] == pid
        assert "ConsoleIn0.rtc" in shell.ok(f"rtls {path}")
    assert known(shell, MANAGER)["properties"]["config.version"] == "7"


def test_an_id_in_direct_addresses(shell: Any) -> None:
    start(shell, "net.endpoints::0", "manager.name:robot", name="manager")
    address = json.loads(shell.ok("rtmgr status --json"))["address"]
    shell.ok(f"rtmgr -c ConsoleIn corbaloc::{address}/robot")
    status, _, err = shell.run(f"rtmgr -c ConsoleIn corbaloc::{address}/horse")
    assert (status, "not horse" in err) == (1, True)


def test_an_identity_is_read_only(manager: Any) -> None:
    properties = known(manager, MANAGER)["properties"]
    assert properties["openrtm.name"] == "rtkit"
    assert properties["os.hostname"] == os.uname().nodename
    for key in ("openrtm.name", "openrtm.version", "manager.supported_languages", "os.name"):
        status, _, err = manager.run(f"rtmgr -s {key}=x {MANAGER}")
        assert (status, "read-only property" in err) == (1, True)


def test_no_door(shell: Any) -> None:
    start(shell, "corba.master_manager:localhost:2999", "manager.corba_servant:NO")
    assert json.loads(shell.ok("rtmgr status --json"))["address"] == ""


@pytest.mark.parametrize("is_repeated", ["YES", "NO"])
def test_a_slave_manager_registers_again_and_again_or_once(
    shell: Any, monkeypatch: pytest.MonkeyPatch, is_repeated: str
) -> None:
    start(shell, "net.endpoints::0", name="master")
    address = json.loads(shell.ok("rtmgr status --json master"))["address"]
    start(
        shell,
        "manager.is_master:NO",
        f"net.master_manager:{address}",
        f"manager.update_master_manager.enable:{is_repeated}",
        "corba.update_master_manager.interval:0.05",
        name="slave",
    )
    for key in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR"):
        monkeypatch.setenv(key, shell.environment[key])
    with connect("master") as master:
        while master.get("get_slave_managers") != "slave":
            pass
        master.set("remove_slave_manager", "slave")
        if is_repeated == "YES":
            while master.get("get_slave_managers") != "slave":
                pass
        else:
            end = time.monotonic() + 0.5  # ten times the interval
            while time.monotonic() < end:
                assert master.get("get_slave_managers") == ""


# components


def test_chosen_names_are_new_on_the_node(shell: Any) -> None:
    start(shell, "manager.components.naming_policy:node_unique")
    start(shell, name="other")
    shell.ok("rtmgr -c ConsoleIn -c ConsoleIn /localhost/other.mgr")
    shell.ok(f"rtmgr -c ConsoleIn -c ConsoleIn {MANAGER}")
    assert shell.ok(f"rtls {MANAGER}").split() == ["ConsoleIn2.rtc", "ConsoleIn3.rtc"]
    shell.ok(f"rtmgr -c ConsoleIn?instance_name=ConsoleIn0 {MANAGER}")  # wished, so not chosen
    shell.ok(f"rtmgr -s manager.components.naming_policy=process_unique -c ConsoleIn {MANAGER}")
    assert "ConsoleIn1.rtc" in shell.ok(f"rtls {MANAGER}")
    shell.ok(f"rtmgr -s manager.components.naming_policy=ns_unique -c ConsoleIn {MANAGER}")
    assert "ConsoleIn4.rtc" in shell.ok(f"rtls {MANAGER}")


def test_modules_before_others(gates: Any) -> None:
    more = gates.folder / "more"
    more.mkdir()
    (more / "Late.py").write_text(GATE.replace("GateInit", "LateInit").replace("Gate", "Late"))
    start(
        gates,
        f"manager.modules.Python.load_paths:{more}",
        "manager.modules.preload:Late.py",
        "manager.preload.modules:Gate.py (GateInit)",
        "manager.components.precreate:Gate,Late",
    )
    assert "  Filepath: Gate.py\n  Filepath: Late.py\n" in gates.ok(f"rtcat {MANAGER}")
    assert gates.ok(f"rtls {MANAGER}").split() == ["Gate0.rtc", "Late0.rtc"]


def test_contexts_of_components(shell: Any) -> None:
    start(
        shell,
        "execution_contexts:PeriodicExecutionContext(fast),EventDrivenExecutionContext(late)",
        "ec.fast.rate:25",
        "ec.late.note:mine",
    )
    shell.ok(f"rtmgr -c ConsoleOut {MANAGER}")
    fast, late = known(shell, "/localhost/ConsoleOut0.rtc")["contexts"]
    assert (fast["id"], fast["kind"], fast["rate"]) == ("fast", "PERIODIC", 25.0)
    assert (late["id"], late["kind"], late["properties"]) == (
        "late",
        "EVENT_DRIVEN",
        {"note": "mine"},
    )
    shell.ok(f"rtmgr -s execution_contexts= {MANAGER}")
    shell.ok(f"rtmgr -s exec_cxt.periodic.type=ExtTrigExecutionContext -c ConsoleOut {MANAGER}")
    (context,) = known(shell, "/localhost/ConsoleOut1.rtc")["contexts"]
    assert context["kind"] == "OTHER"


def test_ports_have_defaults(shell: Any) -> None:
    start(shell, "port.inport.dataport.subscription_type:flush", "port.note:ours")
    shell.ok(f"rtmgr -c ConsoleOut -c ConsoleIn {MANAGER}")
    into = known(shell, "/localhost/ConsoleOut0.rtc:in")["properties"]
    out = known(shell, "/localhost/ConsoleIn0.rtc:out")["properties"]
    assert (into["dataport.subscription_type"], into["port.note"]) == ("flush", "ours")
    assert (out["dataport.subscription_type"], out["port.note"]) == ("flush,new,periodic", "ours")


@pytest.mark.parametrize("place", ["", "&manager_name=s1"])
def test_processors_of_contexts(gates: Any, place: str) -> None:
    one, *others = sorted(os.sched_getaffinity(0))
    start(gates, f"exec_cxt.cpu_affinity:{one}")
    contexts = "execution_contexts=PeriodicExecutionContext(a),PeriodicExecutionContext(b)"
    own = f"&ec.b.cpu_affinity={others[-1]}" if others else ""
    create = f"Seen?{contexts}{own}{place}"
    gates.ok(f"rtmgr -l Gate.py:GateInit -c '{create}' {MANAGER}")
    gates.ok("rtact -e all /localhost/Seen0.rtc")
    wanted = {f"a on [{one}]", f"b on [{others[-1] if others else one}]"}
    while not all(f'"message": "{text}"' in gates.log() for text in wanted):
        pass
    status, _, err = gates.run(f"rtmgr -c 'Seen?exec_cxt.cpu_affinity=4000{place}' {MANAGER}")
    assert status == 1
    assert "exec_cxt.cpu_affinity: no such processors: 4000" in err


# transitions


@pytest.mark.parametrize("key", ["exec_cxt.sync_{word}", "exec_cxt.sync_transition"])
def test_transitions_are_not_waited_for(gates: Any, key: str) -> None:
    start(gates, *(key.format(word=each) + ":NO" for each in ("activation", "deactivation")))
    gates.ok(f"rtmgr -s {key.format(word='reset')}=NO -l Gate.py:GateInit -c Gate {MANAGER}")
    path = "/localhost/Gate0.rtc"
    for command, word, before, after in (
        ("rtact", "activation", "Inactive", "Active"),
        ("rtdeact", "deactivation", "Active", "Inactive"),
        ("rtact", "activation", "Inactive", "Active"),
        ("rtreset", "reset", "Error", "Inactive"),
    ):
        if command == "rtreset":
            open_gate(gates, "fail")
            until(gates, path, "Error")
        gates.ok(f"{command} {path}")
        if not (gates.folder / "state" / word).exists():
            assert state(gates, path) == before
        open_gate(gates, word)
        until(gates, path, after)


@pytest.mark.parametrize("key", ["exec_cxt.{word}_timeout", "exec_cxt.transition_timeout"])
def test_transitions_are_waited_for_so_long(gates: Any, key: str) -> None:
    words = ("activation", "deactivation", "reset")
    start(gates, *dict.fromkeys(f"{key.format(word=word)}:0.05" for word in words))
    gates.ok(f"rtmgr -l Gate.py:GateInit -c Gate {MANAGER}")
    path = "/localhost/Gate0.rtc"
    for command, word, after in (
        ("rtact", "activation", "Active"),
        ("rtdeact", "deactivation", "Inactive"),
        ("rtreset", "reset", "Inactive"),
    ):
        if command == "rtreset":
            gates.ok(f"rtact {path}")
            open_gate(gates, "fail")
            until(gates, path, "Error")
        status, _, err = gates.run(f"{command} --timeout 600 --exit-detail {path}")
        assert (status, err.count("\n")) == (5, 1)
        open_gate(gates, word)
        until(gates, path, after)


# ends


def test_a_slave_in_which_nothing_is_made_ends(shell: Any) -> None:
    start(shell, "manager.auto_shutdown_duration:0.05")
    slave = shell.ok(f"rtmgr --fork --print {MANAGER}").strip()
    while shell.run(f"rtls {slave}").status == 0:
        pass
    shell.ok(f"rtmgr -s manager.shutdown_auto=NO {MANAGER}")
    kept = shell.ok(f"rtmgr --fork --print {MANAGER}").strip()
    end = time.monotonic() + 0.5  # ten times the duration
    while time.monotonic() < end:
        shell.ok(f"rtls {kept}")


def test_a_slave_that_does_not_hear_is_killed_after_a_grace(gates: Any) -> None:
    start(gates, "manager.termination_waittime:600")
    gates.ok(f"rtmgr -l Gate.py:GateInit -c Deaf?manager_name=s1 {MANAGER}")
    pidfd = os.pidfd_open(known(gates, f"{MANAGER}/s1.mgr")["pid"])
    assert gates.run(f"rtmgr --timeout 0.5 -d Deaf0 {MANAGER}").status == 1
    assert not select.select([pidfd], [], [], 0)[0]
    os.close(pidfd)
    gates.ok(f"rtmgr -s manager.termination_waittime=0.05 {MANAGER}")
    gates.ok("rtmgr stop")


# logs


def test_nothing_is_logged(gates: Any) -> None:
    start(gates, "logger.enable:NO")
    gates.ok(f"rtmgr -l Gate.py:GateInit -c Seen {MANAGER}")
    gates.ok("rtact /localhost/Seen0.rtc")
    gates.ok("rtdeact /localhost/Seen0.rtc")
    assert "Seen0" not in (gates.folder / "state" / "manager.log").read_text()
    gates.ok(f"rtmgr -s logger.enable=YES {MANAGER}")
    gates.ok("rtact /localhost/Seen0.rtc")
    while '"component": "Seen0"' not in gates.log():
        pass


@pytest.mark.parametrize("is_coloured", ["YES", "NO"])
def test_how_a_further_log_looks(gates: Any, is_coloured: str) -> None:
    log = gates.folder / "more.log"
    start(
        gates,
        f"logger.file_name:{log}",
        "logger.date_format:<%Y>",
        f"logger.escape_sequence_enable:{is_coloured}",
    )
    gates.ok(f"rtmgr -l Gate.py:GateInit -c Gate {MANAGER}")
    for gate in ("activation", "fail"):
        open_gate(gates, gate)
    gates.ok("rtact /localhost/Gate0.rtc")
    until(gates, "/localhost/Gate0.rtc", "Error")
    pattern = r"(\x1b\[1;31m)?<\d{4}> ERROR manager/Gate0: .*told to"
    while not (found := re.search(pattern, log.read_text())):
        pass
    assert bool(found[1]) == (is_coloured == "YES")


# what has no effect


def test_what_has_no_effect_is_told(shell: Any) -> None:
    text = "timer.tick: 0.5\nnaming.type: corba\ncorba.nameservers: far\nopenrtm.name: mine\n"
    (shell.folder / "rtc.conf").write_text(text)
    place = shell.folder / "rtc.conf"
    assert shell.run("rtmgr start -o logger.plugins:fluentd") == (
        0,
        "",
        f"rtmgr: warning: {place}:1: timer.tick has no effect: nothing is polled\n"
        f"rtmgr: warning: {place}:3: corba.nameservers has no effect: there is no name server:"
        " each manager keeps the names\n"
        f"rtmgr: warning: {place}:4: openrtm.name is read-only: the implementation\n"
        "rtmgr: warning: logger.plugins has no effect: logs are files, one JSON object a line\n",
    )
    told = "rtmgr: warning: timer.tick has no effect: nothing is polled\n"
    assert shell.run(f"rtmgr -s timer.tick=0.7 {MANAGER}") == (0, "", told)
    assert known(shell, MANAGER)["properties"]["timer.tick"] == "0.7"
    assert known(shell, MANAGER)["properties"]["openrtm.name"] == "rtkit"


# operations


def test_operations_from_the_shell(manager: Any) -> None:
    def ask(name: str) -> str:
        return str(manager.ok(f"rtconf {MANAGER} get {name}")).rstrip("\n")

    def do(name: str, argument: str) -> None:
        manager.ok(f"rtconf {MANAGER} set {name} '{argument}'")

    do("create_component", "ConsoleIn?instance_name=In0")
    assert ask("get_components") == "In0"
    assert ask("get_component_profiles").startswith("In0?type_name=ConsoleIn&")
    assert "RTC:rtkit:example:ConsoleIn:Python:1.0" in ask("get_factory_profiles")
    assert "RTC:rtkit:example:ConsoleOut:Python:1.0" in ask("get_loadable_modules")
    do("load_module", "ConsoleOut.py?init=ConsoleOutInit")
    found, asked = "ConsoleIn.py?init=ConsoleInInit", "ConsoleOut.py?init=ConsoleOutInit"
    assert ask("get_loaded_modules").splitlines() == [found, asked]
    do("unload_module", "ConsoleOut.py")
    assert ask("get_loaded_modules") == found
    assert "os.name: Linux" in ask("get_profile").splitlines()
    do("set_configuration", "exec_cxt.periodic.rate: 5")
    assert "exec_cxt.periodic.rate: 5" in ask("get_configuration").splitlines()
    assert ask("is_master") == "YES"
    do("add_master_manager", "localhost:2999")
    assert ask("get_master_managers") == "localhost:2999"
    do("remove_master_manager", "localhost:2999")
    do("fork", "s1")
    assert ask("get_slave_managers") == "s1"
    do("delete_component", "In0")
    assert ask("get_components") == ""
    status, _, err = manager.run(f"rtconf {MANAGER} set get_service x")
    assert (status, err) == (1, "rtconf: the manager has no service x\n")
