"""Ports of CSP of components written for OpenRTM-aist: channels, buffers, choice, ends of waits."""

from __future__ import annotations

from collections.abc import Callable
from threading import Thread
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.component.contexts.input_wait import InputEnded, allow_input, leave_input
from rtkit.component.ports.options import parse_options
from rtkit.errors import Malformed
from rtkit.openrtm.absent import NotSupported
from rtkit.openrtm.api.static_fsm import FSM_TOPSTATE, Link
from rtkit.openrtm.corba.standard_types import rtc_value
from rtkit.openrtm.csp.events import CSPEventPort, CSPMachine
from rtkit.openrtm.csp.manager import CSPManager
from rtkit.openrtm.csp.ports import CSPInPort, CSPOutPort, CSPReader
from rtkit.openrtm.loading.names import shared_module
from rtkit.rtc.profiles import ConnectorProfile

CHANNEL = {"dataport.dataflow_type": "duplex", "dataport.interface_type": "csp_channel"}
FOR_EVER = {"channel_timeout": "3000"}
AT_ONCE = {"channel_timeout": "0"}


@FSM_TOPSTATE
class Top(Link):
    """A state that notes what it is told."""

    def add(self, value: Any) -> None:
        """Note a value."""
        self._rtComponent.append(value.data)

    def clear(self) -> None:
        """Note that there was none."""
        self._rtComponent.append("clear")


def number(data: int = 0) -> Any:
    value = rtc_value("TimedLong")(rtc_value("Time")(0, 0), 0)
    value.data = data
    return value


def out_port(manager: CSPManager | None = None, **properties: str) -> CSPOutPort:
    made = CSPOutPort("out", number(), manager)
    made.port.properties.update(FOR_EVER | properties)
    return made


def in_port(length: int = 8, manager: CSPManager | None = None, **properties: str) -> CSPInPort:
    made = CSPInPort("in", number(), manager)
    made.port.properties.update({"buffer.length": str(length)} | FOR_EVER | properties)
    return made


def join(out: CSPOutPort, into: CSPReader, id: str = "wire", **properties: str) -> None:
    connector = ConnectorProfile(id, id, (), CHANNEL | properties)
    into.port.open_pull(connector, out.port.open_pull(connector))


def part(out: CSPOutPort, into: CSPReader, id: str = "wire") -> None:
    into.port.close(id)
    out.port.detach(id)


def aside(work: Callable[[], object]) -> tuple[Thread, list[object]]:
    """Do something on another thread; return that, and where its result will be."""
    found: list[object] = []
    thread = Thread(target=lambda: found.append(work()), daemon=True)
    thread.start()
    return thread, found


def written(out: CSPOutPort, count: int) -> tuple[Thread, list[object]]:
    return aside(lambda: [out.write(number(each)) for each in range(count)])


def ended(thread: Thread) -> bool:
    thread.join(30)
    return not thread.is_alive()


def test_a_channel_is_pulled() -> None:
    assert parse_options(CHANNEL).dataflow == "pull"
    assert parse_options({"dataport.interface_type": "csp_channel"}).dataflow == "pull"


@pytest.mark.parametrize("length", [0, 1, 3])
def test_values_come_in_order_and_each_write_knows_it(length: int) -> None:
    out, into = out_port(), in_port(length)
    join(out, into)
    thread, found = written(out, 20)
    assert [into.read().data for _ in range(20)] == [*range(20)]
    assert ended(thread)
    assert found == [[True] * 20]
    part(out, into)


@pytest.mark.parametrize("length", [1, 3])
def test_as_many_are_written_as_there_is_room_for(length: int) -> None:
    out, into = out_port(), in_port(length)
    join(out, into)
    assert all(out.write(number(each)) for each in range(length))
    out.port.properties.update(AT_ONCE)
    # The channel does not ask before the oldest is read.
    assert (out.select(), out.write(number(9))) == (False, False)
    out.port.properties.update(FOR_EVER)
    assert [into.read().data for _ in range(length)] == [*range(length)]
    assert out.write(number(10))
    assert into.read().data == 10
    part(out, into)


def test_without_a_reader_nothing_is_written_unbuffered() -> None:
    out, into = out_port(**AT_ONCE), in_port(0)
    join(out, into)
    assert not out.write(number(1))
    assert not into.select()
    into.port.properties.update(AT_ONCE)
    assert into.read() is None
    part(out, into)


def test_a_connector_may_say_how_much_room_there_is() -> None:
    out, into = out_port(**AT_ONCE), in_port(8)
    join(out, into, **{"dataport.inport.buffer.length": "0"})
    assert not out.write(number(1))  # nobody reads
    part(out, into)
    with pytest.raises(Malformed, match=r"buffer\.length=many: not a number of 0 or more"):
        join(out, into, **{"dataport.buffer.length": "many"})
    assert parse_options(CHANNEL | {"dataport.buffer.length": "0"})
    with pytest.raises(Malformed, match="not 1 to"):
        parse_options({"dataport.buffer.length": "0"})


def test_a_timeout_that_is_none_is_told() -> None:
    out, into = out_port(channel_timeout="long"), in_port()
    join(out, into)
    told: list[str] = []
    out.owner = SimpleNamespace(
        rtkit_component=SimpleNamespace(instance="Csp0", report=told.append)
    )
    assert not out.writeData(number(1))
    assert told == ["port out: not sent: channel_timeout=long: not a number of 0 or more"]
    part(out, into)


def test_each_value_goes_to_one_of_several_readers() -> None:
    manager = CSPManager()
    out, readers = out_port(), [in_port(8, manager), in_port(8, manager)]
    for index, each in enumerate(readers):
        join(out, each, str(index))
    assert [out.write(number(each)) for each in range(16)] == [True] * 16
    found = [manager.select(3000)[2].readData().data for _ in range(16)]  # type: ignore[union-attr]
    assert sorted(found) == [*range(16)]
    for index, each in enumerate(readers):
        part(out, each, str(index))


def test_a_manager_finds_what_has_a_value_and_who_waits_for_one() -> None:
    manager = CSPManager()
    first, second = in_port(1, manager), in_port(1, manager)
    back = out_port(manager)
    far_out, far_in = out_port(), in_port(1)
    join(far_out, second, "there")
    thread, _ = written(far_out, 1)
    assert manager.select(3000) == (True, None, second)
    assert (second.readData().data, ended(thread)) == (0, True)
    assert manager.select(0) == (False, None, None)
    join(back, far_in, "back")
    assert manager.select(3000) == (True, back, None)
    assert back.writeData(number(7))
    assert far_in.read().data == 7
    assert (manager.selectInPort(), first.select()) == ((False, None), False)
    part(far_out, second, "there")
    part(back, far_in, "back")


def test_a_manager_gives_each_port_its_turn() -> None:
    manager = CSPManager()
    ports = [in_port(4, manager) for _ in range(2)]
    outs = [out_port(), out_port()]
    for out, into in zip(outs, ports, strict=True):
        join(out, into)
        assert all(out.write(number(each)) for each in range(4))
    chosen = []
    for _ in range(4):
        _, _, port = manager.select(3000)
        assert port is not None
        port.readData()
        chosen.append(port)
    assert chosen == ports * 2
    for out, into in zip(outs, ports, strict=True):
        part(out, into)


def test_who_waits_goes_on_when_the_other_one_has_gone() -> None:
    out, into = out_port(), in_port(0)
    join(out, into)
    writer, wrote = written(out, 1)
    part(out, into)
    assert (ended(writer), wrote) == (True, [[False]])
    join(out, into)
    reader, read = aside(into.read)
    part(out, into)
    assert (ended(reader), read) == (True, [None])


def test_what_was_taken_can_be_read_after_the_end() -> None:
    out, into = out_port(), in_port(2)
    join(out, into)
    assert out.write(number(5))
    part(out, into)  # the channel may just be about to bring it
    assert into.port.meeting.wait(into.select, 30, "")
    assert into.read().data == 5


def test_a_wait_ends_when_the_component_is_to_leave() -> None:
    manager, into = CSPManager(), in_port(0)
    out = out_port(manager)
    out.owner = SimpleNamespace(rtkit_component=SimpleNamespace(instance="CspLeaves0"))
    join(out, into)
    outcomes: list[str] = []

    def waits(work: Callable[[], object]) -> None:
        try:
            work()
        except InputEnded as error:
            outcomes.append(str(error))

    threads = [
        aside(lambda: waits(out.write))[0],
        aside(lambda: waits(lambda: manager.select(9)))[0],
    ]
    leave_input("CspLeaves0")
    assert all(map(ended, threads))
    assert len(outcomes) == 2
    allow_input("CspLeaves0")
    part(out, into)


def test_another_manager_is_for_ports_that_are_not_connected() -> None:
    manager, out, into = CSPManager(), out_port(), in_port()
    out.setManager(manager)
    join(out, into)
    assert manager.selectOutPort()[0] or manager.select(3000)[0]
    with pytest.raises(NotSupported, match="another manager while it is connected"):
        manager.reset()
    part(out, into)
    manager.reset()
    assert manager.select(0) == (False, None, None)


def event_port(notes: list[Any], manager: CSPManager) -> tuple[CSPMachine, CSPEventPort]:
    fsm = CSPMachine(Top, notes, manager)
    port = CSPEventPort("event", fsm, manager)
    port.port.properties.update(FOR_EVER | {"buffer.length": "1"})
    port.bindEvent1("add", Top.add, number())
    port.bindEvent0("clear", Top.clear)
    return fsm, port


def test_a_machine_takes_the_events_of_its_channels() -> None:
    notes: list[Any] = []
    manager = CSPManager()
    fsm, port = event_port(notes, manager)
    outs = {"add": out_port(), "clear": out_port()}
    for name, out in outs.items():
        join(out, port, name, fsm_event_name=name)
    assert fsm.run_event(0) is None
    assert outs["add"].write(number(3))
    assert fsm.run_event(3000) is port
    assert outs["clear"].write(number(0))
    port.read()()
    port.readData()()  # there is none
    assert notes == [3, "clear"]
    for name, out in outs.items():
        part(out, port, name)
    assert (port.read(), port.isConnected()) == (None, False)


def test_a_machine_writes_to_who_waits() -> None:
    manager = CSPManager()
    fsm, _ = event_port([], manager)
    out, into = out_port(manager), in_port()
    join(out, into)
    assert fsm.run_event(3000) is out
    assert into.read().data == 0
    part(out, into)


def test_events_wait_until_there_is_room() -> None:
    notes: list[Any] = []
    fsm, port = event_port(notes, CSPManager())
    out = out_port()
    join(out, port, "add")
    thread, found = written(out, 20)
    for _ in range(20):
        assert fsm.run_event(3000) is port
    assert (ended(thread), found, notes) == (True, [[True] * 20], [*range(20)])
    part(out, port, "add")


def test_names_are_found_in_modules_of_their_own() -> None:
    module: Any = shared_module("OpenRTM_aist.CSPMachine")
    assert module.CSPMachine is CSPMachine
    module = shared_module("OpenRTM_aist.CSPEventPort")
    assert module.CSPEventPort is CSPEventPort
