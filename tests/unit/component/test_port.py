"""Ports: writing, reading, opening and closing connectors."""

from __future__ import annotations

from threading import Thread

import pytest

from rtkit.component import InPort, OutPort, PortStatus, ServicePort, TimedDouble, TimedLong
from rtkit.errors import Malformed, Refused
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import ConnectorProfile


def connector(id="c0", **properties):
    keys = {key.replace("__", "."): value for key, value in properties.items()}
    return ConnectorProfile(id, id, (), keys)


def long(data):
    return TimedLong(data=data)


@pytest.fixture
def out():
    return OutPort(TimedLong, "out")


@pytest.fixture
def into():
    return InPort(TimedLong, "in")


def join(out, into, *, at="c0", **properties):
    out.attach(at, into.open(connector(at, **properties)))


def test_a_value_arrives_as_the_same_object(out, into):
    join(out, into)
    value = long(1)
    assert out.write(value) is PortStatus.OK
    assert into.is_new()
    assert into.read() is value
    assert not into.is_new()
    assert (out.written, into.read_count) == (1, 1)


def test_reading_an_empty_port_gives_the_last_value_again(out, into):
    join(out, into)
    assert into.read() is None
    out.write(long(1))
    assert into.read() == into.read() == long(1)
    assert into.read_count == 1


def test_do_nothing_reads_none(out, into):
    join(out, into, dataport__inport__buffer__read__empty_policy="do_nothing")
    out.write(long(1))
    assert into.read() == long(1)
    assert into.read() is None


def test_block_waits_for_a_value(out, into):
    join(
        out,
        into,
        dataport__inport__buffer__read__empty_policy="block",
        dataport__inport__buffer__read__timeout="30",
    )
    results = []
    thread = Thread(target=lambda: results.append(into.read()))
    thread.start()
    out.write(long(5))
    thread.join(30)
    assert results == [long(5)]


def test_closing_wakes_a_reader_that_waits(out, into):
    join(
        out,
        into,
        dataport__inport__buffer__read__empty_policy="block",
        dataport__inport__buffer__read__timeout="50",
    )
    results = []
    thread = Thread(target=lambda: results.append(into.read()))
    thread.start()
    into.close("c0")
    thread.join(30)
    assert results == [None]


def test_values_come_in_order_and_the_oldest_are_dropped(out, into):
    join(out, into, dataport__inport__buffer__length="3")
    for number in range(5):
        out.write(long(number))
    assert [value.data for value in into.read_all()] == [2, 3, 4]
    assert into.read_all() == []
    assert into.read() == long(4)


def test_a_full_buffer_tells_the_writer(out, into):
    join(
        out,
        into,
        dataport__inport__buffer__length="2",
        dataport__inport__buffer__write__full_policy="do_nothing",
    )
    assert [out.write(long(n)) for n in range(3)] == [
        PortStatus.OK,
        PortStatus.OK,
        PortStatus.FULL,
    ]


def test_defaults_of_the_port_count_where_the_connector_is_silent(out):
    into = InPort(TimedLong, "in", {"dataport.inport.buffer.length": "2"})
    join(out, into)
    join(out, into, at="c1", dataport__inport__buffer__length="4")
    for number in range(5):
        out.write(long(number))
    assert sorted(value.data for value in into.read_all()) == [1, 2, 3, 3, 4, 4]


def test_a_connector_that_floods_does_not_starve_another(into):
    flood, trickle = OutPort(TimedLong, "flood"), OutPort(TimedLong, "trickle")
    join(flood, into, at="a")
    join(trickle, into, at="b")
    for number in range(8):
        flood.write(long(number))
    trickle.write(long(100))
    assert long(100) in [into.read(), into.read()]


def test_a_value_of_another_type_is_refused_at_the_writer(out, into):
    join(out, into)
    with pytest.raises(Malformed, match="port out carries TimedLong, not TimedDouble"):
        out.write(TimedDouble())
    assert not into.is_new()


def test_a_value_of_a_derived_type_passes(out, into):
    class Special(TimedLong):
        pass

    join(out, into)
    out.write(Special(data=1))
    assert into.read().data == 1


def test_a_sink_that_fails_does_not_keep_values_from_others(out, into):
    def broken(value):
        raise OSError("gone")

    out.attach("x", broken)
    join(out, into)
    with pytest.raises(OSError, match="gone"):
        out.write(long(1))
    assert into.read() == long(1)


def test_the_same_id_twice_and_too_many_are_refused(out, into):
    join(out, into)
    with pytest.raises(Refused, match="c0"):
        into.open(connector("c0"))
    with pytest.raises(Refused, match="c0"):
        out.attach("c0", print)
    one = InPort(TimedLong, "in", {"dataport.fan_in": "1"})
    one.open(connector("a"))
    with pytest.raises(Refused, match="no more than 1"):
        one.open(connector("b"))
    one.close("a")
    one.open(connector("b"))
    assert one.connectors == ("b",)


def test_wrong_properties_open_nothing(into):
    with pytest.raises(Malformed, match=r"dataport\.inport\.buffer\.length=x"):
        into.open(connector(dataport__inport__buffer__length="x"))
    assert into.connectors == ()


def test_after_closing_nothing_arrives(out, into):
    join(out, into)
    assert out.connectors == into.connectors == ("c0",)
    out.detach("c0")
    into.close("c0")
    assert out.connectors == into.connectors == ()
    assert out.write(long(1)) is PortStatus.OK
    assert not into.is_new()
    out.detach("c0")
    into.close("c0")


def test_what_brief_connectors_brought_before_the_port_was_read_is_read(out, into):
    for number in range(3):
        join(out, into, at=f"c{number}")
        out.write(long(number))
        out.detach(f"c{number}")
        into.close(f"c{number}")
    assert [value.data for value in into.read_all()] == [0, 1, 2]
    assert not into.is_new()


def test_pull_fetches_when_read(out, into):
    profile = connector(
        dataport__outport__buffer__length="2",
        dataport__outport__buffer__read__empty_policy="do_nothing",
    )
    into.open_pull(profile, out.open_pull(profile))
    assert not into.is_new()
    for number in range(3):
        out.write(long(number))
    assert into.is_new()
    assert [into.read().data, into.read().data, into.read().data] == [1, 2, 2]
    out.write(long(9))
    assert [value.data for value in into.read_all()] == [9]
    out.detach("c0")
    assert out.write(long(1)) is PortStatus.OK
    assert not into.is_new()


def test_connectors_come_and_go_while_another_thread_writes(out, into):
    steady = InPort(TimedLong, "steady")
    join(out, steady, at="steady", dataport__inport__buffer__length="1000000")
    count = 20_000
    outcomes = set()
    thread = Thread(target=lambda: outcomes.update(out.write(long(n)) for n in range(count)))
    thread.start()
    rounds = 0
    while thread.is_alive():
        join(out, into, at=f"c{rounds}")
        out.detach(f"c{rounds}")
        into.close(f"c{rounds}")
        rounds += 1
    assert rounds
    assert outcomes == {PortStatus.OK}
    assert [value.data for value in steady.read_all()] == list(range(count))
    assert out.connectors == ("steady",)


def test_profiles(out, into):
    profile = into.profile
    assert profile.port_type is PortType.IN
    assert profile.data_type == "IDL:RTC/TimedLong:1.0"
    assert profile.properties["port.port_type"] == "DataInPort"
    assert "direct" in profile.properties["dataport.interface_type"]
    assert out.profile.port_type is PortType.OUT
    assert InPort(TimedLong, "a", doc="Why").profile.properties["description"] == "Why"
    assert InPort(bytes, "a").profile.data_type == "any"


def test_service_ports_are_opened_within_their_limit():
    port = ServicePort("s", (), {"connection_limit": "1"})
    port.attach(connector("a"))
    port.attach(connector("a"))
    assert port.connectors == ("a",)
    with pytest.raises(Refused):
        port.attach(connector("b"))
    port.detach("a")
    assert port.connectors == ()
