"""Addressed lines: each device takes what is meant for it, and nothing else, whatever comes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.property.addressed import (
    ALL,
    AddressedReplies,
    AddressedRequests,
    addressed,
    addressed_reply,
    read_addresses,
)
from rtkit.property.checked import frame
from rtkit.property.line import LineRequest, write_answer, write_request
from rtkit.property.messages import Answer

WORDS = st.sampled_from(["1", "11", "7", "base", "a_b"])
PAYLOADS = st.text() | st.binary()


def _encoded(payload: str | bytes) -> bytes:
    return payload.encode("utf-8", "replace") if isinstance(payload, str) else payload


@given(WORDS, WORDS, PAYLOADS)
def test_a_request_reaches_its_device_and_no_other(one: str, other: str, given: str) -> None:
    line = frame(addressed(write_request("any", _encoded(given), "x1"), one))
    for each in (one, other):
        requests = AddressedRequests(each)
        requests.feed(b"\n" + line)
        asked = requests.next()
        if each != one:
            assert asked is None
            assert not requests.has_checks
            continue
        assert asked == LineRequest("x1", "any", _encoded(given))
        assert requests.has_checks
        assert not requests.is_for_all


@given(WORDS, WORDS, PAYLOADS)
def test_a_reply_is_taken_as_that_of_its_device_alone(one: str, other: str, given: str) -> None:
    reply = write_answer(Answer(_encoded(given)), "x1")
    line = frame(addressed_reply(reply, one))
    for each in (one, other):
        replies = AddressedReplies(each, has_checks=True)
        replies.feed(frame(addressed(b"GET any\n", each)) + line)  # with an echo of the question
        told = replies.next()
        if each != one:
            assert told is None
            continue
        assert isinstance(told, tuple)
        value = told[1].payload
        assert told[0] == "x1"
        assert _encoded(value) == _encoded(given)


@given(WORDS, st.binary(max_size=60))
def test_what_devices_say_is_no_request(address: str, rubbish: bytes) -> None:
    requests = AddressedRequests(address)
    for line in (b"= 0.25\n", b"#1 = SET x 1\n", b"! unknown no\n", b"= " + rubbish + b"\n"):
        requests.feed(frame(addressed_reply(line, address)))
        assert requests.next() is None


@given(st.binary(max_size=40), st.integers(0, 10_000), st.integers(1, 255))
def test_what_is_damaged_is_answered_by_nobody(value: bytes, place: int, turned: int) -> None:
    line = bytearray(frame(addressed(write_request("any", value), "7")))
    line[place % (len(line) - 1)] ^= turned
    for each in ("7", "8", "base"):
        requests = AddressedRequests(each)
        requests.feed(frame(addressed(b"GET any\n", each)))
        assert requests.next() == LineRequest("", "any", None)
        requests.feed(bytes(line) + b"\n")
        asked = requests.next()
        # A digit of the check in the other case is no damage.
        assert asked is None or (each == "7" and asked.payload == value)


@given(st.binary(max_size=300))
def test_rubbish_is_lived_through(rubbish: bytes) -> None:
    requests, replies = AddressedRequests("7"), AddressedReplies("7", has_checks=True)
    for reader in (requests, replies):
        reader.feed(rubbish + b"\n")
        while reader.next() is not None:
            pass
    requests.feed(b"\n" + frame(addressed(b"GET any\n", "7")))
    assert requests.next() == LineRequest("", "any", None)
    replies.feed(b"\n" + frame(addressed_reply(b"= 5\n", "7")))
    assert replies.next() == ("", Answer("5"))


def test_all_are_meant_at_once() -> None:
    requests = AddressedRequests("7")
    for line, is_for_all in ((addressed(b"SET a 1\n", ALL), True), (b"@7 GET a\n", False)):
        requests.feed(line)
        asked = requests.next()
        assert asked is not None
        assert asked.target == "a"
        assert requests.is_for_all is is_for_all


def test_checks_begin_and_end_as_the_asker_wishes() -> None:
    requests = AddressedRequests("7")
    said = []
    for line in (
        b"@7 GET a\n", b"@8 GET a ~0000\n", frame(b"@7 GET a\n"), b"@7 GET a\n",
        b"@7 GET properties\n", b"@7 GET a\n", b"GET a\n",
    ):  # fmt: skip
        requests.feed(line)
        said.append((requests.next() is not None, requests.has_checks))
    assert said == [
        (True, False), (False, False), (True, True), (False, True), (True, False), (True, False),
        (False, False),
    ]  # fmt: skip
    strict = AddressedRequests("7", wanted=True)
    strict.feed(b"@7 GET a\n@7 GET properties\n" + frame(b"@7 GET b\n"))
    assert strict.next() == LineRequest("", "b", None)


def test_an_endless_line_and_bytes_without_a_check_are_refused() -> None:
    requests = AddressedRequests("7")
    requests.feed(b"x" * (3 << 20) + b"\n@7 GET a\n")
    assert requests.next() == LineRequest("", "a", None)
    requests.feed(b"@7 SET a {5}\nhello\n@7 GET a\n")
    refused = requests.next()
    assert refused is not None
    assert refused.error is not None
    assert requests.next() == LineRequest("", "a", None)


@pytest.mark.parametrize(
    ("text", "found"),
    [("7", ["7"]), ("1-3,base", ["1", "2", "3", "base"]), ("5-5", ["5"]), ("all", ["all"])],
)
def test_addresses(text: str, found: list[str]) -> None:
    assert list(read_addresses(text)) == found


@pytest.mark.parametrize(
    "text",
    ["", "7,", "3-1", "1-3,2", "a.b", "é", "all,7", "silent", "properties", "0-1000", "x" * 13],
)
def test_what_is_no_address(text: str) -> None:
    with pytest.raises(ValueError, match="address"):
        read_addresses(text)
