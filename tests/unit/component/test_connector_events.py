"""Listeners to connectors: what they are told, may change, and that none costs nothing."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rtkit.component import ConnectorEvent, InPort, OutPort, PortStatus, TimedLong, TimedString
from rtkit.component.fsm import EventPort
from rtkit.container.port_wiring import PortWiring
from rtkit.link.local.streams import LocalStreams
from rtkit.rtc.profiles import ConnectorProfile, PortRef

E = ConnectorEvent
ENDS = (PortRef("Sender0", "out"), PortRef("Receiver0", "in"))
TAKEN = ["written", "read", "sent", "received", "written", "received"]
"""What is told of one value by both ends, of a connector of the usual subscription."""


def long(data: int) -> TimedLong:
    return TimedLong(data=data)


def connector(id: str = "c0", **properties: str) -> ConnectorProfile:
    keys = {f"dataport.{key.replace('__', '.')}": value for key, value in properties.items()}
    return ConnectorProfile(id, id, ENDS, keys)


class Told:
    """Two ports of one process, and what was told of them."""

    def __init__(self, tmp_path: Any, *, has_listeners: bool = True) -> None:
        self.out, self.into = OutPort(TimedLong, "out"), InPort(TimedLong, "in")
        self.wiring = PortWiring("localhost", LocalStreams(str(tmp_path / "s")))
        self.events: list[str] = []
        self.values: list[Any] = []
        for port in (self.out, self.into) if has_listeners else ():
            for event in E:
                port.add_listener(event, self.noting(event))

    def noting(self, event: E) -> Callable[[ConnectorProfile, Any], None]:
        def note(made: ConnectorProfile, value: Any) -> None:
            assert made.connector_id == "c0"
            self.events.append(str(event))
            self.values.append(value and value.data)

        return note

    def join(self, **properties: str) -> None:
        self.wiring.join(connector(**properties), self.out, self.into)
        self.events.clear()
        self.values.clear()


@pytest.fixture
def told(tmp_path: Any) -> Iterator[Told]:
    made = Told(tmp_path)
    yield made
    made.wiring.close()


def test_both_ends_tell_of_connectors_that_come_and_go(told: Told):
    told.wiring.join(connector(), told.out, told.into)
    assert [each.connector_id for each in told.into.connector_profiles] == ["c0"]
    told.out.detach("c0")
    told.into.close("c0")
    told.into.close("c0")
    assert told.events == ["connected", "connected", "disconnected", "disconnected"]
    assert told.out.connector_profiles == ()


def test_a_value_is_told_on_its_way_and_when_it_is_read(told: Told):
    told.join()
    assert told.out.write(long(7)) is PortStatus.OK
    assert told.events == ["written", "read", "sent", "received", "written", "received"]
    told.events.clear()
    assert told.into.read() == long(7)
    assert told.into.read() == long(7)
    assert told.events == ["read", "empty"]
    assert set(told.values[:-1]) == {7}
    assert told.values[-1] is None


def test_a_value_sent_at_once_was_in_no_buffer_of_the_out_port(told: Told):
    told.join(subscription_type="flush")
    told.out.write(long(1))
    assert told.events == ["sent", "received", "written", "received"]


def test_a_full_buffer_drops_the_oldest(told: Told):
    told.join(buffer__length="2", subscription_type="flush")
    for number in range(3):
        told.out.write(long(number))
    assert told.events[-4:] == ["received", "overwritten", "written", "received"]
    assert told.events.count("overwritten") == 1
    assert told.values[-3] == 2
    assert [value.data for value in told.into.read_all()] == [1, 2]


@pytest.mark.parametrize(
    ("policy", "status", "end"),
    [
        ("do_nothing", PortStatus.FULL, ["full", "receiver full", "receiver full"]),
        (
            "block",
            PortStatus.TIMEOUT,
            ["write time-out", "receiver time-out", "receiver time-out"],
        ),
    ],
)
def test_a_full_buffer_refuses(told: Told, policy, status, end):
    told.join(
        buffer__length="2",
        subscription_type="flush",
        buffer__write__full_policy=policy,
        buffer__write__timeout="0.01",
    )
    outcomes = [told.out.write(long(number)) for number in range(3)]
    assert outcomes == [PortStatus.OK, PortStatus.OK, status]
    assert told.events[-5:] == ["sent", "received", *end]


def test_a_reader_that_waits_in_vain(told: Told):
    told.join(buffer__read__empty_policy="block", buffer__read__timeout="0.01")
    assert told.into.read() is None
    assert told.events == ["read time-out"]


def test_who_sends_to_a_closed_buffer_is_told_of_an_error(told: Told):
    told.join(buffer__read__empty_policy="block", subscription_type="flush")
    told.into.close("c0")
    told.events.clear()
    assert told.out.write(long(1)) is PortStatus.CONNECTION_LOST
    assert told.events[-1] == "receiver error"


def test_what_is_pulled(told: Told):
    told.join(dataflow_type="pull")
    told.out.write(long(4))
    assert told.events == ["written"]
    told.events.clear()
    assert told.into.read() == long(4)
    assert told.events == ["read", "sent", "received", "written", "read"]
    told.events.clear()
    told.into.read()
    assert set(told.events) == {"empty", "sender empty"}


def test_a_publisher_sends_from_its_buffer(told: Told):
    sent = threading.Event()
    told.into.add_listener(E.WRITTEN, lambda *_: sent.set())
    told.join(subscription_type="periodic", publisher__push_rate="1000")
    told.out.write(long(1))
    assert sent.wait(30)
    told.wiring.send_rest("c0", 30)
    assert told.events == TAKEN


def test_values_that_a_connector_skips_are_not_sent(told: Told):
    told.join(publisher__push_policy="skip", publisher__skip_count="2")
    for number in range(3):
        told.out.write(long(number))
    assert told.events[:2] == ["written", "written"]
    assert told.events[2:] == ["read", "sent", "received", "written", "received", "written"]


def test_between_processes_the_thread_that_takes_values_tells(told: Told, tmp_path):
    other = PortWiring("localhost", LocalStreams(str(tmp_path / "t")))
    try:
        endpoint = told.wiring.receive(connector(), told.into)
        outlet = other.find_receiver(connector(), endpoint)
        other.send(connector(), told.out, outlet)
        threads = []
        here = threading.Event()
        told.into.add_listener(E.RECEIVED, lambda *_: threads.append(threading.current_thread()))
        told.into.add_listener(E.WRITTEN, lambda *_: here.set())
        told.out.write(long(3))
        assert here.wait(30)
        assert threads != [threading.current_thread()]
        assert told.into.read() == long(3)
    finally:
        other.close()
    assert sorted(told.events[2:]) == sorted([*TAKEN, "read"])


def test_between_processes_nobody_has_to_read_and_who_waits_is_woken(told: Told, tmp_path):
    other = PortWiring("localhost", LocalStreams(str(tmp_path / "t")))
    wire = connector(buffer__read__empty_policy="block", buffer__read__timeout="30")
    came = queue.SimpleQueue()
    try:
        endpoint = told.wiring.receive(wire, told.into)
        other.send(wire, told.out, other.find_receiver(wire, endpoint))
        told.into.add_listener(E.WRITTEN, lambda _made, value: came.put(value.data))
        told.out.write(long(1))
        assert came.get(timeout=30) == 1
        assert told.into.read() == long(1)
        reader = threading.Thread(target=lambda: came.put(told.into.read().data + 10))
        reader.start()
        told.out.write(long(2))
        assert sorted(came.get(timeout=30) for _ in range(2)) == [2, 12]
        reader.join()
    finally:
        other.close()


def test_no_value_is_lost_while_listeners_come_and_go(told: Told):
    told.join(buffer__length="100000", subscription_type="flush")
    count, note = 3000, told.noting(E.RECEIVED)
    writers = [
        threading.Thread(target=lambda: [told.out.write(long(1)) for _ in range(count)])
        for _ in range(2)
    ]
    for each in writers:
        each.start()
    while any(each.is_alive() for each in writers):
        for port in (told.out, told.into):
            port.add_listener(E.RECEIVED, note)
            port.remove_listener(E.RECEIVED, note)
    assert len(told.into.read_all()) == 2 * count


@pytest.mark.parametrize("end", ["out", "into"])
@pytest.mark.parametrize(("sent", "read"), [(long(5), 5), (None, 1), (TimedString(data="x"), 1)])
def test_a_listener_may_replace_a_value_by_one_that_fits(told: Told, end, sent, read, caplog):
    told.join()
    event = E.SENT if end == "out" else E.RECEIVED
    getattr(told, end).add_listener(event, lambda *_: sent)
    told.out.write(long(1))
    assert told.into.read() == long(read)
    assert ("listener of" in caplog.text) is isinstance(sent, TimedString)


def test_a_listener_may_replace_what_is_read(told: Told):
    told.join()
    told.into.add_listener(E.READ, lambda _made, value: long(10 * value.data))
    told.out.write(long(1))
    told.out.write(long(2))
    assert told.into.read() == long(10)
    assert told.into.read_all() == [long(20)]


def test_a_value_that_is_left_by_a_closed_connector_is_told_when_it_is_read(told: Told):
    told.join()
    told.out.write(long(1))
    told.into.close("c0")
    told.events.clear()
    assert told.into.read() == long(1)
    assert told.events == ["read"]


def test_what_a_listener_raises_is_logged_once_and_ends_nothing(told: Told, caplog):
    told.join()

    def fail(_made: ConnectorProfile, value: Any) -> None:
        raise SystemExit("no more")

    told.into.add_listener(E.RECEIVED, fail)
    assert [told.out.write(long(number)) for number in range(2)] == [PortStatus.OK] * 2
    assert [value.data for value in told.into.read_all()] == [0, 1]
    (record,) = caplog.records
    assert record.name == "Receiver0"
    assert "port in: listener of received failed: SystemExit: no more" in record.getMessage()


def test_listeners_see_only_values_that_are_sent(told: Told, tmp_path):
    other = PortWiring("localhost", LocalStreams(str(tmp_path / "t")))
    try:
        endpoint = other.receive(connector(), InPort(TimedLong, "in"))
        told.wiring.send(connector(), told.out, told.wiring.find_receiver(connector(), endpoint))
        told.events.clear()
        with pytest.raises(Exception, match="data"):
            told.out.write(TimedLong(data="x"))  # type: ignore[arg-type]
        assert told.events == []
    finally:
        other.close()


def test_a_port_without_listeners_is_as_it_was(tmp_path):
    told = Told(tmp_path, has_listeners=False)
    told.wiring.join(connector(), told.out, told.into)
    ways = told.out._way, told.into._read_from
    note = told.noting(E.SENT)
    told.out.add_listener(E.SENT, note)
    told.into.add_listener(E.READ, note)
    assert ways != (told.out._way, told.into._read_from)
    told.out.remove_listener(E.SENT, note)
    told.out.remove_listener(E.SENT, note)
    told.into.remove_listener(E.READ, note)
    assert ways == (told.out._way, told.into._read_from)
    told.out.write(long(1))
    assert told.events == []


def test_events_of_a_machine_are_told(told: Told):
    port = EventPort("event")
    port.events = {"open": TimedLong}
    for event in (E.CONNECTED, E.RECEIVED, E.WRITTEN, E.DISCONNECTED):
        port.add_listener(event, told.noting(event))
    write = port.open(ConnectorProfile("c0", "open", ENDS, {}))
    assert write(long(3)) is None
    port.close("c0")
    assert told.events == ["connected", "received", "written", "disconnected"]
    assert port.take() == ("open", long(3))
