"""Signals that come while something is written."""

from __future__ import annotations

import signal

import pytest

from rtkit.cli.shared.signals import held_back


def test_a_signal_takes_effect_at_the_end_of_the_body() -> None:
    done: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        write(done)
    assert done == ["all"]


def write(done: list[str]) -> None:
    with held_back(signal.SIGINT, signal.SIGTERM):
        signal.raise_signal(signal.SIGINT)
        done.append("all")


def test_handlers_are_as_before() -> None:
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    with held_back(signal.SIGINT, signal.SIGTERM):
        assert signal.getsignal(signal.SIGINT) is not before[0]
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == before
