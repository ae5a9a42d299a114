"""Listeners of components written for OpenRTM-aist: connectors, values, sets, callbacks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from openrtm_corpus import COMPONENTS, needs_components
from openrtm_files import EXAMPLES, made, write_component

from rtkit.component import TimedLong
from rtkit.component.base import Component
from rtkit.rtc.enums import LifeCycleState
from rtkit.rtc.profiles import ConnectorProfile, PortRef

DISPLAY = EXAMPLES / "StaticFsm" / "Display.py"
CONFIG_SAMPLE = EXAMPLES / "ConfigSample" / "ConfigSample.py"
MICROWAVE = EXAMPLES / "StaticFsm" / "Microwave.py"
SHARED = "Nobu19800__SettingRTSystem/Composite/ECandStateSharedCompositePy"

LISTENERS = """
TYPE = OpenRTM_aist.ConnectorDataListenerType
STATUS = OpenRTM_aist.ConnectorListenerStatus

class Old(OpenRTM_aist.ConnectorDataListenerT):
    def __init__(self, notes): self.notes = notes
    def __call__(self, info, cdrdata):
        data = OpenRTM_aist.ConnectorDataListenerT.__call__(
            self, info, cdrdata, RTC.TimedLong(RTC.Time(0, 0), 0))
        self.notes.append(("old", info.name, info.id, data.data))

class New(OpenRTM_aist.ConnectorDataListenerT):
    def __init__(self, notes): self.notes = notes
    def __call__(self, info, data):
        self.notes.append(("new", info.properties.getProperty("buffer.length"), data.data))
        data.data += 1
        return STATUS.DATA_CHANGED, data

class Raw(OpenRTM_aist.ConnectorDataListener):
    def __init__(self, notes): self.notes = notes
    def __call__(self, info, data):
        self.notes.append(("raw", len(data), info.ports))
        return STATUS.DATA_CHANGED, data[:-4] + bytes([9, 0, 0, 0])

class Ends(OpenRTM_aist.ConnectorListener):
    def __init__(self, notes): self.notes = notes
    def __call__(self, info):
        self.notes.append(("ends", info.name))
        return STATUS.NO_CHANGE
"""

LISTENING = """
def onInitialize(self):
    self.notes = []
    self._in = OpenRTM_aist.InPort("in", RTC.TimedLong(RTC.Time(0, 0), 0))
    self.addInPort("in", self._in)
    self._out = OpenRTM_aist.OutPort("out", RTC.TimedLong(RTC.Time(0, 0), 0))
    self.addOutPort("out", self._out)
    return RTC.RTC_OK
"""
CONNECTOR = ConnectorProfile(
    "c0", "wire", (PortRef("A", "out"), PortRef("It0", "in")), {"dataport.buffer.length": "4"}
)


def long(data: int) -> TimedLong:
    return TimedLong(data=data)


@pytest.fixture
def listening(tmp_path: Path) -> Any:
    """Return the author's object, whose module has listeners to add."""
    file = write_component(tmp_path, "Listening", LISTENING)
    file.write_text(file.read_text() + LISTENERS)
    servant: Any = made(file).servant  # type: ignore[attr-defined]
    return servant


def module_of(servant: Any) -> dict[str, Any]:
    names: dict[str, Any] = type(servant).onInitialize.__globals__
    return names


def test_a_value_may_be_changed_by_each_kind_of_listener(listening):
    of, notes = module_of(listening), listening.notes
    port, at = listening._in, of["TYPE"].ON_RECEIVED
    for kind in ("Old", "New", "Raw"):
        port.addConnectorDataListener(at, of[kind](notes))
    port.addConnectorDataListener(of["TYPE"].ON_BUFFER_WRITE, of["Old"](notes))
    sink = port.port.open(CONNECTOR)
    sink(long(5))
    assert notes == [
        ("old", "wire", "c0", 5),
        ("new", "4", 5),
        ("raw", 12, ["A.out", "It0.in"]),
        ("old", "wire", "c0", 9),
    ]
    assert port.read().data == 9


def test_an_out_port_is_listened_to(listening):
    of, notes = module_of(listening), listening.notes
    port = listening._out
    port.addConnectorDataListener(of["TYPE"].ON_SEND, of["New"](notes))
    sent: list[TimedLong] = []
    port.port.attach(CONNECTOR, sent.append)
    assert port.write(of["RTC"].TimedLong(of["RTC"].Time(0, 0), 3))
    assert [each.data for each in sent] == [4]
    assert notes == [("new", "4", 3)]


def test_connectors_are_told_until_the_listener_is_removed(listening):
    of, notes = module_of(listening), listening.notes
    types = of["OpenRTM_aist"].ConnectorListenerType
    ends = of["Ends"](notes)
    for number in range(types.CONNECTOR_LISTENER_NUM):
        listening._in.addConnectorListener(number, ends)
    listening._in.port.open(CONNECTOR)
    listening._in.read()
    listening._in.removeConnectorListener(types.ON_DISCONNECT, ends)
    listening._in.removeConnectorListener(types.ON_DISCONNECT, ends)
    listening._in.port.close("c0")
    assert notes == [("ends", "wire")] * 2  # connected, and empty
    assert ends.toString(types.ON_CONNECT) == "ON_CONNECT"
    assert of["Old"].toString(of["TYPE"].ON_SEND) == "ON_SEND"
    assert of["Old"].toString(99) == ""


def test_what_a_listener_raises_is_logged_and_the_value_goes_on(listening, caplog):
    def fail(info: Any, data: Any) -> None:
        raise ValueError("no")

    at = module_of(listening)["TYPE"].ON_RECEIVED
    listening._in.addConnectorDataListener(at, fail)
    listening._in.port.open(CONNECTOR)(long(5))
    assert listening._in.read().data == 5
    assert "port in: listener of received failed: ValueError: no" in caplog.text


def test_sets_are_listened_to(listening):
    names = module_of(listening)["OpenRTM_aist"]
    component, notes = listening.rtkit_component, listening.notes
    gain = [1]
    listening.bindParameter("gain", gain, "1")
    sets, set_names = names.ConfigurationSetListenerType, names.ConfigurationSetNameListenerType
    params = names.ConfigurationParamListenerType

    def values(config_set: Any) -> None:
        notes.append((config_set.getName(), config_set.getProperty("gain")))

    for number in range(sets.CONFIG_SET_LISTENER_NUM):
        listening.addConfigurationSetListener(number, values)
    for number in range(set_names.CONFIG_SET_NAME_LISTENER_NUM):
        listening._configsets.addConfigurationSetNameListener(
            number, lambda name, number=number: notes.append((number, name))
        )
    heard = listening.addConfigurationParamListener(
        params.ON_UPDATE_CONFIG_PARAM, lambda set_id, name: notes.append((set_id, name, gain[0]))
    )
    component.configuration.set("default", {"gain": "2"})
    component.configuration.add_set("fast", {"gain": "7"})
    component.configuration.activate("fast")
    assert notes == [("default", "2"), ("fast", "7")]
    notes.clear()
    component.configuration.update()
    activated, updated = set_names.ON_ACTIVATE_CONFIG_SET, set_names.ON_UPDATE_CONFIG_SET
    assert notes == [("fast", "gain", 7), (activated, "fast"), (updated, "fast")]
    listening.removeConfigurationParamListener(params.ON_UPDATE_CONFIG_PARAM, heard)
    component.configuration.activate("default")
    component.configuration.update()
    component.configuration.remove_set("fast")
    assert notes[-1] == (set_names.ON_REMOVE_CONFIG_SET, "fast")
    assert ("default", "gain", 2) not in notes


def test_a_listener_to_a_set_that_fails_hinders_nobody(listening, caplog):
    component = listening.rtkit_component
    listening.addConfigurationSetListener(0, lambda config_set: 1 / 0)
    listening.bindParameter("gain", [1], "1")
    component.configuration.set("default", {"gain": "2"})
    assert "listener failed: ZeroDivisionError" in caplog.text


def test_callbacks_are_listened_to(listening):
    names = module_of(listening)["OpenRTM_aist"]
    component, notes = listening.rtkit_component, listening.notes
    before, after = names.PreComponentActionListenerType, names.PostComponentActionListenerType
    done = []
    listening.addPreComponentActionListener(before.PRE_ON_ACTIVATED, notes.append)
    listening.addPostComponentActionListener(
        after.POST_ON_ACTIVATED, lambda ec_id, ret: done.append((ec_id, str(ret)))
    )
    (context,) = component.contexts.values()
    context.activate_component(component)
    assert (notes, done) == ([0], [(0, "RTC_OK")])
    context.deactivate_component(component)
    listening.removePreComponentActionListener(before.PRE_ON_ACTIVATED, notes.append)
    component.on_activated._callback = lambda *_: 1 / 0
    context.activate_component(component)
    assert context.state_of(component) is LifeCycleState.ERROR
    assert (notes, done[1:]) == ([0], [(0, "RTC_ERROR")])


@needs_components
def test_an_existing_component_listens_to_everything(capsys):
    component = made(DISPLAY)
    sink = component.ports["in"].open(CONNECTOR)  # type: ignore[attr-defined]
    sink(long(4))
    (context,) = component.contexts.values()
    context.activate_component(component)
    context.tick()
    component.ports["in"].close("c0")  # type: ignore[attr-defined]
    said = capsys.readouterr().out
    found = [line.split()[-1] for line in said.splitlines() if "Listener:" in line]
    assert found == [
        "ON_CONNECT", "ON_RECEIVED", "ON_BUFFER_WRITE", "ON_BUFFER_READ", "ON_DISCONNECT",
    ]  # fmt: skip
    assert said.count("Data:            4") == 3
    assert "Profile::name:   wire" in said


@needs_components
def test_an_existing_component_listens_to_its_parameters(capsys):
    component = made(CONFIG_SAMPLE)
    component.configuration.set("default", {"int_param0": "9"})
    component.configuration.activate("default")
    component.configuration.update()
    assert "config_set_name:  default  config_param_name:  int_param0" in capsys.readouterr().out


@needs_components
def test_the_microwave_cooks(capsys):
    component: Any = made(MICROWAVE)
    port: Any = component.ports["event"]
    write = {
        name: port.open(ConnectorProfile(name, name, ())) for name in ("minute", "start", "tick")
    }
    write["minute"](long(1))
    write["start"](b"")
    write["tick"](b"")
    (context,) = component.contexts.values()
    context.activate_component(component)
    context.tick()
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith(" ")]
    assert said == [
        "  Microwave ready", " Timer set to  1  minutes", "  Heating on", "  Clock tick",
        "  Finished", "  Heating off", "  Microwave ready",
    ]  # fmt: skip
    component.finalize()
    assert component.servant._fsm.is_current_direct(None)


class Member(Component):
    """Fails when it is told to."""

    fails = False

    def on_execute(self, context: str) -> None:
        if self.fails:
            raise ValueError("told to")


@needs_components
def test_an_existing_composite_fails_with_its_member():
    member = Member("Member0")
    member.initialize()
    whole: Any = made(
        COMPONENTS / SHARED / "ECandStateSharedComposite.py", "&members=Member0&exported_ports="
    )
    whole.resolve = {"Member0": member}.get
    for each in (member, whole):
        (context,) = each.contexts.values()
        context.wake = context.serve_requests
    outcomes: list[object] = []
    whole.arrange(outcomes.append)
    assert outcomes == [None]
    assert whole.servant._members == [["Member0"]]
    context.activate_component(whole)
    context.tick()
    assert context.state_of(member) is LifeCycleState.ACTIVE
    member.fails = True
    context.tick()
    context.tick()
    assert context.state_of(whole) is LifeCycleState.ERROR
    assert "returned RTC_ERROR" in whole.cause
