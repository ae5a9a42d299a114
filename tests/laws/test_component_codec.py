"""Laws of the codec: what was written is read, what is read is bounded, nothing crashes."""

from __future__ import annotations

import struct
from dataclasses import dataclass, make_dataclass

import pycdr2
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.component import (
    Char,
    Double,
    Float,
    Long,
    Octet,
    Short,
    Time,
    ULong,
    UShort,
    geometry,
    timed,
)
from rtkit.component.values.codec import codec_for
from rtkit.errors import Malformed

T = pycdr2.types
TEXT = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12)
ASCII = st.characters(min_codepoint=0, max_codepoint=127)

# Annotation here, annotation of pycdr2, values.
SCALARS = [
    (bool, bool, st.booleans()),
    (Char, T.char, ASCII),
    (Octet, T.uint8, st.integers(0, 2**8 - 1)),
    (Short, T.int16, st.integers(-(2**15), 2**15 - 1)),
    (UShort, T.uint16, st.integers(0, 2**16 - 1)),
    (Long, T.int32, st.integers(-(2**31), 2**31 - 1)),
    (ULong, T.uint32, st.integers(0, 2**32 - 1)),
    (int, T.int64, st.integers(-(2**63), 2**63 - 1)),
    (Float, T.float32, st.floats(width=32, allow_nan=False)),
    (Double, T.float64, st.floats(allow_nan=False)),
    (str, str, TEXT),
]


def sequence_of(kind):
    own, foreign, values = kind
    return list[own], T.sequence[foreign], st.lists(values, max_size=4)


KINDS = st.recursive(st.sampled_from(SCALARS), lambda inner: inner.map(sequence_of), max_leaves=3)
_cache = {}


@st.composite
def records(draw):
    kinds = draw(st.lists(KINDS, min_size=1, max_size=6))
    key = tuple(str(own) for own, _, _ in kinds)
    if key not in _cache:
        names = [f"f{index}" for index in range(len(kinds))]
        _cache[key] = (
            make_dataclass("Own", zip(names, [k[0] for k in kinds], strict=True)),
            make_dataclass(
                "Foreign", zip(names, [k[1] for k in kinds], strict=True), bases=(pycdr2.IdlStruct,)
            ),
        )
    own, foreign = _cache[key]
    values = [draw(values) for _, _, values in kinds]
    return own(*values), foreign(*values)


@given(records())
def test_every_record_is_written_as_by_pycdr2_and_read_back(pair):
    own, foreign = pair
    codec = codec_for(type(own))
    data = codec.encode(own)
    assert data == foreign.serialize()
    assert codec.decode(data) == own


@dataclass(frozen=True, slots=True)
class Deep:
    words: tuple[str, ...]
    poses: tuple[geometry.TimedPose2D, ...]
    grid: list[list[Short]]
    raw: bytes
    flags: tuple[bool, ...]


def outcome(action, argument):
    """What `action` returns, or the error it is allowed to raise."""
    try:
        return action(argument)
    except Malformed as error:
        return error


DECODED = [
    timed.TimedLong,
    timed.TimedBoolean,
    timed.TimedString,
    timed.TimedWString,
    timed.TimedStringSeq,
    timed.TimedBooleanSeq,
    timed.TimedDoubleSeq,
    timed.TimedOctetSeq,
    timed.TimedCharSeq,
    geometry.TimedPose3D,
    Deep,
]


@settings(max_examples=400)
@given(cls=st.sampled_from(DECODED), data=st.binary(max_size=120), is_headed=st.booleans())
def test_any_bytes_give_a_value_or_malformed(cls, data, is_headed):
    codec = codec_for(cls)
    if is_headed:
        data = b"\0\1\0\0" + data
    value = outcome(codec.decode, data)
    if isinstance(value, Malformed):
        assert cls.__name__ in str(value)
    else:
        assert isinstance(value, cls)
        again = codec.encode(value)
        assert codec.encode(codec.decode(again)) == again


@settings(max_examples=200)
@given(
    index=st.integers(0, 200), byte=st.integers(0, 255), cut=st.integers(0, 200), long=st.booleans()
)
def test_damaged_bytes_give_a_value_or_malformed(index, byte, cut, long):
    value = Deep(("a", "bc"), (geometry.TimedPose2D(),) * 2, [[1], [2, 3]], b"xyz", (True,))
    data = bytearray(codec_for(Deep).encode(value))
    if long:
        struct.pack_into("<I", data, min(index, len(data) - 4), 2**32 - 1 - byte)
    else:
        data[index % len(data)] = byte
    read = outcome(codec_for(Deep).decode, bytes(data[: len(data) - cut % len(data)]))
    assert isinstance(read, (Deep, Malformed))


WRONG = st.one_of(
    st.none(),
    st.integers(),
    st.floats(),
    st.text(max_size=3),
    st.binary(max_size=3),
    st.lists(st.integers(), max_size=2),
    st.just(object()),
)


@given(cls=st.sampled_from(DECODED[:-2]), tm=st.just(Time()) | WRONG, data=WRONG)
def test_any_value_is_written_or_malformed(cls, tm, data):
    written = outcome(codec_for(cls).encode, cls(tm, data))
    if isinstance(written, Malformed):
        assert cls.__name__ in str(written)
    else:
        assert isinstance(codec_for(cls).decode(written), cls)
