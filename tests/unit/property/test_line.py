"""The line protocol as bytes: however they come, half, endless or rubbish, memory is bounded."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rtkit.property.codes import PropertyError
from rtkit.property.line import (
    LineRequest,
    Replies,
    Requests,
    write_answer,
    write_attributes,
    write_event,
    write_request,
)
from rtkit.property.messages import Answer, PropertyEvent
from rtkit.property.reply_order import InOrder


def asked(data: bytes, longest: int = 1000, piece: int = 1 << 20) -> list[LineRequest]:
    requests = Requests(longest)
    found = []
    for start in range(0, len(data), piece):
        requests.feed(data[start : start + piece])
        while (request := requests.next()) is not None:
            found.append(request)
            if request.is_last:
                return found
    return found


GOOD = b"GET a.b?x=1\n#7 SET a (1 2)\r\nSET b {5}\na\nb\0c\nSET c \nSET d\n#x GET e\n"


@pytest.mark.parametrize("piece", [1, 2, 3, 7, 1000])
def test_requests_come_whole_whatever_the_pieces(piece: int) -> None:
    assert [each[:3] for each in asked(GOOD, piece=piece)] == [
        ("", "a.b?x=1", None),
        ("7", "a", "(1 2)"),
        ("", "b", b"a\nb\0c"),
        ("", "c", ""),
        ("", "d", ""),
        ("x", "e", None),
    ]


@pytest.mark.parametrize(
    ("data", "code", "goes_on"),
    [
        (b"HELLO\n", "syntax", True),
        (b"\n", "syntax", True),
        (b"get a\n", "syntax", True),
        (b"# GET a\n", "syntax", True),
        (b"#" + b"i" * 65 + b" GET a\n", "syntax", True),
        (b"GET \xff\xfe\n", "syntax", True),
        (b"\x16\x03\x01\x02\x00\x01\n", "syntax", True),
        (b"x" * 5000 + b"\n", "too-large", True),
        (b"SET a {99999}\n", "too-large", False),
        (b"SET a {3}\nabcd\n", "syntax", False),
    ],
)
def test_rubbish_is_answered_and_what_follows_is_read(
    data: bytes, code: str, goes_on: bool
) -> None:
    for piece in (1, 1 << 20):
        found = asked(data + b"GET ok\n", piece=piece)
        assert found[0].error is not None
        assert found[0].error.code == code
        assert len(found) == (2 if goes_on else 1)
        assert not goes_on or found[1].target == "ok"


def test_an_endless_line_is_told_once_and_costs_nothing() -> None:
    requests = Requests(1000)
    told = 0
    for _ in range(1000):
        requests.feed(b"x" * 1000)
        told += requests.next() is not None
        assert len(requests._splitter._buffer) <= 2000
    requests.feed(b"\nGET a\n")
    assert (told, requests.next()) == (1, LineRequest("", "a", None))


def test_half_a_line_is_known_as_such() -> None:
    requests = Requests()
    for data, waits in ((b"GET", True), (b" a\n", False), (b"SET a {5}\n12", True)):
        requests.feed(data)
        while requests.next() is not None:
            pass
        assert requests.waits is waits


PAYLOAD = st.text(st.characters(exclude_categories=["Cs"]), max_size=20) | st.binary(max_size=20)


@given(PAYLOAD, st.sampled_from(["", "7"]), st.integers(1, 9))
def test_replies_come_back(payload: str | bytes, id: str, piece: int) -> None:
    data = write_answer(Answer(payload), id)
    replies = Replies()
    found = []
    for start in range(0, len(data), piece):
        replies.feed(data[start : start + piece])
        while (told := replies.next()) is not None:
            found.append(told)
    ((got_id, answer),) = found
    raw = payload.encode() if isinstance(payload, str) else payload
    got = answer.payload.encode() if isinstance(answer.payload, str) else answer.payload
    assert (got_id, got, answer.error) == (id, raw, "")


@given(PAYLOAD)
def test_sets_come_back(payload: str | bytes) -> None:
    (request,) = asked(write_request("a", payload, "1"), 1 << 20)
    raw = payload.encode() if isinstance(payload, str) else payload
    got = request.payload.encode() if isinstance(request.payload, str) else request.payload
    assert (request.id, request.target, got) == ("1", "a", raw)


@given(st.builds(PropertyEvent, st.just("a.b"), st.just("(1 2)"), st.floats(0, 1e10),
                 st.integers(0, 10**9), st.sampled_from(["good", "bad"]), st.integers(0, 9),
                 st.sampled_from(["", "unknown"])))  # fmt: skip
def test_events_come_back(event: PropertyEvent) -> None:
    replies = Replies()
    replies.feed(write_event(event))
    assert replies.next() == event
    assert "\n" not in write_attributes(event)


def test_errors_are_code_and_text() -> None:
    replies = Replies()
    replies.feed(write_answer(Answer("no such property: x", "unknown"), "3"))
    assert replies.next() == ("3", Answer("no such property: x", "unknown"))


@pytest.mark.parametrize("data", [b"HTTP/1.1 200 OK\n", b"* a;rev=x 3\n"])
def test_who_speaks_another_protocol_is_told(data: bytes) -> None:
    replies = Replies()
    replies.feed(data)
    with pytest.raises(PropertyError, match="expected"):
        replies.next()


def test_replies_without_id_keep_their_order() -> None:
    sent: list[bytes] = []
    order = InOrder(sent.append)
    first, second = order.expect(has_id=False), order.expect(has_id=False)
    third = order.expect(has_id=True)
    third(b"3")
    second(b"2")
    assert (sent, order.waiting) == ([b"3"], 1)
    first(b"1")
    assert (sent, order.waiting) == ([b"3", b"1", b"2"], 0)
