"""Data types as IDL, and classes made of it again, for tools that have none of their own."""

from __future__ import annotations

from dataclasses import dataclass, field, make_dataclass
from enum import Enum, IntEnum
from typing import Annotated

import pytest

from rtkit.component import Long, Time, TimedLong, WString
from rtkit.component.codec import codec_for
from rtkit.component.definition import definition_of, idl_of, name_of
from rtkit.component.geometry import TimedPoint2D
from rtkit.component.port import InPort, OutPort
from rtkit.errors import Malformed, NotFound
from rtkit.idl.read import read_idl
from rtkit.probe.defined import class_of
from rtkit.probe.known_types import data_type
from rtkit.probe.value_text import plain

Mode = Enum("Mode", "IDLE DRIVING")


class Gear(IntEnum):
    R = 7
    N = 1
    FIRST = 2


@dataclass(frozen=True, slots=True)
class Inner:
    name: str = "x"
    grid: tuple[tuple[Long, Long], tuple[Long, Long], tuple[Long, Long]] = ((1, 2),) * 3


@dataclass(frozen=True, slots=True)
class Robot:
    tm: Time = field(default_factory=lambda: Time(3, 4))
    mode: Mode = Mode.DRIVING
    gear: Gear = Gear.N
    inner: tuple[Inner, ...] = (Inner("a"), Inner("b"))
    data: bytes = b"\x01\x02"
    context: WString = "wide"
    local: bool = True
    weight: float = 2.5
    far: int = 2**40
    small: Annotated[int, "int8"] = -3
    pose: TimedPoint2D = field(default_factory=TimedPoint2D)


def test_a_class_made_of_a_definition_reads_and_writes_the_same_bytes() -> None:
    made = class_of(name_of(Robot), idl_of(Robot))
    sent = codec_for(Robot).encode(Robot())
    read = codec_for(made).decode(sent)
    assert plain(read) == plain(Robot())
    assert codec_for(made).encode(read) == sent
    assert read.tm == Time(3, 4)
    assert (read.mode.name, read.gear.name, read.gear.value) == ("DRIVING", "N", 1)


def test_a_port_tells_the_definition_of_a_type_of_its_own() -> None:
    assert OutPort(Robot, "out").profile.definition == idl_of(Robot)
    assert InPort(TimedLong, "in").profile.definition == ""
    assert InPort(bytes, "in").profile.definition == ""
    assert "rtkit.idl" not in OutPort(Robot, "out").properties


def test_arrays_of_enumerations_and_sequences_of_sequences() -> None:
    fields = [("modes", tuple[Mode, Mode]), ("rows", tuple[tuple[Long, ...], ...])]
    cls = make_dataclass("Nested", fields, frozen=True)
    made = class_of(name_of(cls), definition_of(cls))
    value = cls((Mode.IDLE, Mode.DRIVING), ((1, 2), (3,)))
    assert plain(codec_for(made).decode(codec_for(cls).encode(value))) == plain(value)


def test_a_tool_takes_a_type_that_it_knows_before_one_that_it_is_told() -> None:
    assert data_type("RTC::TimedLong", "A:out", "struct TimedLong { long x; };") is TimedLong
    made = data_type("Far::Off", "A:out", "module Far { struct Off { long x; }; };")
    assert made is data_type("IDL:Far/Off:1.0", "B:out", "module Far { struct Off { long x; }; };")
    with pytest.raises(NotFound, match=r"Type not found: No::Such of A:out \(No::Such:1: "):
        data_type("No::Such", "A:out", "rubbish")
    with pytest.raises(NotFound, match="no structure"):
        data_type("No::Such", "A:out", "module No { interface Such {}; };")


@pytest.mark.parametrize(
    "shape", [tuple[int, str], tuple[tuple[int, int], ...]], ids=["two types", "arrays in a row"]
)
def test_what_idl_has_no_words_for_is_told_by_name_only(shape: object) -> None:
    cls = make_dataclass("Odd", [("f", shape)], frozen=True)
    with pytest.raises(Malformed, match="no words for"):
        idl_of(cls)
    assert definition_of(cls) == ""


def test_names_that_are_none_in_idl() -> None:
    assert definition_of(make_dataclass("Odd", [("größe", int)], frozen=True)) == ""


def test_numbers_of_members_are_those_of_their_annotations() -> None:
    found = read_idl("enum Way { @value(4) ON, OFF, @value(value=0) LOST };").find("Way")
    assert found is not None
    assert found.numbers == {"ON": 4, "OFF": 5, "LOST": 0}
    plain = read_idl("enum Way { @default_literal ON, OFF };").find("Way")
    assert plain is not None
    assert (plain.values, plain.numbers) == ((), {"ON": 0, "OFF": 1})


def test_a_data_type_is_a_class() -> None:
    with pytest.raises(Malformed, match="a data type is a class, not 'TimedLong'"):
        OutPort("TimedLong")  # type: ignore[arg-type]
