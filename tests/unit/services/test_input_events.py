"""Records of input devices are read as the kernel writes them, in pieces of any length."""

from __future__ import annotations

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.services.input_events import ABS, EVENT, KEY, REL, InputEvent, InputReader, axis_range


def record(kind: int, code: int, value: int) -> bytes:
    return EVENT.pack(1700000000, 250, kind, code, value)


SYN = record(0, 0, 0)


def test_a_record_has_the_size_of_the_kernel() -> None:
    assert EVENT.size == 2 * (8 if os.sysconf("SC_LONG_BIT") == 64 else 4) + 8


def test_reports_end_at_their_mark_and_keep_the_order() -> None:
    data = record(ABS, 0, -32767) + record(KEY, 0x130, 1) + SYN + record(REL, 1, -3) + SYN
    assert InputReader().feed(data) == [
        [InputEvent(ABS, 0, -32767), InputEvent(KEY, 0x130, 1)],
        [InputEvent(REL, 1, -3)],
    ]


@given(st.lists(st.integers(1, 60)))
def test_pieces_of_any_length_make_the_same_reports(cuts: list[int]) -> None:
    records = (record(ABS, each, each * 100) + (SYN if each % 3 else b"") for each in range(9))
    data = b"".join(records)
    reader, found, rest = InputReader(), [], data
    for cut in cuts:
        found += reader.feed(rest[:cut])
        rest = rest[cut:]
    found += reader.feed(rest)
    assert found == InputReader().feed(data)


def test_what_follows_a_loss_is_left_out_up_to_the_end_of_its_report() -> None:
    reader = InputReader()
    lost = record(ABS, 0, 1) + record(0, 3, 0) + record(ABS, 0, 2) + SYN
    assert reader.feed(lost + record(ABS, 0, 3) + SYN) == [[InputEvent(ABS, 0, 3)]]
    assert reader.lost == 1


def test_rubbish_is_refused() -> None:
    with pytest.raises(ValueError, match="no input events"):
        InputReader().feed(b"rubbish of a device that is none" * 3)


def test_a_report_that_never_ends_is_refused() -> None:
    with pytest.raises(ValueError, match="no input events"):
        InputReader().feed(record(ABS, 0, 1) * 5000)


def test_names() -> None:
    assert [InputEvent(*each).name for each in ((ABS, 17, 0), (KEY, 0x130, 0), (KEY, 720, 0))] == [
        "hat_y", "south", "button_720",
    ]  # fmt: skip


def test_a_pipe_tells_no_range() -> None:
    ends = os.pipe()
    assert axis_range(ends[0], 0) is None
    for end in ends:
        os.close(end)
