"""Places of their own for what is served within the process of a test."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
from conformance import subject
from mosquittokit import PASSWORD
from serialkit import Cable

from rtkit.keys import authority
from rtkit.link.local.streams import LocalStreams
from rtkit.property.service import Service
from rtkit.wires.serve import ServedObject, serve


@pytest.fixture(scope="session")
def keys(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Keys of this user, as `rtkeys init` makes them."""
    folder = str(tmp_path_factory.mktemp("keys") / "own")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RTKIT_KEYS", folder)
        authority.init("tester", ["localhost", "127.0.0.1"])
    return folder


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch, keys: str) -> Iterator[str]:
    """A short folder for sockets and state; no socket may be left in it."""
    folder = tempfile.mkdtemp(prefix="rtk")
    for name in ("run", "state"):
        os.mkdir(f"{folder}/{name}", 0o700)
    monkeypatch.setenv("RTKIT_KEYS", keys)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", f"{folder}/run")
    monkeypatch.setenv("RTKIT_STATE_DIR", f"{folder}/state")
    yield folder
    assert os.listdir(f"{folder}/run") == []
    shutil.rmtree(folder)


@pytest.fixture
def service() -> Service:
    """What the conformance of endpoints is tried with."""
    return subject()


@pytest.fixture
def served(request: pytest.FixtureRequest, place: str, service: Service) -> Iterator[ServedObject]:
    """That service at its Unix socket, and where ``OPEN`` of the module says: keywords of serve."""
    opening = {"is_on_zenoh": False, **getattr(request.module, "OPEN", {})}
    with serve(service, "robot", **opening) as served:
        yield served


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch) -> Iterator[ExitStack]:
    """What is closed at the end; brokers that are started on the way know the password."""
    monkeypatch.setenv("RTKIT_MQTT_PASSWORD", PASSWORD)
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def streams() -> Iterator[tuple[LocalStreams, LocalStreams]]:
    """Two processes' worth of streams: who is called or receives, and who calls or sends."""
    with tempfile.TemporaryDirectory(prefix="rt") as folder:
        first, second = LocalStreams(f"{folder}/a"), LocalStreams(f"{folder}/b")
        yield first, second
        second.close()
        first.close()
        assert os.listdir(folder) == []


@pytest.fixture
def cable(place: str) -> Iterator[Cable]:
    """A serial line between two ends, in that folder."""
    cable = Cable(place)
    yield cable
    cable.close()
