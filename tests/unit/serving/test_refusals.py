"""What was denied is in the log, and does not fill it."""

from __future__ import annotations

import pytest

from rtkit.serving import refusals
from rtkit.serving.refusals import Refusals


def test_the_first_are_told_and_the_rest_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    now = 100.0
    monkeypatch.setattr(refusals, "monotonic", lambda: now)
    monkeypatch.setattr(refusals, "MOST", 2)
    log: list[str] = []
    heard = Refusals(log.append)
    for number in range(1000):
        heard("uid-1", "SET", f"p{number}")
    heard("uid-2", "SET", "speed")
    assert log == [
        "denied: SET p0 by 'uid-1'", "denied: SET p1 by 'uid-1'", "denied: SET speed by 'uid-2'",
    ]  # fmt: skip
    now += refusals.INTERVAL_S
    heard("uid-1", "SET", "again")
    heard.sum_up("uid-2")
    assert log[3:] == [
        "denied: 998 more by 'uid-1', the last one SET p999 by 'uid-1'",
        "denied: SET again by 'uid-1'",
    ]
