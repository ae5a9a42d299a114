"""Managers as processes: how long what is asked of them may take."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from rtkit.tree import managers


def test_a_restart_has_the_time_of_an_end_and_of_a_start(monkeypatch: pytest.MonkeyPatch) -> None:
    tree = SimpleNamespace(set=lambda *_: "7")
    monkeypatch.setattr(managers, "connect", lambda *_: nullcontext(tree))
    bounds = []

    def hear(_descriptor: int, bound_s: float) -> list[str]:
        bounds.append(bound_s)
        return ["ready"]

    assert managers.restart("m", 3.0, hear) == (7, ["ready"])
    assert bounds == [6.0]
