"""The operations of a manager, its properties, and what they do to components."""

from __future__ import annotations

import json

import pytest
from fake_shell import OWN, FakeShell, facts

from rtkit.deployment.actions import ChangeState, Create
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.manager.core import events as ev
from rtkit.manager.core import manager_properties, operations
from rtkit.manager.query_server import ManagerQueryServer
from rtkit.property.exchange import Reply, Request
from rtkit.rtc.enums import Transition
from rtkit.settings.properties import Settings


class Client:
    """Asks a core for properties, as the loop would let it."""

    def __init__(self, shell: FakeShell) -> None:
        self.shell = shell
        self.query_server = ManagerQueryServer(shell.state, shell.requests)

    def ask(self, name: str, payload: str | None = None) -> list[Reply]:
        replies: list[Reply] = []
        event = self.query_server.take(Request(name, payload, replies.append))
        if event is not None:
            self.shell.feed(event)
        return replies

    def get(self, name: str) -> str:
        (reply,) = self.ask(name)
        return reply.value()

    def set(self, name: str, value: str) -> str:
        replies = self.ask(name, value)
        self.shell.serve()
        return replies[0].value()


@pytest.fixture
def client(shell):
    return Client(shell)


def test_components_come_and_go_by_operations(client):
    assert client.set("create_component", "Thing?instance_name=A") == "A"
    assert client.set("create_component", "Thing") == "Thing0"
    assert client.get("get_components") == "A\nThing0"
    assert client.get("get_component_profiles").splitlines()[0] == (
        "A?type_name=Thing&language=Python&manager=manager&naming.names=localhost/A.rtc"
    )
    assert client.get("get_factory_profiles") == "RTC:::Thing:Python:"
    client.set("delete_component", "A")
    assert client.get("get_components") == "Thing0"
    with pytest.raises(NotFound, match="no component named A"):
        client.set("delete_component", "A")


def test_modules_come_and_go_by_operations(client, shell):
    assert client.set("load_module", "a.py?init=aInit") == "a.py"
    assert client.get("get_loaded_modules") == "a.py?init=aInit"
    client.set("unload_module", "a.py")
    assert client.get("get_loaded_modules") == ""
    with pytest.raises(NotFound):
        client.set("unload_module", "a.py")
    with pytest.raises(ValueError, match="not PATH"):
        client.set("load_module", "a.py?function=x")


def test_components_by_name(client, shell):
    shell.make("A")
    for argument, found in (("A", "A"), ("*/A", "A"), ("Sensors/A", ""), ("/A", "A"), ("B", "")):
        assert client.set("get_components_by_name", argument) == found, argument


def test_a_fork_is_a_slave_without_components(client, shell):
    replies = client.ask("fork", "")
    key = shell.fork("manager_%p", 77)
    assert replies[0].value() == "manager_77"
    assert shell.state.processes[key].is_alive
    replies = client.ask("fork", "left")
    shell.fork("left")
    assert replies[0].value() == "left"
    with pytest.raises(Refused, match="there is a slave named left already"):
        client.set("fork", "left")
    assert client.get("get_slave_managers") == "manager_77\nleft"


def test_a_fork_in_which_nothing_is_made_ends(client, shell):
    client.ask("fork", "idle")
    idle = shell.fork("idle")
    client.ask("fork", "used")
    used = shell.fork("used")
    shell.make("A", "used")
    shell.wait(19.9)
    assert shell.state.processes[idle].is_wanted
    shell.wait(0.2)
    assert not shell.state.processes[idle].is_wanted
    assert shell.state.processes[used].is_wanted


@pytest.mark.parametrize(
    ("key", "value"),
    [("manager.shutdown_auto", "NO"), ("manager.shutdown_on_nortcs", "NO")],
)
def test_a_fork_stays_if_the_properties_say_so(client, shell, key, value):
    client.set(key, value)
    client.ask("fork", "idle")
    idle = shell.fork("idle")
    shell.wait(3600)
    assert shell.state.processes[idle].is_wanted


def test_other_managers_register_and_take_themselves_off(client, monkeypatch):
    monkeypatch.setattr("rtkit.manager.query_server.managers", lambda: ["two"])
    for name in ("two", "two", "dead", "localhost:2811"):
        client.set("add_slave_manager", name)
    assert client.get("get_slave_managers") == "two\nlocalhost:2811"
    client.set("remove_slave_manager", "two")
    assert client.get("get_slave_managers") == "localhost:2811"
    with pytest.raises(NotFound):
        client.set("remove_slave_manager", "two")
    client.set("add_master_manager", "localhost:2810")
    assert client.get("get_master_managers") == "localhost:2810"
    with pytest.raises(ValueError, match="not a manager"):
        client.set("add_slave_manager", " ")


def test_what_can_only_be_read_and_what_only_be_set(client):
    with pytest.raises(Refused, match="read-only property: is_master"):
        client.set("is_master", "NO")
    with pytest.raises(Refused, match="is an operation"):
        client.get("fork")
    with pytest.raises(NotFound, match="no such property: nonsense"):
        client.get("nonsense")
    with pytest.raises(NotFound, match="no service"):
        client.set("get_service", "x")


@pytest.mark.parametrize(
    "name", ["localhost", "127.0.0.1", "..", "*", "-x", "a/b", "a:1", "x" * 65, "here", ""]
)
def test_a_link_to_what_can_be_no_other_host_is_refused(client, shell, name):
    shell.state.host = "here.local"
    with pytest.raises((Refused, Malformed)):
        client.set("link_host", json.dumps({"name": name}))
    with pytest.raises(Malformed):
        client.set("link_host", "[]")
    client.set("link_host", '{"name": "robot1"}')
    assert client.get("get_hosts") == "robot1"


def test_the_table_of_operations_is_that_of_the_interface():
    named = """load_module unload_module get_loaded_modules get_factory_profiles create_component
        delete_component get_components get_component_profiles get_components_by_name get_profile
        get_configuration set_configuration is_master get_master_managers add_master_manager
        remove_master_manager get_slave_managers add_slave_manager remove_slave_manager fork
        get_service rtkit.follow get_hosts link_host unlink_host expect expect_no_more
        get_fences fence own"""
    assert {*operations.READ, *operations.DO} == set(named.split())
    assert not operations.READ.keys() & operations.DO.keys()


@pytest.mark.parametrize("word", ["stop", "shutdown", "restart"])
def test_words_that_end_it(client, shell, word):
    assert client.ask(word, "")[0].value() == "100"
    assert shell.is_finished
    assert (client.query_server.restart is not None) is (word == "restart")


# properties


def test_properties_are_read_under_both_names(client, shell):
    shell.state.settings.take("corba.endpoints", ":2811")
    assert client.get("net.endpoints") == client.get("corba.endpoints") == ":2811"
    assert client.get("naming.formats") == "%n.rtc"
    table = dict(line.split(": ", 1) for line in client.get("get_configuration").splitlines())
    assert table["corba.endpoints"] == ":2811"
    assert table["exec_cxt.periodic.rate"] == "1000"
    shell.state.properties["os.name"] = "Linux"
    profile = client.get("get_profile").splitlines()
    assert {"manager.modules.load_path: /", "os.name: Linux"} <= {*profile}


def test_a_change_is_told_to_the_processes_that_it_concerns(client, shell):
    key = shell.make("A", "s")
    shell.told.clear()
    assert client.set("naming.formats", "x/%n.rtc") == "x/%n.rtc"
    assert not shell.told
    assert client.set("set_configuration", "logger.log_level: debug") == "DEBUG"
    assert [(each, told["log_level"]) for each, told in shell.told] == [(key, "DEBUG")]
    other = shell.make("B", "t")
    assert [each for each, told in shell.told if told["op"] == "configure"] == [key, other]


def test_a_change_that_the_manager_itself_cannot_make_is_taken_back(client, shell):
    shell.make("A", "s")
    shell.told.clear()
    replies = client.ask("manager.cpu_affinity", "999")
    shell.refuse(shell.next("configure"), Refused("cannot run on processors 999"))
    with pytest.raises(Refused, match="cannot run"):
        replies[0].value()
    assert client.get("manager.cpu_affinity") == ""
    assert not shell.told


@pytest.mark.parametrize("key", ["manager.pid", "openrtm.version", "net.endpoints", "no.such"])
def test_what_cannot_be_changed(client, shell, key):
    shell.state.properties["manager.pid"] = "100"
    before = manager_properties.table(shell.state)
    with pytest.raises((Refused, NotFound)):
        client.set(key, "1")
    assert manager_properties.table(shell.state) == before


def test_load_paths_are_meant_from_the_folder_of_the_start(shell):
    shell.state.folder, shell.state.base_paths = "/home/me", ("/samples",)
    assert manager_properties.load_paths(shell.state) == ["/home/me", "/samples"]
    shell.state.settings = Settings(
        {"manager.modules.load_path": "./a, /b, ../c", "manager.modules.Python.load_paths": "/b,d"}
    )
    paths = ["/home/me/a", "/b", "/home/c", "/home/me/d", "/samples"]
    assert manager_properties.load_paths(shell.state) == paths


# what they do to components


def names(shell, instance):
    return shell.state.components[instance].names


def test_names_are_given_by_templates(shell):
    shell.state.settings.take("naming.formats", "%h.host_cxt/%n.rtc,%M/%n.rtc")
    shell.make("A")
    assert names(shell, "A") == ("localhost/host.host_cxt/A.rtc", "localhost/manager/A.rtc")


def test_templates_may_need_what_is_only_known_later(shell):
    shell.state.settings.take("naming.formats", "%n.rtc,%t-%p.rtc")
    key = shell.make("A", "s")
    pid = shell.state.processes[key].pid
    assert names(shell, "A") == ("localhost/A.rtc", f"localhost/Thing-{pid}.rtc")
    ((_, told),) = [each for each in shell.told if each[1]["op"] == "remember"]
    assert told["kept"]["names"] == list(names(shell, "A"))


def test_a_component_may_bring_its_own_template(shell):
    shell.ask(Create("Thing?instance_name=A&naming.formats=%25t/%25n.rtc"))
    shell.serve()
    assert names(shell, "A") == ("localhost/Thing/A.rtc",)


def test_a_late_name_that_is_taken_leaves_no_component(shell):
    shell.state.settings.take("naming.formats", "%t.rtc")
    shell.make("A")
    asked = shell.ask(Create("Thing?instance_name=B"))
    shell.serve()
    assert asked.result.why == "name /localhost/Thing.rtc is taken by A"
    shell.serve()
    assert list(shell.state.components) == ["A"]


def test_free_names_are_those_whose_early_names_are_free(shell):
    shell.state.settings.take("naming.formats", "all/%n.rtc")
    shell.ask(Create("Thing?instance_name=X", ("localhost/all/Thing0.rtc",)))
    shell.serve()
    asked = shell.ask(Create("Thing"))
    shell.serve()
    assert asked.result.value == "Thing1"


def test_without_naming_a_component_has_no_name(shell):
    shell.state.settings.take("naming.enable", "NO")
    shell.make("A")
    assert names(shell, "A") == ()


def test_a_bad_template_of_a_component_is_refused(shell):
    asked = shell.ask(Create("Thing?instance_name=A&naming.formats=%25x"))
    assert "unknown %x" in asked.result.why
    assert not shell.state.claims


def test_components_are_told_what_they_inherit(shell):
    shell.state.folder = "/home/me"
    for key, value in (
        ("exec_cxt.periodic.rate", "50"),
        ("port.inport.dataport.buffer.length", "4"),
        ("manager.components.precreate", "X"),
        ("Sensors.A.config_file", "a.conf"),
    ):
        shell.state.settings.take(key, value)
    asked = shell.ask(Create("Thing?instance_name=A"))
    call = shell.next("create")
    assert call.message["inherited"] == {
        "exec_cxt.periodic.rate": "50",
        "port.inport.dataport.buffer.length": "4",
    }
    assert call.message["config_files"] == {"Sensors.A": "/home/me/a.conf"}
    shell.say(OWN, facts=facts("A"))
    shell.reply(call)
    assert asked.result.ok
    assert shell.state.components["A"].create == "Thing?instance_name=A"


@pytest.mark.parametrize(
    ("given", "own", "transition", "waits", "bound_s"),
    [
        ({}, "", Transition.ACTIVATE, True, 10.0),
        ({"exec_cxt.sync_transition": "NO"}, "", Transition.RESET, False, 10.0),
        ({"exec_cxt.sync_activation": "NO"}, "", Transition.DEACTIVATE, True, 10.0),
        ({"exec_cxt.sync_activation": "NO"}, "", Transition.ACTIVATE, False, 10.0),
        (
            {"exec_cxt.sync_activation": "NO"},
            "&exec_cxt.sync_activation=yes",
            Transition.ACTIVATE,
            True,
            10.0,
        ),
        ({"exec_cxt.transition_timeout": "0.5"}, "", Transition.ACTIVATE, True, 0.5),
        (
            {"exec_cxt.transition_timeout": "0.5", "exec_cxt.reset_timeout": "3"},
            "",
            Transition.RESET,
            True,
            3.0,
        ),
        ({}, "&exec_cxt.activation_timeout=2", Transition.ACTIVATE, True, 2.0),
    ],
)
def test_how_transitions_are_waited_for(shell, given, own, transition, waits, bound_s):
    for key, value in given.items():
        shell.state.settings.take(key, value)
    shell.ask(Create(f"Thing?instance_name=A{own}"))
    shell.serve()
    asked = shell.ask(ChangeState("A", "0", transition))
    assert shell.next("change_state").message["wait"] is waits
    assert shell.wake_at == shell.now + bound_s
    shell.wait(bound_s)
    assert asked.result.kind == "unreachable"


def test_slaves_stay_if_they_are_to(shell, client):
    shell.state.settings.take("manager.shutdown_on_nortcs", "NO")
    shell.make("A", "s")
    client.set("delete_component", "A")
    assert not shell.signals
    shell.state.settings.take("manager.shutdown_on_nortcs", "YES")
    shell.make("B", "s")
    client.ask("delete_component", "B")
    shell.serve()
    assert shell.signals


def test_the_grace_of_slaves_is_a_property(shell):
    shell.state.settings.take("manager.termination_waittime", "7")
    key = shell.make("A", "s")
    shell.stop()
    shell.serve()
    shell.wait(6.9)
    assert not shell.killed()
    shell.wait(0.2)
    assert shell.killed() == [key]


def test_a_found_slave_is_told_of_properties(shell):
    shell.state.settings.take("logger.log_level", "ERROR")
    shell.feed(ev.SlaveFound(321, "old", [], []))
    assert [told["log_level"] for _, told in shell.told if told["op"] == "configure"] == ["ERROR"]
