"""Wait for a link: what ends it, and what is told of the link before."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from rtkit.errors import Refused, Unreachable
from rtkit.hosts.bring_up import link
from rtkit.hosts.host import Host
from rtkit.link import host_links
from rtkit.link.host_links import HostLink

ROBOT = Host("robot1", "10.0.0.1", "root")


class Near:
    """Manager of this host whose link was refused before or after it was asked."""

    manager = "m2"

    def __init__(self, refused_at: float) -> None:
        self._refused_at = refused_at

    def set(self, name: str, text: str) -> None:
        assert name == "link_host"
        at = self._refused_at or time.monotonic()
        host_links.write(HostLink("robot1", "m2", "manager", "no key", refused_at=at))


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    tmp_path.chmod(0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))


def test_a_refused_link_ends_the_wait_with_its_reason() -> None:
    why = "manager m2 of this host cannot link robot1: no key"
    with pytest.raises(Refused, match=f"^{why}$"):
        link(ROBOT, Near(0.0), 60.0)  # type: ignore[arg-type]


def test_the_manager_is_told_to_which_a_link_led_before() -> None:
    linked = HostLink("robot1", "m2", "manager")
    near = SimpleNamespace(manager="m2", set=lambda *_: host_links.write(linked))
    for before, told in (("", ""), ("m3", "m3"), ("manager", "")):
        host_links.write(HostLink("robot1", "m2", before))
        assert link(ROBOT, near, 60.0) == told  # type: ignore[arg-type]


def test_a_refusal_from_before_does_not_end_the_wait() -> None:
    with pytest.raises(Unreachable, match=r"is not linked within 0\.01 s: no key"):
        link(ROBOT, Near(time.monotonic()), 0.01)  # type: ignore[arg-type]
