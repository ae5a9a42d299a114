"""Lines with checks: whatever is sent arrives, what is damaged is known to be."""

from __future__ import annotations

import binascii

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.property.checked import QUIET_S, CheckedReplies, CheckedRequests, frame, unframe
from rtkit.property.limits import LIMITS
from rtkit.property.line import LONGEST_LINE, LineRequest, write_answer, write_request
from rtkit.property.messages import Answer

PAYLOADS = st.text() | st.binary()


def test_the_check_is_the_one_that_everybody_has() -> None:
    assert binascii.crc_hqx(b"123456789", 0xFFFF) == 0x29B1
    assert frame(b"123456789\n") == b"123456789 ~29B1\n"
    assert unframe(b"123456789 ~29b1") == b"123456789"


@given(st.binary())
def test_a_message_is_one_line_and_comes_back(message: bytes) -> None:
    line = frame(message + b"\n")
    assert line.count(b"\n") == 1
    assert not set(line[:-1]) & set(b"\r\n\x11\x13")
    assert unframe(line[:-1]) == message


@given(st.binary(max_size=100), st.integers(0, 10_000), st.integers(1, 255))
def test_a_byte_that_is_turned_is_seen(message: bytes, place: int, turned: int) -> None:
    line = bytearray(frame(message)[:-1])
    line[place % len(line)] ^= turned
    read = unframe(bytes(line))
    assert read is None or read == unframe(frame(message)[:-1]), "but for a digit's case"


@given(PAYLOADS, st.lists(st.integers(1, 50)))
def test_requests_and_replies_in_pieces(payload: str | bytes, cuts: list[int]) -> None:
    requests, replies = CheckedRequests(), CheckedReplies()
    if isinstance(payload, str):
        payload = payload.encode("utf-8", "replace")
    sent = frame(write_request("any", payload, "x1")), frame(write_answer(Answer(payload), "x1"))
    for reader, data in zip((requests, replies), sent, strict=True):
        rest = b"\n" + data
        for cut in cuts:
            reader.feed(rest[:cut])
            rest = rest[cut:]
        reader.feed(rest)
    asked = requests.next()
    assert isinstance(asked, LineRequest)
    assert (asked.id, asked.target, asked.payload) == ("x1", "any", payload)
    while isinstance(told := replies.next(), bytes):
        assert told == b""
    assert isinstance(told, tuple)
    value = told[1].payload
    assert (value.encode() if isinstance(value, str) else value) == payload


@given(st.binary(max_size=200))
def test_what_is_in_a_value_is_never_a_request(inside: bytes) -> None:
    requests = CheckedRequests()
    payload = b"\nSET motor 1\n" + inside
    line = frame(write_request("any", payload))
    requests.feed(frame(b"GET any\n"))
    requests.feed(line[5:])
    assert requests.next() == LineRequest("", "any", None)
    refused = requests.next()
    assert refused is not None
    assert refused.error is not None
    assert refused.error.code == "checksum"
    assert requests.next() is None


@pytest.mark.parametrize("size", [LIMITS.text, LIMITS.text + 2000])
def test_bytes_of_any_kind_fit_up_to_the_limit(size: int) -> None:
    """Those that are stuffed are twice as long on the line."""
    requests = CheckedRequests()
    requests.feed(frame(write_request("any", b"\n" * size, "x1")))
    asked = requests.next()
    assert asked is not None
    if size == LIMITS.text:
        assert (asked.id, asked.target, asked.payload) == ("x1", "any", b"\n" * size)
    else:
        assert asked.error is not None
        assert asked.error.code == "too-large"
    assert not asked.is_last


@pytest.mark.parametrize("wanted", [None, False])
def test_a_line_without_a_check_has_the_limit_of_lines(wanted: bool | None) -> None:
    requests = CheckedRequests(wanted)
    requests.feed(b"SET any " + b"x" * LONGEST_LINE + b"\nGET any\n")
    refused = requests.next()
    assert refused is not None
    assert refused.error is not None
    assert (refused.error.code, refused.is_last) == ("too-large", False)
    assert requests.next() == LineRequest("", "any", None)


def test_a_conversation_begins_anew_without_checks() -> None:
    requests = CheckedRequests()
    codes = []
    for line in (b"GET a\n", frame(b"GET a\n"), b"GET a\n", b"GET properties\n", b"GET a\n"):
        requests.feed(line)
        asked = requests.next()
        assert asked is not None
        codes.append((asked.error.code if asked.error else "", requests.has_checks))
    assert codes == [("", False), ("", True), ("checksum", True), ("", False), ("", False)]


def test_bytes_that_nobody_can_place_are_not_taken_for_requests() -> None:
    now = [100.0]
    requests = CheckedRequests(clock=lambda: now[0])
    requests.feed(b"SET any {99999999999}\n")
    refused = requests.next()
    assert refused is not None
    assert refused.error is not None
    assert not refused.is_last
    for _ in range(10):
        now[0] += QUIET_S / 2
        requests.feed(b"SET motor 1\n")
        assert requests.next() is None
    now[0] += QUIET_S * 1.1
    requests.feed(b"GET motor\n")
    assert requests.next() == LineRequest("", "motor", None)
