"""CDR, byte for byte as pycdr2 writes it; whatever arrives gives a value or `Malformed`."""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass, field, is_dataclass, make_dataclass, replace
from enum import Enum, IntEnum
from typing import Annotated, Optional

import pycdr2
import pytest

from rtkit.component import Char as OneChar
from rtkit.component import (
    Double,
    Float,
    Long,
    Octet,
    Short,
    Time,
    TimedLong,
    ULong,
    actuators,
    extended,
    geometry,
    images,
    navigation,
    sensors,
    timed,
    types,
)
from rtkit.component.values import codegen
from rtkit.component.values.codec import BYTES, codec_for, encoder_for
from rtkit.component.values.type_layout import (
    ArrayLayout,
    EnumLayout,
    ItemsLayout,
    StructLayout,
    layout_of,
    zero,
)
from rtkit.errors import Malformed

BASIC = [
    cls
    for module in (types, timed, geometry, extended, sensors, actuators, navigation, images)
    for cls in (getattr(module, name) for name in dir(module))
    if isinstance(cls, type) and is_dataclass(cls) and cls.__module__ == module.__name__
]


class Colour(IntEnum):
    RED = 0
    GREEN = 5
    BLUE = -1


class Mood(Enum):
    GOOD = "good"
    BAD = "bad"


@dataclass(frozen=True, slots=True)
class Inner:
    flag: bool
    number: Long
    letter: OneChar


@dataclass
class Mixed:
    small: Octet
    big: Double
    words: list[str]
    items: tuple[Inner, ...]
    odd: Short
    nested: list[list[Double]]
    raw: bytes
    pair: tuple[Long, Double]
    flags: tuple[bool, ...]
    last: float


@dataclass
class Plain:
    whole: int
    real: float
    text: str
    colour: Colour
    mood: Mood


MIXED = Mixed(
    small=7,
    big=1.5,
    words=["", "a", "grüße"],
    items=(Inner(True, -1, "x"), Inner(False, 2, "y")),
    odd=-2,
    nested=[[1.0], [], [2.0, math.inf]],
    raw=b"\0\1\2",
    pair=(3, 4.5),
    flags=(True, False, True),
    last=-0.0,
)


def foreign(layout):
    """The pycdr2 type of the same layout, and a function that turns a value into its value."""
    if isinstance(layout, StructLayout):
        parts = {name: foreign(item) for name, item in layout.fields}
        cls = make_dataclass(
            f"Foreign{layout.name}",
            [(name, hint) for name, (hint, _) in parts.items()],
            bases=(pycdr2.IdlStruct,),
        )
        return cls, lambda value: cls(
            **{name: turn(getattr(value, name)) for name, (_, turn) in parts.items()}
        )
    if isinstance(layout, ItemsLayout):
        hint, turn = foreign(layout.item)
        return pycdr2.types.sequence[hint], lambda value: [turn(item) for item in value]
    if isinstance(layout, ArrayLayout):
        hint, turn = foreign(layout.items[0])
        count = len(layout.items)
        return pycdr2.types.array[hint, count], lambda value: [turn(item) for item in value]
    if isinstance(layout, EnumLayout):
        members = {member.name: number for member, number in layout.numbers.items()}
        cls = pycdr2.IdlEnum(f"Foreign{layout.name}", members)
        return cls, lambda value: cls[value.name]
    if layout.cls is bytes:
        return pycdr2.types.sequence[pycdr2.types.uint8], list
    if layout.cls in (int, float):
        return getattr(pycdr2.types, layout.name), lambda value: value
    if layout.name == "char":
        return pycdr2.types.char, lambda value: value
    return layout.cls, lambda value: value


@pytest.mark.parametrize("cls", [c for c in BASIC if "TimedW" not in c.__name__])
def test_basic_types_are_written_as_by_pycdr2(cls):
    _, turn = foreign(layout_of(cls))
    for value in (cls(), sample(layout_of(cls), 3)):
        assert codec_for(cls).encode(value) == turn(value).serialize()


def sample(layout, seed):
    if isinstance(layout, StructLayout):
        parts = {n: sample(item, seed + i) for i, (n, item) in enumerate(layout.fields)}
        return layout.cls(**parts)
    if isinstance(layout, ItemsLayout):
        return layout.make(sample(layout.item, seed + i) for i in range(seed % 4 + 1))
    if isinstance(layout, ArrayLayout):
        return tuple(sample(item, seed + i) for i, item in enumerate(layout.items))
    if layout.cls in (int, float):
        return seed / 4 if layout.cls is float else seed
    if isinstance(layout, EnumLayout):
        return list(layout.numbers)[seed % len(layout.numbers)]
    if layout.cls is bytes:
        return bytes(range(seed))
    return {"boolean": True, "char": "c", "wchar": "長"}.get(layout.name, "text" * seed)


@pytest.mark.parametrize("cls", [*BASIC, Plain, Mixed])
def test_round_trip(cls):
    codec = codec_for(cls)
    for seed in range(6):
        value = sample(layout_of(cls), seed)
        assert codec.decode(codec.encode(value)) == value
    assert codec.decode(codec.encode(zero(layout_of(cls)))) == zero(layout_of(cls))


def test_alignment_after_variable_parts_is_that_of_pycdr2():
    t = pycdr2.types
    names = ["words", "small", "reals", "short", "real"]
    hints = [t.sequence[str], t.uint8, t.sequence[t.float64], t.int16, t.float64]
    foreign_cls = make_dataclass(
        "Foreign", list(zip(names, hints, strict=True)), bases=(pycdr2.IdlStruct,)
    )

    @dataclass
    class Own:
        words: list[str]
        small: Octet
        reals: list[float]
        short: Short
        real: float

    for words in ([], ["a"], ["ab", "c"], ["abc", "", "defgh"]):
        for reals in ([], [1.0, 2.0]):
            written = codec_for(Own).encode(Own(words, 1, reals, -2, 2.5))
            assert written == foreign_cls(words, 1, reals, -2, 2.5).serialize()
            assert codec_for(Own).decode(written) == Own(words, 1, reals, -2, 2.5)


def test_mixed_by_pycdr2_without_what_it_lacks():
    layout = layout_of(Mixed)
    kept = StructLayout(Mixed, tuple(f for f in layout.fields if f[0] != "pair"), "Mixed")
    cls = make_dataclass("Kept", [(n, Mixed.__annotations__[n]) for n, _ in kept.fields])
    cls.__module__ = __name__
    _, turn = foreign(kept)
    value = cls(**{n: getattr(MIXED, n) for n, _ in kept.fields})
    assert codec_for(cls).encode(value) == turn(MIXED).serialize()


def test_the_bytes_are_those_of_the_standard():
    value = TimedLong(Time(1, 2), -3)
    assert codec_for(TimedLong).encode(value) == bytes.fromhex(
        "00010000 01000000 02000000 fdffffff"
    )


def test_big_endian_is_read():
    data = b"\0\0\0\0" + struct.pack(">IIi", 1, 2, -3)
    assert codec_for(TimedLong).decode(data) == TimedLong(Time(1, 2), -3)
    words = timed.TimedStringSeq(Time(1, 2), ("a", "bcd"))
    swapped = b"\0\0\0\0" + struct.pack(">IIIi2sxxI4s", 1, 2, 2, 2, b"a\0", 4, b"bcd\0")
    assert codec_for(timed.TimedStringSeq).decode(swapped) == words


def test_nan_and_infinity_pass():
    codec = codec_for(timed.TimedFloat)
    assert math.isnan(codec.decode(codec.encode(timed.TimedFloat(data=math.nan))).data)
    assert codec.decode(codec.encode(timed.TimedFloat(data=-math.inf))).data == -math.inf


def test_wide_text_is_utf16():
    codec = codec_for(timed.TimedWString)
    data = codec.encode(timed.TimedWString(data="aß𝄞"))
    assert data[12:] == struct.pack("<I", 8) + "aß𝄞".encode("utf-16-le")
    assert codec.decode(data).data == "aß𝄞"


def test_enums_travel_as_their_numbers():
    codec = codec_for(Plain)
    data = codec.encode(Plain(1, 2.0, "", Colour.BLUE, Mood.BAD))
    assert struct.unpack("<ii", data[-8:]) == (-1, 1)
    with pytest.raises(Malformed, match="not a member"):
        codec.decode(data[:-4] + struct.pack("<i", 2))


@pytest.mark.parametrize(
    ("value", "named"),
    [
        (timed.TimedShort(data=32768), "TimedShort.data: 32768 is not a value of type int16"),
        (timed.TimedUShort(data=-1), "TimedUShort.data: -1 is not a value of type uint16"),
        (timed.TimedOctet(data=256), "TimedOctet.data"),
        (timed.TimedLong(data=1.5), "TimedLong.data: 1.5"),
        (timed.TimedLong(data="1"), "TimedLong.data: '1'"),
        (timed.TimedFloat(data=1e39), "TimedFloat.data: 1e+39 is not a value of type float32"),
        (timed.TimedDouble(data="x"), "TimedDouble.data"),
        (timed.TimedDouble(data=None), "TimedDouble.data: None"),
        (timed.TimedChar(data="ab"), "TimedChar.data"),
        (timed.TimedChar(data="€"), "TimedChar.data"),
        (timed.TimedChar(data=""), "TimedChar.data"),
        (timed.TimedString(data=b"x"), "TimedString.data"),
        (timed.TimedString(data="a\0b"), "TimedString.data"),
        (timed.TimedString(data="\ud800"), "TimedString.data"),
        (timed.TimedLongSeq(data=(1, 2**31)), "TimedLongSeq.data[1]: 2147483648"),
        (timed.TimedLongSeq(data=5), "TimedLongSeq.data: 5"),
        (timed.TimedOctetSeq(data="text"), "TimedOctetSeq.data: 'text'"),
        (timed.TimedOctetSeq(data=(1, 2)), "TimedOctetSeq.data"),
        (timed.TimedStringSeq(data=("a", None)), "TimedStringSeq.data[1]: None"),
        (timed.TimedLong(tm=None), "TimedLong.tm: NoneType has no field sec"),
        (timed.TimedLong(tm=Time(-1, 0)), "TimedLong.tm.sec: -1"),
    ],
)
def test_what_does_not_fit_is_named(value, named):
    with pytest.raises(Malformed) as caught:
        codec_for(type(value)).encode(value)
    assert str(caught.value).startswith(named)


GOOD = codec_for(timed.TimedString).encode(timed.TimedString(data="abc"))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", "no CDR header: no bytes"),
        (b"\0\1", "TimedString"),
        (b"\0\7\0\0" + GOOD[4:], "no CDR header: 00 07 00 00"),
        (b"PK\3\4" + GOOD[4:], "no CDR header"),
        (GOOD[:10], "TimedString"),
        (GOOD[:-1], "do not fit"),
        (GOOD[:12] + b"\xff\xff\xff\xff" + GOOD[16:], "do not fit"),
        (GOOD[:-2] + b"\xff\0", "utf-8"),
        (GOOD[:-1] + b"x", "NUL"),
        (GOOD[:-2] + b"\0\0", "NUL"),
        (GOOD + b"\0\0\0\0", "4 bytes too many"),
        (GOOD + b"\1", "1 bytes too many"),
    ],
)
def test_what_cannot_be_read_is_refused(data, reason):
    with pytest.raises(Malformed, match=reason):
        codec_for(timed.TimedString).decode(data)


def test_padding_up_to_four_bytes_is_accepted():
    for count in range(4):
        assert codec_for(timed.TimedString).decode(GOOD + bytes(count)).data == "abc"


def test_lengths_are_checked_before_memory_is_taken():
    for cls in (
        timed.TimedDoubleSeq,
        timed.TimedStringSeq,
        timed.TimedOctetSeq,
        timed.TimedCharSeq,
    ):
        data = codec_for(cls).encode(cls())[:-4] + b"\xff\xff\xff\xff"
        with pytest.raises(Malformed, match="do not fit"):
            codec_for(cls).decode(data + bytes(100))


def test_a_truth_value_is_0_or_1():
    data = codec_for(timed.TimedBoolean).encode(timed.TimedBoolean())
    with pytest.raises(Malformed, match="truth value: 2"):
        codec_for(timed.TimedBoolean).decode(data[:-1] + b"\2")
    data = codec_for(timed.TimedBooleanSeq).encode(timed.TimedBooleanSeq(data=(True,)))
    with pytest.raises(Malformed, match="truth value: 9"):
        codec_for(timed.TimedBooleanSeq).decode(data[:-1] + b"\x09")


def test_bytes_pass_unchanged():
    assert BYTES.encode(b"any") == BYTES.decode(b"any") == b"any"
    assert codec_for(bytes) is BYTES
    with pytest.raises(Malformed):
        BYTES.encode("text")


def test_a_constructor_that_checks_is_run():
    @dataclass(frozen=True, slots=True)
    class Even:
        number: Long

        def __post_init__(self):
            if self.number % 2:
                raise ValueError("odd number")

    data = codec_for(Even).encode(Even(2))
    assert codec_for(Even).decode(data) == Even(2)
    with pytest.raises(Malformed, match="odd number"):
        codec_for(Even).decode(data[:-4] + b"\1\0\0\0")


@dataclass
class Chain:
    rest: Chain


@dataclass
class Perhaps:
    number: Optional[int]  # noqa: UP045


@dataclass
class Late:
    number: int = field(init=False, default=0)


@pytest.mark.parametrize(
    ("cls", "reason"),
    [
        (Chain, "contains itself"),
        (Perhaps, "Perhaps.number cannot be carried: it is optional"),
        (Late, "Late needs fields"),
        (make_dataclass("Nothing", []), "needs fields"),
        (make_dataclass("Odd", [("x", dict)]), "Odd.x cannot be carried"),
        (make_dataclass("Bare", [("x", list)]), "Bare.x cannot be carried"),
        (int, "int is not a dataclass"),
    ],
)
def test_types_that_cannot_be_carried(cls, reason):
    with pytest.raises(Malformed, match=reason):
        codec_for(cls)


def test_annotations_of_pycdr2_are_understood():
    cls = make_dataclass(
        "Borrowed", [("x", pycdr2.types.uint32), ("y", Annotated[float, "other", "float32"])]
    )
    assert codec_for(cls).encode(cls(1, 0.5))[4:] == struct.pack("<If", 1, 0.5)
    assert ULong is not Float


@dataclass(frozen=True, slots=True)
class Named:
    number: float
    names: list[str]


@dataclass(frozen=True, slots=True)
class Rack:
    is_on: bool
    each: tuple[Named, Named, Named, Named]
    last: Annotated[int, "int8"]


@dataclass(frozen=True, slots=True)
class Hall:
    racks: tuple[Rack, Rack, Rack, Rack]
    doors: tuple[tuple[Rack, Rack, Rack, Rack], ...]


@pytest.mark.parametrize("is_big_endian", [False, True])
def test_arrays_of_what_differs_in_length(is_big_endian: bool) -> None:
    def rack(n: int) -> Rack:
        each = [Named(n / 3, [str(k) * k for k in range(n + m)]) for m in range(4)]
        return Rack(n % 2 == 0, (each[0], each[1], each[2], each[3]), n)

    racks = rack(0), rack(1), rack(2), rack(3)
    hall = Hall(racks, (racks, racks))
    data = encoder_for(Hall, is_big_endian=is_big_endian)(hall)
    assert codec_for(Hall).decode(data) == hall
    with pytest.raises(Malformed):
        codec_for(Hall).decode(data[:-9])
    with pytest.raises(Malformed, match="racks"):
        codec_for(Hall).encode(replace(hall, racks=racks[:3]))


def test_code_of_arrays_in_arrays_does_not_grow_with_their_product() -> None:
    inner: type = Named
    for depth in range(5):
        inner = make_dataclass(f"Depth{depth}", [("each", tuple[(inner,) * 12])], slots=True)
    encoder, decoder = codegen._Encoder("<"), codegen._Decoder("<")
    encoder.compile(layout_of(inner), "parts")
    decoder.compile(layout_of(inner))
    for coder in (encoder, decoder):
        assert len(coder.lines) < 60
