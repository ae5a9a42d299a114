"""Calls of services between two real zenoh sessions."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from rtkit.errors import Unreachable
from rtkit.link.local.streams import LocalStreams

KEY = "rtd/test/host/calls/0"


def test_each_request_gets_its_own_reply(streams: tuple[LocalStreams, LocalStreams]) -> None:
    provider, consumer = streams
    endpoint, _ = provider.serve(KEY, lambda request: b"re: " + request)
    caller = consumer.caller(endpoint, KEY, 5.0)
    requests = [b"", b"\0", b"x" * 1_000_000]
    assert [caller.call(each, 5.0) for each in requests] == [b"re: " + r for r in requests]
    with ThreadPoolExecutor(4) as pool:
        several = [b"%d" % number for number in range(200)]
        replies = list(pool.map(lambda each: caller.call(each, 5.0), several))
    assert replies == [b"re: " + each for each in several]


def test_a_provider_that_never_comes_back_is_waited_for_no_longer_than_told(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    provider, consumer = streams
    release = threading.Event()

    def stuck(request: bytes) -> bytes:
        release.wait(30.0)
        return b"late"

    endpoint, served = provider.serve(KEY, stuck)
    caller = consumer.caller(endpoint, KEY, 5.0)
    with pytest.raises(Unreachable, match=r"no answer within 0.1 s"):
        caller.call(b"", 0.1)
    served.close()
    with pytest.raises(Unreachable, match="the provider is gone"):
        caller.call(b"", 5.0)
    assert not release.is_set(), "closing waited for the provider"
    release.set()


def test_nobody_answers_at_once(streams: tuple[LocalStreams, LocalStreams]) -> None:
    provider, consumer = streams
    endpoint, served = provider.serve(KEY, lambda request: b"")
    caller = consumer.caller(endpoint, KEY, 5.0)
    assert caller.call(b"", 5.0) == b""
    served.close()
    with pytest.raises(Unreachable, match="gone"):
        caller.call(b"", 60.0)


def test_a_caller_that_is_closed_calls_no_more(streams: tuple[LocalStreams, LocalStreams]) -> None:
    provider, consumer = streams
    endpoint, _ = provider.serve(KEY, lambda request: b"")
    caller = consumer.caller(endpoint, KEY, 5.0)
    caller.close()
    with pytest.raises(Unreachable, match="closed"):
        caller.call(b"", 5.0)


def test_calls_over_one_connector_do_not_wait_for_each_other(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    provider, consumer = streams
    meeting = threading.Barrier(3, timeout=5.0)

    def meet(request: bytes) -> bytes:
        meeting.wait()
        return request

    caller = consumer.caller(provider.serve(KEY, meet)[0], KEY, 5.0)
    requests = [b"a", b"b", b"c"]
    with ThreadPoolExecutor(3) as pool:
        for _ in range(2):
            assert list(pool.map(lambda each: caller.call(each, 5.0), requests)) == requests


def test_a_provider_that_hangs_has_no_further_thread_for_each_call(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    provider, consumer = streams
    asked: list[bytes] = []
    release = threading.Event()

    def stuck(request: bytes) -> bytes:
        asked.append(request)
        release.wait(30.0)
        return request

    caller = consumer.caller(provider.serve(KEY, stuck)[0], KEY, 5.0)
    for request in (b"a", b"b", b"c"):
        with pytest.raises(Unreachable, match="no answer"):
            caller.call(request, 0.05)
    assert asked == [b"a"]
    release.set()
    assert caller.call(b"d", 5.0) == b"d"


def test_calls_of_several_connectors_do_not_wait_for_each_other(
    streams: tuple[LocalStreams, LocalStreams],
) -> None:
    provider, consumer = streams
    meeting = threading.Barrier(2, timeout=5.0)

    def meet(request: bytes) -> bytes:
        meeting.wait()
        return request

    keys = [f"{KEY}/{number}" for number in range(2)]
    callers = [consumer.caller(provider.serve(key, meet)[0], key, 5.0) for key in keys]
    with ThreadPoolExecutor(2) as pool:
        replies = pool.map(lambda caller: caller.call(b"here", 5.0), callers)
        assert list(replies) == [b"here", b"here"]
