"""Law of ports: a reader gets the same from a writer in its own process as from another one."""

from __future__ import annotations

import math
from dataclasses import fields, is_dataclass, make_dataclass
from enum import Enum, Flag, IntEnum

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.component.types import (
    Char,
    Double,
    Float,
    Long,
    Octet,
    Short,
    ULong,
    ULongLong,
    WChar,
    WString,
)
from rtkit.component.values.codec import codec_for, encoder_for
from rtkit.component.values.defined import class_of
from rtkit.component.values.definition import definition_of, idl_of, name_of
from rtkit.component.values.value_text import plain
from rtkit.container.port_wiring import PortWiring
from rtkit.errors import Malformed
from rtkit.link.local.streams import LocalStreams
from rtkit.rtc.profiles import ConnectorProfile, PortRef

Mode = Enum("Mode", "IDLE DRIVING")
Level = IntEnum("Level", "LOW HIGH")
Lamps = Flag("Lamps", "LEFT RIGHT")
Inner = make_dataclass("Inner", [("n", Short), ("f", Float)], frozen=True, slots=True)
Loose = make_dataclass("Loose", [("n", Long)])

SCALARS = (
    *(bool, Char, WChar, Octet, Short, Long, ULong, ULongLong, int, Float, Double, float),
    *(str, WString, bytes, Mode, Level, Lamps, Inner, Loose),
)
KINDS = st.recursive(
    st.sampled_from(SCALARS),
    lambda inner: st.one_of(
        inner.map(lambda kind: tuple[kind, ...]),
        inner.map(lambda kind: list[kind]),
        inner.map(lambda kind: tuple[kind, kind]),
    ),
    max_leaves=2,
)
LEAVES = st.one_of(
    st.booleans(),
    st.integers(-(2**64), 2**64),
    st.integers(-2, 300),
    st.floats(),
    st.floats(width=32),
    st.text(max_size=2),
    st.characters(max_codepoint=0x110),
    st.binary(max_size=3),
    st.binary(max_size=3).map(bytearray),
    st.sampled_from([*Mode, *Level, *Lamps, Lamps(0), Lamps(3), None, object()]),
    st.sampled_from([numpy.float32(0.5), numpy.int16(7), numpy.bool_(True), numpy.float64(0.1)]),
    st.sampled_from(
        [
            *(numpy.arange(2).astype(kind) for kind in ("uint8", "int8", "int32", "float64", "?")),
            numpy.zeros((2, 2)),
            numpy.zeros((2, 2), "uint8"),
            numpy.zeros((2, 1), "int16"),
        ]
    ),
    st.builds(Inner, st.integers(-9, 9), st.floats(width=32)),
    st.builds(Inner, st.floats(), st.integers()),
    st.builds(Loose, st.integers(-9, 9)),
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.lists(inner, max_size=3).map(tuple),
        inner.map(lambda one: (one, one)),
    ),
    max_leaves=3,
)
_classes = {}


def class_with(kinds):
    if str(kinds) not in _classes:
        members = [(f"f{index}", kind) for index, kind in enumerate(kinds)]
        _classes[str(kinds)] = make_dataclass("Data", members, frozen=True, slots=True)
    return _classes[str(kinds)]


@st.composite
def right_records(draw):
    kinds = tuple(draw(st.lists(KINDS, min_size=1, max_size=2)))
    return class_with(kinds)(*(draw(right(kind)) for kind in kinds))


@st.composite
def records(draw):
    kinds = tuple(draw(st.lists(KINDS, min_size=1, max_size=2)))
    cls = class_with(kinds)
    return cls(*(draw(st.one_of(right(kind), near(kind), VALUES)) for kind in kinds))


def right(kind):
    """Values that a field of this annotation may well have."""
    return build(kind, usual)


def near(kind):
    """Values at the edge of what such a field may have, of the right classes."""
    return build(kind, at_the_edge)


def build(kind, scalar):
    base = getattr(kind, "__origin__", None)
    if base is tuple and kind.__args__[-1] is not ...:
        return st.tuples(*(build(arg, scalar) for arg in kind.__args__))
    if base in (tuple, list):
        items = st.lists(build(kind.__args__[0], scalar), max_size=3)
        return items if base is list else items.map(tuple)
    if kind is Inner:
        return st.builds(Inner, build(Short, scalar), build(Float, scalar))
    return st.builds(Loose, build(Long, scalar)) if kind is Loose else scalar(kind)


EDGES = {
    "int16": [-(2**15) - 1, -(2**15), 2**15 - 1, 2**15],
    "int32": [-(2**31) - 1, -(2**31), 2**31 - 1, 2**31],
    "uint8": [-1, 0, 255, 256],
    "uint32": [-1, 0, 2**32 - 1, 2**32],
    "uint64": [-1, 0, 2**64 - 1, 2**64],
    "float32": [0.1, 0.5, -0.0, 3.5e38, float("inf"), float("nan")],
    "float64": [0.1, -0.0, 1e308, float("-inf"), float("nan")],
    "char": ["", "a", "\xff", "\u0100", "ab"],
    "wchar": ["", "a", "\ud7ff", "\ud800", "\ue000", "\uffff", "\U00010000"],
    "wstring": ["", "\0", "\ud800", "\U00010000"],
    int: [-(2**63) - 1, -(2**63), 2**63 - 1, 2**63],
    float: [0.1, -0.0, float("nan")],
    str: ["", "a\0", "\ud800", "\U00010000"],
    bool: [True, False],
    bytes: [b"", b"\0"],
    Mode: list(Mode),
    Level: list(Level),
    Lamps: [*Lamps, Lamps(0), Lamps(3)],
}


def at_the_edge(kind):
    (key,) = getattr(kind, "__metadata__", (kind,))
    return st.sampled_from(EDGES[key])


def usual(kind):
    base, notes = getattr(kind, "__origin__", None), getattr(kind, "__metadata__", ())
    if isinstance(kind, type) and issubclass(kind, Enum):
        return st.sampled_from(list(kind))
    if notes and notes[0].endswith("char"):
        return st.characters(max_codepoint=0xFF)
    plain = {bool: st.booleans(), bytes: st.binary(max_size=3), str: st.text(max_size=3)}
    plain |= {int: st.integers(0, 127), float: st.floats(width=32)}
    return plain[base or kind]


def joined(cls):
    out, into = OutPort(cls, "out"), InPort(cls, "into")
    wire = ConnectorProfile("w", "w", (PortRef("A", "out"), PortRef("B", "into")), {})
    PortWiring("", LocalStreams("unused")).join(wire, out, into)
    return out, into


def outcome(action, *arguments):
    try:
        return action(*arguments)
    except Malformed as error:
        return str(error)


def same(one, other):
    """Whether two values are of the same types, and equal, to the innermost; NaN is NaN."""
    if type(one) is not type(other):
        return False
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        both = math.copysign(1, one) == math.copysign(1, other) and one == other
        return both or (one != one and other != other)
    return one == other


def check(value):
    """Hold what a reader here gets against what the codec would hand to one elsewhere."""
    cls = type(value)
    out, into = joined(cls)
    there = outcome(lambda: codec_for(cls).decode(codec_for(cls).encode(value)))
    told = outcome(out.write, value)
    if isinstance(there, str):
        assert (told, into.read()) == (f"port out: {there}", None)
    else:
        assert same(into.read(), there)


@given(records())
def test_a_reader_gets_the_same_from_its_own_process_as_from_another(value):
    check(value)


@given(right_records())
def test_a_tool_reads_values_by_the_definition_of_their_type(value):
    cls = type(value)
    data = outcome(codec_for(cls).encode, value)
    definition = definition_of(cls)
    if isinstance(data, str):
        return  # a field of it cannot be carried
    if not definition:
        assert "no words for" in outcome(idl_of, cls)
        return
    made = codec_for(class_of(name_of(cls), definition))
    read = made.decode(data)
    assert repr(plain(read)) == repr(plain(codec_for(cls).decode(data)))
    assert made.encode(read) == data


@pytest.mark.parametrize("kind", [each for each in SCALARS if each not in (Inner, Loose)], ids=str)
def test_it_does_at_the_edges_of_each_type(kind):
    (key,) = getattr(kind, "__metadata__", (kind,))
    shapes = {
        kind: lambda edge: edge,
        tuple[kind, ...]: lambda edge: (edge,),
        tuple[kind, kind]: lambda edge: (EDGES[key][-2], edge),
        list[kind]: lambda edge: [edge],
    }
    for shape, make in shapes.items():
        cls = make_dataclass("Data", [("f", shape)], frozen=True, slots=True)
        for edge in EDGES[key]:
            check(cls(make(edge)))
    pair = make_dataclass("Data", [("f", tuple[kind, kind])], frozen=True, slots=True)
    check(pair((EDGES[key][0],) * 3))


@given(records())
def test_both_orders_of_bytes_are_one_value(value):
    codec = codec_for(type(value))
    little = outcome(codec.encode, value)
    big = outcome(encoder_for(type(value), is_big_endian=True), value)
    if isinstance(little, str):
        assert big == little
    else:
        assert big[:4] == bytes(4)
        assert same(codec.decode(big), codec.decode(little))


def changeable(value):
    if isinstance(value, (list, Loose)):
        return True
    if isinstance(value, tuple):
        return any(map(changeable, value))
    return is_dataclass(value) and any(changeable(getattr(value, f.name)) for f in fields(value))


@given(records())
def test_two_readers_share_nothing_that_can_be_changed(value):
    out, into = joined(type(value))
    again = InPort(type(value), "again")
    wire = ConnectorProfile("v", "v", (PortRef("A", "out"), PortRef("B", "again")), {})
    PortWiring("", LocalStreams("unused")).join(wire, out, again)
    if isinstance(outcome(out.write, value), str):
        return
    one, other = into.read(), again.read()
    assert same(one, other)
    for field in fields(value):
        mine, its = getattr(one, field.name), getattr(other, field.name)
        if changeable(mine):
            assert mine is not its
            assert mine is not getattr(value, field.name)
