"""Data types as IDL, and classes made of it again, for tools that have none of their own."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, make_dataclass
from enum import Enum, IntEnum
from types import ModuleType
from typing import Annotated

import pytest

from rtkit.component import Long, Time, TimedLong, WString
from rtkit.component.geometry import TimedPoint2D
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.values.codec import codec_for
from rtkit.component.values.defined import class_of, is_same_definition
from rtkit.component.values.definition import definition_of, docs_of, idl_of, name_of
from rtkit.component.values.value_text import plain
from rtkit.errors import Malformed, NotFound
from rtkit.idl.read import read_idl
from rtkit.probe.known_types import data_type

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


def test_a_sequence_of_arrays_has_the_array_as_a_type_of_its_own() -> None:
    pair = tuple[Long, Long]
    fields = [("pairs", tuple[pair, ...]), ("more", list[tuple[tuple[pair, ...], ...]])]
    cls = make_dataclass("Pairs", [*fields, ("spots", tuple[tuple[Inner], ...])], frozen=True)
    assert "typedef long array_2_long[2];" in definition_of(cls)
    value = cls(((1, 2), (3, 4)), [(((5, 6),),)], ((Inner(),),))
    sent = codec_for(cls).encode(value)
    assert plain(codec_for(class_of(name_of(cls), definition_of(cls))).decode(sent)) == plain(value)


class Left:
    @dataclass(frozen=True)
    class Item:
        x: Long = 0


class Right:
    @dataclass(frozen=True)
    class Item:
        y: float = 2.5


def test_classes_of_one_name_inside_of_others_are_two_types() -> None:
    cls = make_dataclass("Both", [("l", Left.Item), ("r", Right.Item)], frozen=True)
    made = class_of(name_of(cls), definition_of(cls))
    sent = codec_for(cls).encode(cls(Left.Item(7), Right.Item()))
    assert plain(codec_for(made).decode(sent)) == {"l": {"x": 7}, "r": {"y": 2.5}}


def test_two_types_of_one_name_have_no_definition() -> None:
    one = make_dataclass("Same", [("x", int)], frozen=True)
    other = make_dataclass("Same", [("y", float)], frozen=True)
    with pytest.raises(Malformed, match=r"two types are called .*::Same"):
        idl_of(make_dataclass("Outer", [("a", one), ("b", other)], frozen=True))


def test_each_port_has_its_own_type_where_several_have_one_name() -> None:
    texts = ["module My { struct T { long x; }; };", "module My { struct T { double y; }; };"]
    first, second = (data_type("My::T", "A:out", text) for text in texts)
    assert [list(plain(cls())) for cls in (first, second, first)] == [["x"], ["y"], ["x"]]
    assert not is_same_definition("My::T", *texts)
    assert is_same_definition("My::T", texts[0], texts[0].replace("x;", "x;  // metres\n"))
    assert is_same_definition("My::T", texts[0], "rubbish")


@dataclass(frozen=True)
class Rim:
    """A rim.

    Attributes:
        speed: At the rim [m/s], over
            two lines
        unknown: No field.
    """

    speed: float = 0.0
    plain: float = 0.0


def test_what_is_said_of_fields_is_in_the_definition() -> None:
    assert "double speed;  // At the rim [m/s], over two lines\n    double plain;\n" in idl_of(Rim)
    made = class_of(name_of(Rim), idl_of(Rim))
    assert docs_of(made) == {"speed": "At the rim [m/s], over two lines"}
    assert idl_of(made) == idl_of(Rim)


def test_units_and_bounds_of_annotations_are_said_of_fields() -> None:
    text = """struct S {
      @unit("m/s") @range(min=0, max=5) double v;  // speed
      @unit(value="K") float t;  // [K] outside
      @key @default(3) long n;
    };"""
    docs = docs_of(class_of("S", text))
    assert docs == {"v": "speed [m/s] @range(min=0, max=5)", "t": "[K] outside"}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("struct T { octet x[4294967296]; };", "more than"),
        (
            "struct A { long x[1000]; }; struct B { A x[1000]; }; struct T { B x[1000]; };",
            "more than",
        ),
        ("struct T; struct T { sequence<T> x; };", "T cannot be made"),
        ("union T switch (long) { case 1: long x; };", "no structure but a union"),
        ("struct T { any x; };", "any cannot be carried"),
        ("enum T { A };", "not a dataclass"),
        ("struct T { long double x; };", "cannot be carried"),
    ],
)
def test_rubbish_makes_no_class(text: str, told: str) -> None:
    with pytest.raises(Malformed, match=told):
        class_of("T", text)


def test_members_of_enumerations_that_python_has_other_uses_for() -> None:
    made = class_of("T", "enum E { mro, name, value, class, FREE }; struct T { E e; };")
    value = codec_for(made).decode(b"\0\1\0\0\2\0\0\0")
    assert [each.name for each in type(value.e)] == ["mro_", "name_", "value_", "class_", "FREE"]
    assert value.e.name == "value_"


@pytest.mark.parametrize(
    ("module", "file", "told"),
    [
        ("rtkit_module__home_me_Rover_py", "/home/me/Rover.py", "Rover::Spot"),
        ("__main__", "/home/me/my-rover.py", "my_rover::Spot"),
        ("__main__", None, "main::Spot"),
        ("robot.parts._types", None, "types::Spot"),
    ],
)
def test_a_type_is_named_after_its_file_wherever_that_is(
    module: str, file: str | None, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = ModuleType(module)
    loaded.__file__ = file
    monkeypatch.setitem(sys.modules, module, loaded)
    spot = make_dataclass("Spot", [("x", int)], frozen=True, namespace={"__module__": module})
    assert name_of(spot) == told
    assert definition_of(spot)


def test_what_idl_has_no_words_for_is_told_by_name_only() -> None:
    cls = make_dataclass("Odd", [("f", tuple[int, str])], frozen=True)
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
