"""Arrays of numpy as fields of data types."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rtkit.component import InPort, OutPort, Time
from rtkit.component.sensors import CameraImage, RangeData
from rtkit.component.values.array_twins import with_arrays
from rtkit.component.values.carried import carried
from rtkit.component.values.carried import test_of as passes
from rtkit.component.values.codec import codec_for, encoder_for, splitter_for
from rtkit.component.values.definition import idl_of
from rtkit.component.values.literal import zero_value
from rtkit.component.values.typenames import type_name
from rtkit.container.port_wiring import PortWiring
from rtkit.errors import Malformed
from rtkit.link.local.streams import LocalStreams
from rtkit.rtc.profiles import ConnectorProfile, PortRef


@dataclass(frozen=True, slots=True)
class Scan:
    """Arrays between other fields."""

    name: str
    colours: NDArray[np.uint8]
    ranges: NDArray[np.float64]
    is_valid: NDArray[np.bool_]
    end: str


@dataclass(frozen=True, slots=True)
class AsTuples:
    """The same with sequences."""

    name: str
    colours: bytes
    ranges: tuple[float, ...]
    is_valid: tuple[bool, ...]
    end: str


COLOURS = np.arange(12, dtype=np.uint8).reshape(3, 4)
SCAN = Scan("here", COLOURS, np.linspace(0, 1, 5), np.array([True, False]), "there")
TUPLES = AsTuples("here", bytes(range(12)), (0.0, 0.25, 0.5, 0.75, 1.0), (True, False), "there")


@pytest.mark.parametrize("is_big_endian", [False, True])
def test_an_array_is_a_sequence_on_the_wire(*, is_big_endian: bool) -> None:
    data = encoder_for(Scan, is_big_endian=is_big_endian)(SCAN)
    assert data == encoder_for(AsTuples, is_big_endian=is_big_endian)(TUPLES)
    assert b"".join(splitter_for(Scan, is_big_endian=is_big_endian)(SCAN)) == data
    read = codec_for(Scan).decode(data)
    assert np.array_equal(read.colours, COLOURS.reshape(-1))
    assert np.array_equal(read.ranges, SCAN.ranges)
    assert read.is_valid.tolist() == [True, False]
    assert (read.name, read.end) == ("here", "there")
    assert codec_for(AsTuples).decode(data) == TUPLES


def test_what_is_large_is_copied_neither_by_its_writer_nor_by_its_reader() -> None:
    parts = splitter_for(Scan, is_big_endian=False)(SCAN)
    shared = [np.frombuffer(part, np.uint8) for part in parts if isinstance(part, memoryview)]
    assert any(np.shares_memory(part, COLOURS) for part in shared)
    octets = np.frombuffer(b"".join(parts), np.uint8)
    read = codec_for(Scan).decode(memoryview(octets))
    assert np.shares_memory(read.colours, octets)
    with pytest.raises(ValueError, match="read-only"):
        read.colours[0] = 1


def test_an_empty_array_travels() -> None:
    empty: Any = Scan("", np.zeros(0, np.uint8), np.zeros(0), np.zeros(0, bool), "")
    read = codec_for(Scan).decode(codec_for(Scan).encode(empty))
    assert [len(each) for each in (read.colours, read.ranges, read.is_valid)] == [0, 0, 0]
    assert zero_value(Scan, Time()).ranges.dtype == np.float64


@pytest.mark.parametrize(
    "colours", [np.array([300]), np.array([-1]), [1.5], "abc", None, np.array(["a"])], ids=repr
)
def test_numbers_that_do_not_fit_are_refused(colours: Any) -> None:
    with pytest.raises(Malformed, match="colours"):
        codec_for(Scan).encode(Scan("", colours, np.zeros(1), np.zeros(0, bool), ""))


def test_lists_and_other_numbers_are_taken_where_nothing_is_lost() -> None:
    mixed: Any = Scan("", [1, 2], np.arange(3, dtype=np.float32), [1, 0], "")
    read = codec_for(Scan).decode(codec_for(Scan).encode(mixed))
    assert read.colours.tolist() == [1, 2]
    assert read.ranges.tolist() == [0.0, 1.0, 2.0]


def test_a_reader_here_gets_what_the_writer_cannot_change() -> None:
    source = np.ones(3)
    value = Scan("", COLOURS, source, np.zeros(0, bool), "")
    got = carried(Scan, value)
    source[0] = 5.0
    assert got.ranges.tolist() == [1.0, 1.0, 1.0]
    assert not passes(Scan)(value)
    assert carried(Scan, got) is got  # nobody can change it any more


def test_a_damaged_message_is_refused() -> None:
    data = codec_for(Scan).encode(SCAN)
    for end in range(len(data)):
        with pytest.raises(Malformed):
            codec_for(Scan).decode(data[:end])


def test_its_definition_is_that_of_a_sequence() -> None:
    assert "sequence<octet> colours" in idl_of(Scan)
    assert "sequence<double> ranges" in idl_of(Scan)


def test_an_array_of_nothing_in_particular_is_no_type() -> None:
    @dataclass(frozen=True, slots=True)
    class Vague:
        data: NDArray[Any]

    with pytest.raises(Malformed, match="what numbers"):
        codec_for(Vague)


def test_a_standard_type_has_a_twin_with_arrays() -> None:
    twin = with_arrays(CameraImage)
    assert type_name(twin) == type_name(CameraImage)
    image = CameraImage(Time(1, 2), 2, 2, 8, "gray", 0.5, bytes(range(4)))
    read = codec_for(twin).decode(codec_for(CameraImage).encode(image))
    assert read.pixels.tolist() == [0, 1, 2, 3]
    assert (read.tm.sec, read.width, read.format, twin().pixels.dtype) == (1, 2, "gray", np.uint8)
    assert codec_for(CameraImage).decode(codec_for(twin).encode(read)) == image
    scan = with_arrays(RangeData)
    assert scan().ranges.dtype == np.float64
    assert with_arrays(CameraImage) is twin


def test_ports_of_both_are_connected_in_one_process() -> None:
    out, into = OutPort(CameraImage, "out"), InPort(with_arrays(CameraImage), "in")
    wire = ConnectorProfile("c", "c", (PortRef("A", "out"), PortRef("B", "in")), {})
    PortWiring("", LocalStreams("unused")).join(wire, out, into)
    out.write(CameraImage(pixels=b"\1\2"))
    assert into.read().pixels.tolist() == [1, 2]
