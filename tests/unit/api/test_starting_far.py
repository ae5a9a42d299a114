"""What is told where a manager of another host cannot be started for a plan."""

from __future__ import annotations

from contextlib import nullcontext
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.api import gathering
from rtkit.errors import Refused, RtkitError, Unreachable
from rtkit.hosts import bring_up, inventory
from rtkit.hosts.host import Host


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (
            Unreachable("fb (10.0.0.2): No route to host"),
            "host fb cannot be reached: fb (10.0.0.2): No route to host",
        ),
        (Refused("fb: no wheels"), "fb: no wheels"),
    ],
)
def test_a_host_that_cannot_be_reached_is_named_as_by_other_commands(
    error: RtkitError, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def start(*_words: object, **_how: object) -> None:
        raise error

    session: Any = SimpleNamespace(usual_manager="manager", timeout_s=1.0, verbose=len)
    monkeypatch.setattr(inventory, "host", lambda name: Host(name, "10.0.0.2"))
    monkeypatch.setattr(gathering, "connected", lambda _name, _timeout_s: nullcontext())
    monkeypatch.setattr(bring_up, "start", start)
    with pytest.raises(type(error)) as caught:
        gathering._Starter(session).start("manager@fb")
    assert str(caught.value) == told
