"""Whatever a device or a sender of pictures sends is read, or refused in the stated way."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import rtkit
from rtkit.services.gps import Gps
from rtkit.services.images import MOST_PIXELS, decode, encode, size_of
from rtkit.services.input_events import EVENT, InputReader
from rtkit.services.joystick import Joystick, Pointer

_PICTURE = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
_WHOLE = [encode(_PICTURE, "jpeg"), encode(_PICTURE, "png")]
_FIX = b"$GPGGA,123519,6503.6000,N,02528.0000,E,1,08,0.9,15.4,M,46.9,M,,*7E\r\n"
pieces = st.lists(st.binary(max_size=80), max_size=8)


@settings(max_examples=200, deadline=None)
@given(st.sampled_from(_WHOLE), st.integers(0, 2000), st.binary(max_size=8), st.integers(0, 2000))
def test_a_damaged_picture_is_read_or_refused(
    whole: bytes, at: int, other: bytes, cut: int
) -> None:
    data = (whole[:at] + other + whole[at + len(other) :])[: len(whole) - cut // 4]
    shown, code = None, ""
    try:
        shown = decode(data)
    except rtkit.PropertyError as error:
        code = error.code
    if shown is None:
        assert code in ("bad-value", "too-large")
    else:
        width, height = size_of(data)
        assert shown.shape == (height, width, 3)
        assert width * height <= MOST_PIXELS


@given(pieces)
def test_a_gps_takes_any_bytes_and_then_a_fix(data: list[bytes]) -> None:
    gps = Gps("/nowhere")
    for each in data:
        gps._take(each)
    gps._take(b"\r\n" + _FIX)
    assert gps.position[2:] == (15.4,)
    assert gps.status == "ready"


kinds, codes = st.integers(0, 0x1F), st.integers(0, 0x2FF)
values = st.integers(-(1 << 31), (1 << 31) - 1)


@given(st.lists(st.tuples(kinds, codes, values), max_size=40))
def test_any_events_are_taken_and_stay_within_their_range(
    events: list[tuple[int, int, int]],
) -> None:
    data = b"".join(EVENT.pack(0, 0, *each) for each in (*events, (0, 0, 0)))
    stick, pointer = Joystick("/nowhere"), Pointer("/nowhere")
    stick._take(data)
    pointer._take(data)
    assert all(-1 <= each <= 1 for each in stick.axes.values())
    assert all(0 <= part <= 1 for place in pointer.data for part in place)
    assert len(stick.get_markers()) == 1
    assert len(pointer.get_markers()) == len(pointer.data)


@given(pieces)
def test_any_bytes_are_events_or_refused(data: list[bytes]) -> None:
    reader, why = InputReader(), ""
    try:
        for each in data:
            reader.feed(each)
    except ValueError as error:
        why = str(error)
    assert why in ("", "these are no input events")
