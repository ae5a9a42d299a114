"""What is repeated with its id is answered from memory; what failed in passing is done again."""

from __future__ import annotations

import pytest

from rtkit.property.idempotency import IdempotencyCache, is_shared, marked, shared
from rtkit.property.messages import Answer


def test_a_repetition_has_the_answer_of_the_first() -> None:
    once = IdempotencyCache()
    heard: list[Answer] = []
    answer = once.first("a", heard.append)
    assert answer is not None
    assert once.first("a", heard.append) is None
    answer(Answer("1"))
    assert once.first("a", heard.append) is None
    assert heard == [Answer("1")] * 3


@pytest.mark.parametrize("code", ["no-service", "timeout", "busy", "checksum"])
def test_what_failed_in_passing_is_done_again(code: str) -> None:
    once = IdempotencyCache()
    heard: list[Answer] = []
    for _ in range(2):
        answer = once.first("a", heard.append)
        assert answer is not None
        answer(Answer("not now", code))
    assert [each.error for each in heard] == [code] * 2


def test_large_answers_are_forgotten_first_of_all_that_are_old() -> None:
    once = IdempotencyCache()
    for number in range(6):
        answer = once.first(number, lambda reply: None)
        assert answer is not None
        answer(Answer("x" * (1 << 20)))
    assert once.first(5, lambda reply: None) is None
    assert once.first(0, lambda reply: None) is not None


def test_ids_of_proxies_are_the_same_everywhere() -> None:
    assert is_shared(shared("p1", "2", "a"))
    assert shared("p1", "2", "a") == shared("p1", "2", "a")
    assert shared("p1", "2", "a") != shared("p1", "2a")
    assert not any(map(is_shared, (None, "", "~1", "a", f"{shared('a')}0")))


def test_large_payloads_are_told_apart_in_little_room() -> None:
    assert marked("x" * 1000) != marked("x" * 1001)
    assert marked("x" * 1000) != marked(b"x" * 1000)
    assert len(repr(marked("x" * 1000))) < 100
