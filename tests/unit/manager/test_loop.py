"""Loop of a manager: what it waits for."""

from __future__ import annotations

import os
import selectors
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from rtkit.manager.fault_guard import select_but

WAIT_S = 10.0
Pipe = tuple[int, int]


@pytest.fixture
def pipes() -> Iterator[tuple[Pipe, Pipe]]:
    with ExitStack() as stack:
        made = os.pipe(), os.pipe()
        for descriptor in (*made[0], *made[1]):
            stack.callback(os.close, descriptor)
        yield made


def test_a_descriptor_that_failed_holds_up_no_other(pipes: tuple[Pipe, Pipe]) -> None:
    """It is ready all the time; the loop sleeps until another one is, and wakes at once then."""
    (failed, write_failed), (good, write_good) = pipes
    os.write(write_failed, b"x")
    with selectors.DefaultSelector() as selector:
        for descriptor in (failed, good):
            selector.register(descriptor, selectors.EVENT_READ)
        turns, began = [], time.monotonic()
        threading.Timer(0.05, os.write, (write_good, b"x")).start()
        while not turns or not turns[-1]:
            turns.append(select_but(selector, {failed}.__contains__, WAIT_S))
        assert [key.fd for key, _ in turns[-1]] == [good]
        assert len(turns) == 2, "it did not go round while nothing else was ready"
        assert time.monotonic() - began < WAIT_S


def test_a_descriptor_that_failed_is_tried_again_in_time(pipes: tuple[Pipe, Pipe]) -> None:
    (failed, write_failed), _ = pipes
    os.write(write_failed, b"x")
    with selectors.DefaultSelector() as selector:
        selector.register(failed, selectors.EVENT_READ)
        assert select_but(selector, {failed}.__contains__, 0.01) == []
        assert [key.fd for key, _ in select_but(selector, set[int]().__contains__, 0.01)] == [
            failed
        ]
