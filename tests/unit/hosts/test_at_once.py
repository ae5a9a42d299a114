"""Work at several hosts at the same time: outcomes, interruption, questions, progress."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from rtkit.errors import RtkitError, Unreachable
from rtkit.hosts import ssh_login
from rtkit.hosts.at_once import at_once
from rtkit.hosts.host import Host
from rtkit.hosts.progress import HostStep, by_lines

HOSTS = [Host("a", "x"), Host("b", "x")]


def test_each_outcome_comes_as_soon_as_it_is_there() -> None:
    over = threading.Event()

    def work(host: Host) -> str:
        if host.name == "a":
            assert over.wait(10.0)
            raise Unreachable("a: away")
        return host.name

    outcomes = at_once(HOSTS, work)
    assert next(outcomes) == (HOSTS[1], "b")
    over.set()
    host, error = next(outcomes)
    assert (host, isinstance(error, RtkitError)) == (HOSTS[0], True)
    assert list(outcomes) == []


def test_who_interrupts_waits_for_no_host(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(_prompt: str) -> str:
        raise KeyboardInterrupt

    monkeypatch.setattr(ssh_login, "ask", interrupted)
    with pytest.raises(KeyboardInterrupt):
        list(at_once(HOSTS, lambda _host: ssh_login._asker("?")))  # type: ignore[misc]


def test_a_question_is_asked_by_the_thread_of_the_caller(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, threading.Thread]] = []

    def answer(prompt: str) -> str:
        asked.append((prompt, threading.current_thread()))
        return prompt.upper()

    monkeypatch.setattr(ssh_login, "ask", answer)
    found = dict(at_once(HOSTS, lambda host: ssh_login._asker(host.name)))  # type: ignore[misc]
    assert {*found.values()} == {"A", "B"}
    assert {thread for _, thread in asked} == {threading.current_thread()}
    assert ssh_login._asker is None


def test_a_fault_of_the_work_itself_is_no_outcome() -> None:
    def work(_host: Host) -> Any:
        raise ValueError("a fault")

    with pytest.raises(ValueError, match="a fault"):
        list(at_once(HOSTS[:1], work))


def test_progress_by_lines_tells_each_step_once_and_counts_by_quarters() -> None:
    lines: list[str] = []
    show = by_lines(lines.append)
    for name in ("a", "b"):
        show(name, HostStep("checking"))
        show(name, HostStep("checking"))
    for done in range(9):
        show("a", HostStep("sending", done * 1_000_000, 8_000_000, "MB"))
    show("b", HostStep("installing", 1, 24, "wheels"))
    sent = [f"a: sending {done}.0 of 8.0 MB" for done in (0, 2, 4, 6, 8)]
    assert lines == ["a: checking", "b: checking", *sent, "b: installing 1 of 24 wheels"]
