"""What readers in the writer's own process get: checked, and nobody else's to change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy
import pytest

from rtkit.component import InPort, Long, OutPort, TimedDoubleSeq, TimedLong, TimedOctetSeq
from rtkit.component.geometry import TimedPose2D
from rtkit.component.images import CameraImage, ImageData
from rtkit.component.ports.options import PortStatus
from rtkit.component.values import carried as carried_module
from rtkit.component.values.carried import passage
from rtkit.component.values.codec import codec_for
from rtkit.container.port_wiring import PortWiring
from rtkit.errors import Malformed
from rtkit.link.local.streams import LocalStreams
from rtkit.rtc.profiles import ConnectorProfile, PortRef


def joined(cls, read=None, count=1, **properties):
    """An out port, and in ports of the same process that it is connected with."""
    out = OutPort(cls, "out")
    into = [InPort(read or cls, f"in{number}") for number in range(count)]
    wires = PortWiring("", LocalStreams("unused"))
    for each in into:
        ends = (PortRef("A", "out"), PortRef("B", each.name))
        wires.join(ConnectorProfile(each.name, each.name, ends, properties), out, each)
    return out, *into


def test_what_nobody_can_change_is_handed_over_itself():
    for value in (TimedPose2D(), TimedOctetSeq(data=bytes(9)), TimedDoubleSeq(data=(1.0, 2.0))):
        out, into = joined(type(value))
        out.write(value)
        assert into.read() is value


def test_a_buffer_that_is_filled_again_does_not_change_what_was_sent():
    out, into = joined(TimedOctetSeq)
    pixels = numpy.zeros((2, 2, 3), "uint8")
    for number in (1, 2):
        pixels[:] = number
        out.write(TimedOctetSeq(data=pixels))
    assert [value.data for value in into.read_all()] == [b"\1" * 12, b"\2" * 12]
    out, into = joined(TimedDoubleSeq)
    numbers = numpy.array([0.5, 1.5])
    out.write(TimedDoubleSeq(data=numbers))
    numbers[0] = 9.0
    assert into.read().data == (0.5, 1.5)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (TimedLong(data=2**40), "TimedLong.data: 1099511627776 is not a value of type int32"),
        (TimedLong(data=1.5), "TimedLong.data: 1.5 is not a value of type int32"),
        (
            CameraImage(image=ImageData(raw_data=numpy.zeros((2, 3)))),
            "CameraImage.image.raw_data: array of float64 and shape (2, 3) is not a value of type"
            " sequence<octet>",
        ),
        (
            TimedDoubleSeq(data=numpy.zeros((2, 1))),
            "TimedDoubleSeq.data: array of float64 and shape (2, 1) is not a value of type"
            " sequence<float64>",
        ),
    ],
    ids=str,
)
@pytest.mark.parametrize("is_connected", [True, False])
def test_a_value_that_does_not_fit_is_refused_where_it_is_written(value, told, is_connected):
    out, into = joined(type(value)) if is_connected else (OutPort(type(value), "out"), None)
    with pytest.raises(Malformed) as caught:
        out.write(value)
    assert str(caught.value) == f"port out: {told}"
    assert out.written == 0
    assert into is None or not into.is_new()


SKIPPING = {"dataport.publisher.skip_count": "2"}


class Outlet:
    """Stands for a stream to another process."""

    patience_s = 0.0

    def __init__(self):
        self.sent = []
        self.offer = self.put

    def put(self, payload):
        self.sent.append(payload)
        return True


def sent(cls, **properties):
    """An out port that sends to another process, and what has been sent."""
    out, outlet = OutPort(cls, "out"), Outlet()
    wire = ConnectorProfile("far", "far", (PortRef("A", "out"), PortRef("B", "in")), properties)
    PortWiring("", LocalStreams("unused")).send(wire, out, outlet)
    return out, outlet.sent


def test_what_goes_to_other_processes_only_is_not_copied_before(monkeypatch):
    out, payloads = sent(TimedDoubleSeq)
    monkeypatch.setattr(carried_module, "carried", None)
    assert out.write(TimedDoubleSeq(data=numpy.ones(2))) is PortStatus.OK
    whole = [b"".join(parts) for parts in payloads]
    assert whole == [codec_for(TimedDoubleSeq).encode(TimedDoubleSeq(data=(1.0, 1.0)))]


@pytest.mark.parametrize("value", [TimedLong(data=2**40), TimedDoubleSeq()], ids=str)
def test_a_value_that_does_not_fit_is_refused_before_it_is_sent(value):
    out, payloads = sent(TimedLong)
    with pytest.raises(Malformed, match=r"^port out") as caught:
        out.write(value)
    assert str(caught.value) == refusal(OutPort(TimedLong, "out"), value)
    assert (out.written, payloads) == (0, [])


def refusal(out, value):
    with pytest.raises(Malformed) as caught:
        out.write(value)
    return str(caught.value)


@pytest.mark.parametrize("is_first", [True, False])
def test_what_a_reader_here_gets_too_is_copied(is_first):
    out, into = OutPort(TimedDoubleSeq, "out"), InPort(TimedDoubleSeq, "in")
    wires = PortWiring("", LocalStreams("unused"))
    far, near = (
        ConnectorProfile(name, name, (PortRef("A", "out"), PortRef("B", "in")))
        for name in ("far", "near")
    )
    steps = [lambda: wires.send(far, out, Outlet()), lambda: wires.join(near, out, into)]
    for step in steps if is_first else steps[::-1]:
        step()
    array = numpy.ones(2)
    out.write(TimedDoubleSeq(data=array))
    array[:] = 7.0
    assert into.read().data == (1.0, 1.0)


def test_what_is_sent_later_is_copied():
    out, _ = sent(TimedLong, **{"dataport.publisher.push_policy": "skip"}, **SKIPPING)
    with pytest.raises(Malformed):
        out.write(TimedLong(data=2**40))


@pytest.mark.parametrize(
    ("asked", "head"), [("big", b"\0\0"), ("Big,little", b"\0\0"), ("little,big", b"\0\1")]
)
@pytest.mark.parametrize("flow", ["push", "pull"])
def test_the_order_of_bytes_is_what_the_connector_says(asked, head, flow):
    asks = {"dataport.serializer.cdr.endian": asked, "dataport.dataflow_type": flow}
    out, into = joined(TimedLong, bytes, **asks)
    out.write(TimedLong(data=7))
    data = into.read()
    assert data[:2] == head
    assert codec_for(TimedLong).decode(data).data == 7
    out, into = joined(TimedLong, **asks)
    out.write(TimedLong(data=7))
    assert into.read().data == 7


@dataclass
class Loose:
    number: Long
    rest: list[Long]


@pytest.mark.parametrize("flow", ["push", "pull"])
def test_each_reader_has_its_own_of_what_can_be_changed(flow):
    out, one, other = joined(Loose, count=2, **{"dataport.dataflow_type": flow})
    value = Loose(1, [2])
    out.write(value)
    value.number, value.rest[0] = 8, 9
    mine = one.read()
    assert mine == Loose(1, [2])
    mine.rest.append(3)
    assert other.read() == Loose(1, [2])


@dataclass(frozen=True)
class Strict:
    number: Long

    def __post_init__(self):
        if self.number < 0:
            raise ValueError("negative")


def test_a_value_of_another_class_becomes_one_of_the_reader_s(caplog):
    out, into = joined(TimedLong, bytes)
    value = TimedLong(data=4)
    out.write(value)
    assert into.read() == codec_for(TimedLong).encode(value)
    other = dataclass(frozen=True)(type("Other", (), {"__annotations__": {"number": Long}}))
    out, into = joined(other, Strict)
    for number in (1, -1, 2):
        out.write(other(number))
    assert into.read_all() == [Strict(1), Strict(2)]
    assert "value dropped: Strict: negative" in caplog.text


def test_a_type_that_cannot_be_carried_is_refused_when_ports_are_connected():
    kept = dataclass(frozen=True)(type("Kept", (), {"__annotations__": {"what": object}}))
    with pytest.raises(Malformed, match=r"Kept\.what cannot be carried"):
        joined(kept)
    assert passage(bytes, bytes) is None
