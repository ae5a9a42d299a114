"""Out ports keep what is written while the other end of a connector is moved."""

from __future__ import annotations

import threading

import pytest

from rtkit.component import Time, TimedLong
from rtkit.component.ports import held_values
from rtkit.component.ports.options import PortStatus
from rtkit.component.ports.out_port import OutPort
from rtkit.rtc.profiles import ConnectorProfile, PortRef

ENDS = (PortRef("A", "out"), PortRef("B", "in"))


def connector(policy: str, length: int = 3) -> ConnectorProfile:
    buffer = "dataport.buffer."
    values = {f"{buffer}write.full_policy": policy, f"{buffer}length": str(length)}
    return ConnectorProfile("w", "w", ENDS, {**values, f"{buffer}write.timeout": "0.05"})


def value(number: int) -> TimedLong:
    return TimedLong(Time(0, 0), number)


@pytest.fixture
def port():
    port = OutPort(TimedLong, "out")
    port.attach("w", lambda _value: None)
    return port


@pytest.mark.parametrize(
    ("policy", "last", "kept"),
    [
        ("overwrite", PortStatus.OK, [2, 3, 4]),
        ("do_nothing", PortStatus.FULL, [1, 2, 3]),
        ("block", PortStatus.TIMEOUT, [1, 2, 3]),
    ],
)
def test_values_are_kept_as_the_policy_says_and_come_first(port, policy, last, kept):
    port.hold(connector(policy))
    assert [port.write(value(number)) for number in (1, 2, 3)] == [PortStatus.OK] * 3
    assert port.write(value(4)) == last
    received = []
    port.attach("w", received.append)
    port.write(value(5))
    assert [each.data for each in received] == [*kept, 5]
    assert port.connectors == ("w",)


def test_a_writer_that_waits_goes_on_when_the_other_end_is_back(port):
    profile = connector("block", 1)
    profile.properties["dataport.buffer.write.timeout"] = "10"
    port.hold(profile)
    port.write(value(1))
    received: list[TimedLong] = []
    writer = threading.Thread(target=lambda: port.write(value(2)))
    writer.start()
    port.attach("w", received.append)
    writer.join()
    assert [each.data for each in received] == [1, 2]


def test_nothing_is_kept_for_an_end_that_does_not_come(port, monkeypatch):
    monkeypatch.setattr(held_values, "HOLD_S", -1.0)
    port.hold(connector("overwrite"))
    assert port.write(value(1)) == PortStatus.CONNECTION_LOST
    received: list[TimedLong] = []
    port.attach("w", received.append)
    port.write(value(2))
    assert [each.data for each in received] == [2]


def test_a_connector_that_is_removed_meanwhile_keeps_nothing(port):
    port.hold(connector("overwrite"))
    port.write(value(1))
    port.detach("w")
    received: list[TimedLong] = []
    port.attach("w", received.append)
    assert received == []
    assert port.write(value(2)) == PortStatus.OK
