"""A request that comes again acts once: recorded on the wire, and sent a second time."""

from __future__ import annotations

from typing import Any

import pytest

import rtkit
from rtkit.link.transport import Link
from rtkit.property.exchange import Reply


class Recorder:
    """A link that remembers what was sent to change something."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self.sent: list[tuple[str, str]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self._link, name)

    def send(self, key: str, payload: str | None, timeout_s: float) -> Any:
        """See `Link.send`."""
        if payload is not None:
            self.sent.append((key, payload))
        return self._link.send(key, payload, timeout_s)

    def replay(self) -> list[Reply]:
        """Send everything again."""
        return [self._link.call(key, payload, 10.0) for key, payload in self.sent]


def test_creations_that_are_replayed_make_one_component_each(
    manager: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_PORT"):
        monkeypatch.setenv(name, manager.environment[name])
    with rtkit.connect() as tree:
        recorder = tree.link = Recorder(tree.link)
        assert tree.set("create_component", "ConsoleIn") == "ConsoleIn0"
        assert tree.create("ConsoleIn") == "/localhost/ConsoleIn1.rtc"
        told = recorder.replay()
        assert told[0] == Reply("ConsoleIn0")
        assert "ConsoleIn1" in told[1].value()
        assert tree.ls("/localhost") == ["ConsoleIn0.rtc", "ConsoleIn1.rtc", "manager.mgr"]
