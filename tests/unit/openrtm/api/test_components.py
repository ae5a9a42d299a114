"""Components written for OpenRTM-aist: ports, parameters, callbacks, contexts, profile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from openrtm_files import made, write_component

from rtkit.component.base import Component
from rtkit.component.types import Time
from rtkit.component.values.typenames import type_by_name
from rtkit.errors import Malformed, NotFound
from rtkit.modules.loader import Loader
from rtkit.rtc.enums import LifeCycleState, PortType
from rtkit.rtc.profiles import ConnectorProfile

ECHO = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
    self._d_in = RTC.TimedLong(RTC.Time(0, 0), 0)
    self._inIn = OpenRTM_aist.InPort("in", self._d_in)
    self._d_out = OpenRTM_aist.instantiateDataType(RTC.TimedLong)
    self._outOut = OpenRTM_aist.OutPort("out", self._d_out, OpenRTM_aist.RingBuffer(8))
    self.gain = [2]
    self.rows = [[1.0]]
    self.seen = []

def onInitialize(self):
    self.addInPort("in", self._inIn)
    self.registerOutPort("out", self._outOut)
    self.bindParameter("gain", self.gain, "3")
    self.bindParameter("rows", self.rows, "1.0, 2")
    return RTC.RTC_OK

def onActivated(self, ec_id):
    self.seen.append(ec_id)
    return RTC.RTC_OK

def onExecute(self, ec_id):
    if self._inIn.isNew():
        data = self._inIn.read()
        self._d_out.data = data.data * self.gain[0]
        self._outOut.write()
    return RTC.RTC_OK
"""


class Outlet:
    """A connector at each end of a component, without a network."""

    def __init__(self, component: Component) -> None:
        self.component = component
        self.values: list[Any] = []
        port: Any = component.ports["out"]
        port.attach("out", self.values.append)
        into: Any = component.ports["in"]
        self.put = into.open(ConnectorProfile("in", "in", ()))

    def cycle(self) -> None:
        (context,) = self.component.contexts.values()
        context.tick()


@pytest.fixture
def echo(tmp_path: Path) -> Component:
    more = '"conf.default.gain", "4", "conf.mode1.gain", "5", "exec_cxt.periodic.rate", "50",'
    return made(write_component(tmp_path, "Echo", ECHO, more))


def state(component: Component) -> LifeCycleState:
    (context,) = component.contexts.values()
    return context.state_of(component)


def activate(component: Component) -> None:
    (context,) = component.contexts.values()
    context.activate_component(component)


def timed(data: int) -> Any:
    cls: Any = type_by_name("RTC::TimedLong")
    return cls(Time(1, 2), data)


def test_its_profile_is_that_of_its_module(echo: Component) -> None:
    assert echo.type.id == "RTC:me:example:Echo:1.2"
    assert (echo.type.description, echo.type.language) == ("A test", "Python")
    ports = {port.name: (port.port_type, port.profile.data_type) for port in echo.ports.values()}
    assert ports == {
        "in": (PortType.IN, "IDL:RTC/TimedLong:1.0"),
        "out": (PortType.OUT, "IDL:RTC/TimedLong:1.0"),
    }
    assert echo.contexts["0"].rate == 50.0


def test_values_pass_and_parameters_count(echo: Component) -> None:
    outlet = Outlet(echo)
    activate(echo)
    outlet.put(timed(5))
    outlet.cycle()
    assert [each.data for each in outlet.values] == [20]
    assert echo.servant.seen == [0]


def test_what_is_written_is_a_snapshot(echo: Component) -> None:
    outlet, servant = Outlet(echo), echo.servant
    servant._d_out.data = 1
    assert servant._outOut.write() is True
    servant._d_out.data = 2
    assert [each.data for each in outlet.values] == [1]


def test_a_read_gives_an_object_of_its_own_each_time(echo: Component) -> None:
    outlet, port = Outlet(echo), echo.servant._inIn
    assert port.read() is echo.servant._d_in
    value = timed(7)
    outlet.put(value)
    outlet.put(value)
    first, second = port.read(), port.read()
    first.data = 1
    assert (second.data, value.data, port.isNew(), port.read()) == (7, 7, False, second)


def test_without_a_connector_a_write_is_false(echo: Component) -> None:
    assert echo.servant._outOut.write() is False


def test_a_value_that_does_not_fit_is_reported_and_not_sent(echo: Component) -> None:
    outlet, servant = Outlet(echo), echo.servant
    reported: list[str] = []
    echo.report = reported.append
    for value in (None, "x", 2**40):
        servant._d_out.data = value
        assert servant._outOut.write() is False
    assert outlet.values == []
    assert "not sent" in reported[0]
    assert "TimedLong.data" in reported[1]


def test_parameters_change_between_cycles_in_place(echo: Component) -> None:
    servant = echo.servant
    rows = servant.rows[0]
    assert (servant.gain, rows) == ([4], [1.0, 2.0])
    echo.configuration.set("default", {"rows": "7"})
    echo.configuration.activate("mode1")
    assert servant.gain == [4]
    echo.contexts["0"].tick()
    assert servant.gain == [5]
    echo.configuration.activate("default")
    echo.contexts["0"].tick()
    assert servant.gain == [4]
    assert servant.rows[0] is rows
    assert rows == [7.0]


def test_a_text_that_cannot_be_converted_gives_the_default(echo: Component) -> None:
    echo.configuration.set("default", {"gain": "much"})
    echo.configuration.activate("default")
    echo.contexts["0"].tick()
    assert echo.servant.gain == [3]


def test_options_take_precedence_over_the_module(tmp_path: Path) -> None:
    more = '"conf.default.gain", "4",'
    echo = made(write_component(tmp_path, "Echo", ECHO, more), "&conf.default.gain=9")
    assert echo.servant.gain == [9]


def test_an_error_is_told_with_its_line(tmp_path: Path) -> None:
    body = "def onExecute(self, ec_id):\n    return 1 / ec_id\n"
    failing = made(write_component(tmp_path, "Failing", body))
    activate(failing)
    failing.contexts["0"].tick()
    assert state(failing) is LifeCycleState.ERROR
    assert failing.cause.startswith("ZeroDivisionError: division by zero (Failing.py:")
    assert failing.cause.endswith("in onExecute)")


@pytest.mark.parametrize("result", ["RTC.RTC_ERROR", "RTC.PRECONDITION_NOT_MET", "True"])
def test_another_code_than_ok_leads_to_error(tmp_path: Path, result: str) -> None:
    body = f"def onExecute(self, ec_id):\n    return {result}\n"
    failing = made(write_component(tmp_path, "Failing", body))
    activate(failing)
    failing.contexts["0"].tick()
    assert state(failing) is LifeCycleState.ERROR


def test_a_component_finds_its_contexts(tmp_path: Path) -> None:
    body = """
def onExecute(self, ec_id):
    self.state = self.get_owned_contexts()[0].get_component_state(self._objref)
    self.rate = self.getExecutionContext(ec_id).get_rate()
    self.deactivate(ec_id)
    return RTC.RTC_OK
"""
    one = made(write_component(tmp_path, "One", body), "&exec_cxt.periodic.rate=20")
    activate(one)
    one.contexts["0"].tick()
    assert (str(one.servant.state), one.servant.rate) == ("ACTIVE_STATE", 20.0)
    one.contexts["0"].tick()
    assert state(one) is LifeCycleState.INACTIVE


def test_callbacks_that_are_not_overridden_are_not_called(echo: Component) -> None:
    (participant,) = echo.contexts["0"]._participants
    assert (participant.executes, participant.updates) == (True, False)


def test_the_function_that_registers_is_found_by_what_it_does(tmp_path: Path) -> None:
    file = write_component(tmp_path, "Echo", ECHO)
    text = file.read_text(encoding="utf-8").replace("def EchoInit", "def begin")
    text += "\ndef MyModuleInit(manager):\n    begin(manager)\n"
    text += "    manager.createComponent('Echo').x[0]()\n"
    file.write_text(text, encoding="utf-8")
    assert [each.type_name for each in Loader([]).load(str(file)).types] == ["Echo"]
    mine = Loader([]).load(str(file), "MyModuleInit")
    assert [each.type_name for each in mine.types] == ["Echo"]
    with pytest.raises(NotFound, match="no init function Other"):
        Loader([]).load(str(file), "Other")


def test_contexts_are_there_when_it_is_initialised(tmp_path: Path) -> None:
    body = """
def onInitialize(self):
    self.before = self.getExecutionContext(0).get_rate()
    self.get_owned_contexts()[0].set_rate(25)
    return RTC.RTC_OK
"""
    one = made(write_component(tmp_path, "One", body))
    assert (one.servant.before, one.contexts["0"].rate) == (1000.0, 25.0)


def test_a_port_is_added_while_it_runs(tmp_path: Path) -> None:
    body = """
def onExecute(self, ec_id):
    self.late = OpenRTM_aist.OutPort("late", RTC.TimedString(RTC.Time(0, 0), ""))
    self.twice = OpenRTM_aist.OutPort("late", RTC.TimedString(RTC.Time(0, 0), ""))
    self.added = (self.addOutPort("late", self.late), self.addOutPort("late", self.twice))
    self.deactivate(ec_id)
    return RTC.RTC_OK
"""
    one = made(write_component(tmp_path, "One", body))
    seen: list[list[str]] = []
    one.contexts["0"].changed = lambda component: seen.append([*one.ports])
    activate(one)
    one.contexts["0"].tick()
    one.contexts["0"].tick()
    assert one.servant.added == (True, False)
    assert seen[-1] == ["late"]
    assert one.servant.removePort(one.servant.late) is True
    assert [*one.ports] == []


def test_sets_of_files_may_break_constraints_and_others_may_not(tmp_path: Path) -> None:
    hints = '"conf.__constraints__.gain", "0<=x<=9", "conf.fast.gain", "12345",'
    component: Any = made(write_component(tmp_path, "Echo", ECHO, hints))
    component.configuration.activate("fast")
    component.configuration.update()
    assert component.servant.gain == [12345]
    component.configuration.set("fast", {"gain": "12345"})
    with pytest.raises(Malformed, match="gain cannot be '54321'"):
        component.configuration.set("fast", {"gain": "54321"})
