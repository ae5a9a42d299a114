"""What commands ask of a manager, and what they leave alone."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.cli.components.rtact import main as rtact
from rtkit.cli.managers.rtmgr import main as rtmgr
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.rtc.enums import LifeCycleState, PortType, ReturnCode, Transition
from rtkit.rtc.profiles import PortRef

Run = Callable[[str], Any]
STD, INPUT, OUTPUT = (
    "/localhost/Std0.rtc",
    "/localhost/Input0.rtc",
    "/localhost/local.host_cxt/Output0.rtc",
)


class Batches:
    """A tree that remembers the batches that went through it."""

    def __init__(self, world: FakeManager, monkeypatch: pytest.MonkeyPatch) -> None:
        self.sent: list[tuple[int, bool]] = []
        self.tree = fake_tree(world)
        apply = self.tree.apply

        def remember(actions: Any, **settings: Any) -> Any:
            self.sent.append((len(actions), settings.get("is_ordered", True)))
            return apply(actions, **settings)

        monkeypatch.setattr(self.tree, "apply", remember)


@pytest.fixture
def batches(world: FakeManager, monkeypatch: pytest.MonkeyPatch) -> Batches:
    return Batches(world, monkeypatch)


def test_components_are_activated_in_one_unordered_batch(
    world: FakeManager, batches: Batches
) -> None:
    assert rtact([STD, OUTPUT, INPUT], tree=batches.tree) == 0
    assert batches.sent == [(3, False)]
    assert [world.state_of(name) for name in ("Std0", "Output0", "Input0")] == ["Active"] * 3


def test_the_default_context_is_the_first_one_only(world: FakeManager, run: Run) -> None:
    assert run(f"rtact {INPUT}").status == 0
    assert world.performed == [act.ChangeState("Input0", "0", Transition.ACTIVATE, True)]


def test_a_context_is_chosen_by_its_place(world: FakeManager, run: Run) -> None:
    assert run(f"rtact -e 1 --no-wait {INPUT}").status == 0
    assert world.performed == [act.ChangeState("Input0", "slow", Transition.ACTIVATE, False)]


def test_all_contexts_are_addressed_by_all(world: FakeManager, run: Run) -> None:
    assert run(f"rtact -e all {INPUT}").status == 0
    states = [context.state for context in world.components["Input0"].contexts]
    assert states == [LifeCycleState.ACTIVE] * 2


def test_a_component_without_context_has_none_to_activate(world: FakeManager, run: Run) -> None:
    world.update("Std0", contexts=())
    told = f"rtact: Bad execution context index: 0 ({STD} has 0)\n"
    assert run(f"rtact {STD}").err == told
    assert run(f"rtact -e all {STD}").err == told


@pytest.mark.parametrize(
    "line",
    [
        f"rtact {STD} {INPUT}/",
        f"rtact {STD} {INPUT}:in",
        f"rtact {STD} /localhost/No.rtc",
        f"rtact {STD} /localhost",
        f"rtact -e 1 {INPUT} {STD}",
        f"rtcon {STD}:out {INPUT}:in /localhost/Text0.rtc:in",
        f"rtcon -p x {STD}:out {INPUT}:in",
        f"rtconf {STD} set param=1 no=2",
        "rtmgr -c Std -l /mods/a.py /localhost/manager.mgr",
        "rtmgr -c Std -c x?y /localhost/manager.mgr",
        "rtmgr -c Std -s x /localhost/manager.mgr",
        "rtmgr -c Std -c nothing.xml /localhost/manager.mgr",
    ],
)
def test_nothing_changes_when_a_part_of_the_line_is_wrong(
    world: FakeManager, run: Run, line: str
) -> None:
    assert run(line).status != 0
    assert world.performed == []


def test_one_refusal_does_not_keep_others_from_the_state(world: FakeManager, run: Run) -> None:
    assert run(f"rtact /localhost/Err0.rtc {STD}").status == 1
    assert world.state_of("Std0") == "Active"


# wiring


def test_a_connector_has_the_defaults_and_its_out_port_first(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i id -p a.b=c=d {STD}:in {OUTPUT}:out").status == 0
    wire = world.connectors["id"]
    assert wire.name == "in_out"
    assert wire.ports == (PortRef("Output0", "out"), PortRef("Std0", "in"))
    assert wire.properties == {
        "dataport.dataflow_type": "push",
        "dataport.interface_type": "zenoh",
        "dataport.subscription_type": "new",
        "dataport.data_type": "IDL:RTC/TimedLong:1.0",
        "a.b": "c=d",
    }


def test_a_service_connector_says_that_it_is_one(world: FakeManager, run: Run) -> None:
    assert run("rtcon -n calls /localhost/Adder0.rtc:offer /localhost/User0.rtc:need").status == 0
    (wire,) = world.connectors.values()
    assert (wire.name, wire.properties) == ("calls", {"port.port_type": "CorbaPort"})


def test_each_connector_gets_an_id_of_its_own(world: FakeManager, run: Run) -> None:
    for _ in range(2):
        assert run(f"rtcon {STD}:out {INPUT}:in").status == 0
    assert len(world.connectors) == 2


def test_more_ports_are_each_connected_to_the_first(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i w {STD}:out {INPUT}:in {STD}:in /localhost/Err0.rtc:in").status == 0
    made = {name: wire.ports[1] for name, wire in world.connectors.items()}
    assert made == {
        "w": PortRef("Input0", "in"),
        "w-2": PortRef("Std0", "in"),
        "w-3": PortRef("Err0", "in"),
    }


def test_either_all_connectors_are_made_or_none(world: FakeManager, run: Run) -> None:
    world.fault = lambda action: (
        Result(ReturnCode.ERROR, "refused", "the port is full")
        if isinstance(action, act.Connect) and action.connector.connector_id == "w-2"
        else None
    )
    outcome = run(f"rtcon -i w {STD}:out {INPUT}:in {STD}:in")
    assert outcome == (1, "", "rtcon: Failed to make connection: RTC_ERROR (the port is full)\n")
    assert world.connectors == {}


def test_a_connection_that_was_there_survives_a_failure(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i w {STD}:out {INPUT}:in").status == 0
    assert run(f"rtcon -i w-2 {STD}:out /localhost/Err0.rtc:in").status == 0
    assert run(f"rtcon -i w {STD}:out {INPUT}:in {STD}:in").status == 1
    assert sorted(world.connectors) == ["w", "w-2"]


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ("", f"An identical connection already exists between {STD}:out and {INPUT}:in"),
        ("-i w", f"An identical connection already exists between {STD}:out and {INPUT}:in"),
    ],
)
def test_no_duplicates_of_the_same_ports(run: Run, options: str, why: str) -> None:
    assert run(f"rtcon -i w {STD}:out {INPUT}:in").status == 0
    assert run(f"rtcon -d {options} {STD}:out {INPUT}:in") == (1, "", f"rtcon: {why}\n")


def test_no_duplicates_of_id_or_name(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i w -n wire {STD}:out {INPUT}:in").status == 0
    other = f"{STD}:out {STD}:in"
    assert run(f"rtcon -d -i w {other}").err == "rtcon: A connection with ID w already exists\n"
    taken = "rtcon: A connection with name wire already exists at these ports\n"
    assert run(f"rtcon -d -n wire {other}").err == taken
    assert run(f"rtcon -d {other}").status == 0
    assert len(world.connectors) == 2


def test_verbose_tells_what_was_connected(run: Run) -> None:
    outcome = run(f"rtcon -v -i w {STD}:out {INPUT}:in")
    assert outcome == (0, "", "Std0.out -> Input0.in: w\n")


def test_a_connection_gone_meanwhile_is_no_failure(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i w {STD}:out {INPUT}:in").status == 0
    world.fault = lambda action: (
        Result(ReturnCode.BAD_PARAMETER, "not-found", "no connection with id w")
        if isinstance(action, act.Disconnect)
        else None
    )
    assert run(f"rtdis {STD}") == (0, "", "")


def test_connections_that_remain_are_told(world: FakeManager, run: Run) -> None:
    assert run(f"rtcon -i w {STD}:out {INPUT}:in {STD}:in").status == 0
    world.fault = lambda action: (
        Result(ReturnCode.ERROR, "unreachable", "no answer from slave1 in time")
        if action == act.Disconnect("w")
        else None
    )
    told = "rtdis: no answer from slave1 in time: w\nrtdis: 1 of 2 connections remain\n"
    assert run(f"rtdis {STD}") == (1, "", told)


# configuration


def test_several_parameters_are_set_at_once(world: FakeManager, run: Run) -> None:
    world.update("Std0", sets={"default": {"a": "1", "b": "2"}, "other": {"a": "3"}})
    assert run(f"rtconf {STD} set a=-1 b=x=y").status == 0
    assert world.performed == [
        act.SetParameters("Std0", "default", {"a": "-1", "b": "x=y"}),
        act.ActivateSet("Std0", "default"),
    ]
    assert world.components["Std0"].sets["other"] == {"a": "3"}


def test_a_set_that_is_not_active_is_not_activated(world: FakeManager, run: Run) -> None:
    assert run(f"rtconf -s set1 {STD} set param 7").status == 0
    assert world.performed == [act.SetParameters("Std0", "set1", {"param": "7"})]


@pytest.mark.parametrize("value", ["-5", "-.5", "-0.5,1", "a=b", "", "ü\n"])
def test_values_are_kept_as_they_are(
    world: FakeManager, capsys: pytest.CaptureFixture[str], value: str
) -> None:
    from rtkit.cli.components.rtconf import main as rtconf

    tree = fake_tree(world)
    assert rtconf([STD, "set", "param", value], tree=tree) == 0
    assert rtconf([STD, "get", "param"], tree=tree) == 0
    assert capsys.readouterr().out == f"{value}\n"


# managers


def test_commands_travel_in_the_order_of_the_line(world: FakeManager, batches: Batches) -> None:
    line = ["-c", "Std?instance_name=x", "-d", "x", "-l", "/mods/a.py:aInit", "-c", "Output"]
    assert rtmgr([*line, "/localhost/manager.mgr", "-u", "/mods/a.py"], tree=batches.tree) == 0
    kinds = [type(action).__name__ for action in world.performed]
    assert kinds == ["Create", "Delete", "Load", "Create", "Unload"]
    assert batches.sent == [(5, True)]


def test_a_question_between_commands_sees_what_is_done_so_far(run: Run) -> None:
    line = "-c Std?instance_name=x -r -d x -r"
    lines = run(f"rtmgr {line} /localhost/manager.mgr").out.splitlines()
    assert len([each for each in lines if each.startswith("x ")]) == 1
    assert len(lines) == 9 + 8


def test_commands_after_a_failure_are_not_done(world: FakeManager, run: Run) -> None:
    outcome = run("rtmgr -c Std --print -c Nix -c Std /localhost/manager.mgr -r")
    assert outcome.out == "/localhost/Std1.rtc\n"
    assert outcome.status == 1
    assert [type(action) for action in world.performed] == [act.Create, act.Create]


def test_a_slave_s_path_places_components_there(world: FakeManager, run: Run) -> None:
    assert run("rtmgr -c Std /localhost/manager.mgr/slave1.mgr").status == 0
    assert world.components["Std1"].process == "slave1"
    assert run("rtmgr -c Std?manager_name=slave9 /localhost/manager.mgr/slave1.mgr").status == 0
    assert world.components["Std2"].process == "slave9"


def test_a_slave_s_path_deletes_only_what_is_there(world: FakeManager, run: Run) -> None:
    run("rtmgr -c Std /localhost/manager.mgr/slave1.mgr")
    run("rtmgr -c Std?manager_name=slave9 /localhost/manager.mgr/slave1.mgr")
    outcome = run("rtmgr -d Std2 /localhost/manager.mgr/slave1.mgr")
    assert (outcome.status, "Std2" in world.components) == (1, True)
    assert outcome.err.startswith("rtmgr: Failed to delete component: Std2 (no component named")
    assert run("rtmgr -d Std1 /localhost/manager.mgr/slave1.mgr").status == 0
    assert "Std2" in world.components
    assert "Std1" not in world.components


def test_modules_from_here_are_named_in_full(world: FakeManager, run: Run) -> None:
    run("rtmgr -l ./x.py:xInit /localhost/manager.mgr")
    run("rtmgr -l x.py:xInit /localhost/manager.mgr")
    run("rtmgr -u ../x.py /localhost/manager.mgr")
    assert world.performed == [
        act.Load(str(Path.cwd() / "x.py"), "xInit"),
        act.Load("x.py", "xInit"),
        act.Unload(str(Path.cwd().parent / "x.py")),
    ]


def test_a_module_path_may_have_colons(world: FakeManager, run: Run) -> None:
    run("rtmgr -l C:/mods/x.py:xInit /localhost/manager.mgr")
    assert world.performed == [act.Load("C:/mods/x.py", "xInit")]


RTC = """<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:id="RTC:Me:test:Wheel:1.2" rtc:version="0.3"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="Wheel" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="test" rtc:vendor="Me" rtc:version="1.2"
      rtc:executionRate="50.0" rtc:executionType="PeriodicExecutionContext"
      rtc:description="A wheel" rtc:maxInstances="0"
      rtc:creationDate="2020-01-01T00:00:00" rtc:updateDate="2020-01-01T00:00:00"/>
  <rtc:Actions/>
  <rtc:ConfigurationSet>
    <rtc:Configuration rtc:name="radius" rtc:type="double" rtc:defaultValue="0.1"/>
  </rtc:ConfigurationSet>
  <rtc:DataPorts rtc:portType="DataInPort" rtc:name="speed" rtc:type="RTC::TimedDouble"
      rtc:position="LEFT"/>
  <rtc:DataPorts rtc:portType="DataOutPort" rtc:name="angle" rtc:type="RTC::TimedDouble"
      rtc:position="RIGHT"/>
  <rtc:ServicePorts rtc:name="svc" rtc:position="LEFT">
    <rtc:ServiceInterface rtc:name="brake" rtc:direction="Required" rtc:instanceName="b0"
        rtc:type="Brake"/>
  </rtc:ServicePorts>
</rtc:RtcProfile>
"""


def test_a_profile_makes_a_stand_in(world: FakeManager, run: Run, tmp_path: Path) -> None:
    file = tmp_path / "Wheel.xml"
    file.write_text(RTC)
    line = f"rtmgr --print -c {file}?instance_name=Left&manager_name=slave1"
    assert run(f"'{line}' ".strip("' ").replace("&", "\\&") + " /localhost/manager.mgr") == (
        0,
        "/localhost/Left.rtc\n",
        "",
    )
    made = world.components["Left"]
    assert (made.process, made.is_stand_in) == ("slave1", True)
    assert made.type.id == "RTC:Me:test:Wheel:1.2"
    assert [(port.name, port.port_type) for port in made.ports] == [
        ("speed", PortType.IN),
        ("angle", PortType.OUT),
        ("svc", PortType.SERVICE),
    ]
    assert made.ports[0].data_type == "RTC::TimedDouble"
    assert made.ports[2].interfaces[0].polarity == "Required"
    assert made.sets["default"] == {"radius": "0.1"}
    assert made.contexts[0].rate == 50.0


def test_a_stand_in_is_marked(world: FakeManager, run: Run) -> None:
    world.update("Std0", is_stand_in=True)
    world.update("Text0", is_stand_in=True, trouble="stopped")
    out = run("rtls -l /localhost").out
    assert "Std0.rtc  (stand-in)\n" in out
    assert "Text0.rtc  (stopped, stand-in)\n" in out
    assert "  Stand-in       yes\n" in run(f"rtcat {STD}").out
    assert "  Trouble        stopped\n" in run("rtcat /localhost/Text0.rtc").out


def test_a_profile_that_cannot_be_read_is_a_failed_creation(run: Run, tmp_path: Path) -> None:
    file = tmp_path / "bad.xml"
    file.write_text("<no")
    outcome = run(f"rtmgr -c {file} /localhost/manager.mgr")
    assert outcome.err.startswith(f"rtmgr: Failed to create component: {file} ({file}:1: ")
    outcome = run("rtmgr -c none.xml /localhost/manager.mgr")
    assert outcome.err == (
        "rtmgr: Failed to create component: none.xml"
        " (cannot read none.xml: No such file or directory)\n"
    )


# JSON


def test_json_is_one_object_a_line(run: Run) -> None:
    lines = run("rtls --json /localhost").out.splitlines()
    records = [json.loads(line) for line in lines]
    assert [record["path"] for record in records][:2] == [
        "/localhost/Adder0.rtc",
        "/localhost/Err0.rtc",
    ]
    assert {record["schema"] for record in records} == {"rtkit.entry/1"}
    zombie = next(record for record in records if record["kind"] == "zombie")
    assert (zombie["zombie"], zombie["state"]) == ("signal 9", None)


def test_json_of_a_whole_tree_lists_each_entry_once(run: Run) -> None:
    paths = [json.loads(line)["path"] for line in run("rtls -R --json /").out.splitlines()]
    assert len(paths) == len(set(paths))
    assert "/localhost/manager.mgr/slave1.mgr/Input0.rtc" in paths


@pytest.mark.parametrize(
    ("line", "key", "value"),
    [
        (f"rtcat --json {STD}", "instance", "Std0"),
        (f"rtcat --json {STD}:in", "name", "in"),
        ("rtcat --json /localhost/manager.mgr", "name", "manager"),
        ("rtcat --json /localhost/manager.mgr/slave2.mgr", "state", "lost"),
        (f"rtconf --json {STD}", "active", "default"),
        (f"rtconf --json {STD} get param", "value", "0"),
    ],
)
def test_json_records(run: Run, line: str, key: str, value: object) -> None:
    assert json.loads(run(line).out)[key] == value


def test_the_working_directory_in_the_tree_is_respected(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTCSH_CWD", "/localhost/local.host_cxt/")
    assert run("rtls").out == "Output0.rtc\n"
    assert run("rtls ../Std0.rtc").out == "Std0.rtc\n"
    monkeypatch.setenv("RTKIT_CWD", "/localhost/manager.mgr/slave1.mgr")
    assert run("rtls").out == "Input0.rtc\n"
    assert run("rtcat No.rtc").err == "rtcat: No such object: No.rtc\n"


def test_a_refusal_names_what_was_typed_only(world: FakeManager, run: Run) -> None:
    world.fault = lambda _: Result(
        ReturnCode.PRECONDITION_NOT_MET, "refused", "precondition not met (state is Error): Std0"
    )
    told = f"rtact: precondition not met (state is Error): {STD}\n"
    assert run(f"rtact {STD}") == (1, "", told)


def test_what_was_there_otherwise_is_told(
    world: FakeManager, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    tree = fake_tree(world)
    note = "Std0 exists already, as Input in slave1: nothing was made"
    monkeypatch.setattr(tree, "apply", lambda actions: (Result(value="Std0", note=note),))
    assert rtmgr(["-c", "Std?instance_name=Std0", "--print", "/localhost/manager.mgr"], tree) == 0
    assert capsys.readouterr() == ("/localhost/Std0.rtc\n", f"rtmgr: note: {note}\n")


def test_properties_of_connections_that_are_not_known_are_warned_of(
    run: Run, world: FakeManager
) -> None:
    odd = "unknown connector property: dataport.bufer.length (did you mean dataport.buffer.length?)"
    line = f"-p dataport.bufer.length=3 -i id {STD}:in {OUTPUT}:out"
    assert run(f"rtcon --strict {line}") == (1, "", f"rtcon: {odd}\n")
    assert not world.connectors
    assert run(f"rtcon {line}") == (0, "", f"rtcon: warning: {odd}\n")
    assert set(world.connectors) == {"id"}
