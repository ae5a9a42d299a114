"""Signals that come while something is written."""

from __future__ import annotations

import signal
from collections.abc import Iterator

import pytest

from rtkit.cli.shared.signals import SteadyWork


@pytest.fixture
def work() -> Iterator[SteadyWork]:
    before = signal.getsignal(signal.SIGINT)
    made = SteadyWork(signal.SIGINT, signal.SIGUSR1)
    yield made
    made.close()
    assert signal.getsignal(signal.SIGINT) is before


def write(work: SteadyWork, done: list[str]) -> None:
    with work:
        signal.raise_signal(signal.SIGINT)
        done.append("all")


def test_a_signal_takes_effect_at_the_end_of_a_piece(work: SteadyWork) -> None:
    done: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        write(work, done)
    assert done == ["all"]


def test_between_pieces_it_takes_effect_at_once(work: SteadyWork) -> None:
    with work:
        pass
    with pytest.raises(KeyboardInterrupt):
        signal.raise_signal(signal.SIGINT)


def test_a_signal_without_handler_is_left_alone(work: SteadyWork) -> None:
    assert signal.getsignal(signal.SIGUSR1) is signal.SIG_DFL


def test_a_handler_of_since_then_stays(work: SteadyWork) -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    work.close()
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    signal.signal(signal.SIGINT, before)
    work.close()
