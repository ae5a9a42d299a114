"""The page of rtstatus, of a record that has everything."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest

from rtkit.cli.observing.status.page import page


@pytest.fixture(autouse=True)
def _utc(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    yield
    monkeypatch.delenv("TZ")
    time.tzset()


NOW = datetime(2026, 11, 23, 12, 0, 5, tzinfo=UTC)
AT = "2026-11-23T11:58:00.250000000Z"


def entry(message: str, exception: str = "", time: str = AT) -> dict[str, str]:
    known = {"time": time, "level": "INFO", "source": "stdout"}
    return {**known, "message": message, "exception": exception}


def record(**changes: Any) -> dict[str, Any]:
    plain: dict[str, Any] = {
        "path": "/localhost/A.rtc",
        "kind": "component",
        "name": "A",
        "description": "Move.",
        "type": "RTC:me:x:Arm:1.0",
        "state": "Active",
        "why": "",
        "since": AT,
        "active_set": "default",
        "process": {"name": "a", "pid": 7, "state": "up", "reason": ""},
        "manager": {"name": "m", "pid": 3, "is_running": True},
        "contexts": [],
        "cpu_percent": None,
        "memory_bytes": None,
        "restarts": None,
        "health": [],
        "limits": "",
        **{
            k: []
            for k in (
                "connections",
                "components",
                "events",
                "hosts",
                "log",
                "movable",
                "output",
                "warnings",
            )
        },
        "crash": None,
    }
    return {**plain, **changes}


CONTEXT = {
    "id": "0",
    "state": "Active",
    "is_running": True,
    "rate_hz": 100.0,
    "reached_hz": 49.5,
    "mean_s": 0.0011,
    "longest_s": 0.02,
    "missed": 512,
    "missed_hz": 50.5,
    "latest_s": 0.0031,
    "trouble": "",
}
RESTARTS = {"policy": "on-failure", "count": 2, "why": "signal 9", "returning": "", "given_up": ""}
CRASH = {
    "time": AT,
    "pid": 6,
    "what": "Fatal Python error: Segmentation fault at Arm.py:5 in f",
    "stack": "Thread 0x1 (most):\n  File other\n\nCurrent thread 0x2 (most):\n  File arm\n\nrest",
    "before": [entry("printed"), entry("shown")],
}


def test_a_page_with_everything() -> None:
    connections = [
        {"port": "out", "type": "DataOutPort", "to": ["/x:a", "/y:b"], "rate_hz": 49.5},
        {"port": "in", "type": "DataInPort", "to": [], "rate_hz": None},
        {"port": "s", "type": "CorbaPort", "to": ["/z:c"], "rate_hz": None},
    ]
    event = {"time": AT, "event": "ACTIVE", "subject": "0", "detail": ""}
    full = record(
        contexts=[CONTEXT],
        cpu_percent=12.34,
        memory_bytes=20 << 20,
        restarts=RESTARTS,
        health=["stuck 1:restart"],
        limits="memory 1 GiB",
        connections=connections,
        events=[event],
        log=[entry("shown\nbelow", "Traceback:\n  x")],
        crash={**CRASH, "before": [entry("printed")]},
        output=["C\x1b[1m"],
        warnings=["slow"],
    )
    assert list(page(full, NOW)) == [
        "/localhost/A.rtc - Move.",
        "  State      Active since 2026-11-23 11:58:00 (2 min 4 s)",
        "  Type       RTC:me:x:Arm:1.0",
        "  Set        default",
        "  Process    a (pid 7) up",
        "  Manager    m (pid 3)",
        "  Context 0  Active, 49.5 of 100 Hz, a cycle 1.1 ms, the longest 20 ms,"
        " begun at most 3.1 ms late, 512 periods missed (50.5/s)",
        "  Used       20.0 MiB, 12.3 % of a processor",
        "  Limits     memory 1 GiB",
        "  Health     stuck 1:restart",
        "  Restarts   2, policy on-failure; the last for signal 9",
        "Ports:",
        "  out  ->  /x:a           49.5/s",
        "           /y:b".replace("         ", "       ->", 1),
        "  in   <-  not connected",
        "  s    --  /z:c",
        "Warnings:",
        "  slow",
        "Events:",
        "  11:58:00.250  ACTIVE  0",
        "Log:",
        "  11:58:00.250 INFO  <stdout> shown",
        "      below",
        "      Traceback:",
        "        x",
        "Crash: 2026-11-23 11:58:00, pid 6",
        "  Fatal Python error: Segmentation fault at Arm.py:5 in f",
        "    File arm",
        "  11:58:00.250 INFO  <stdout> printed",
        "Output past the log:",
        "  C\\x1b[1m",
    ]


def test_what_is_in_the_log_is_not_told_again_before_the_crash() -> None:
    shown = [*page(record(log=[entry("printed")], crash=CRASH), NOW)]
    assert sum("printed" in line for line in shown) == 1
    assert sum("shown" in line for line in shown) == 1


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"since": ""}, "  State    Active"),
        ({"state": "Zombie", "why": "signal 9", "since": ""}, "  State    Zombie: signal 9"),
        ({"manager": {"name": "m", "pid": 0, "is_running": False}}, "  Manager  m (not running)"),
        ({"process": {"name": "a", "pid": 0, "state": "lost"}}, "  Process  a lost"),
    ],
)
def test_what_is_not_known_is_left_out(changes: dict[str, Any], line: str) -> None:
    assert line in [*page(record(**changes), NOW)]


@pytest.mark.parametrize(
    ("seconds", "told"), [(0, "0 s"), (59, "59 s"), (3600, "1 h"), (90_061, "1 d 1 h")]
)
def test_ages(seconds: int, told: str) -> None:
    since = datetime.fromtimestamp(NOW.timestamp() - seconds, UTC)
    shown = [*page(record(since=f"{since:%Y-%m-%dT%H:%M:%S}.000000000Z"), NOW)]
    assert shown[1].endswith(f"({told})")


def test_a_context_that_stands() -> None:
    unknown = {**CONTEXT, "mean_s": None, "missed": 0, "missed_hz": None, "latest_s": None}
    stopped = {**unknown, "is_running": False, "reached_hz": None}
    assert "  Context 0  Active, stopped, 100 Hz" in [*page(record(contexts=[stopped]), NOW)]
    driven = {**unknown, "rate_hz": 0.0}
    assert "  Context 0  Active, 49.5 Hz" in [*page(record(contexts=[driven]), NOW)]
    missed = {**unknown, "reached_hz": None, "missed": 3}
    told = "  Context 0  Active, 100 Hz, 3 periods missed"
    assert told in [*page(record(contexts=[missed]), NOW)]


def test_restarts_that_are_to_come() -> None:
    coming = {**RESTARTS, "returning": "signal 6", "given_up": "given up after 5 restarts"}
    told = "2, policy on-failure; the last for signal 9; comes back after signal 6; given up"
    assert any(told in line for line in page(record(restarts=coming), NOW))
    assert os.environ["TZ"] == "UTC"
