"""Places of their own for what is served within the process of a test."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator

import pytest
from serialkit import Cable


@pytest.fixture
def place(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A short folder for sockets and state; no socket may be left in it."""
    folder = tempfile.mkdtemp(prefix="rtk")
    for name in ("run", "state"):
        os.mkdir(f"{folder}/{name}", 0o700)
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", f"{folder}/run")
    monkeypatch.setenv("RTKIT_STATE_DIR", f"{folder}/state")
    yield folder
    assert os.listdir(f"{folder}/run") == []
    shutil.rmtree(folder)


@pytest.fixture
def cable(place: str) -> Iterator[Cable]:
    """A serial line between two ends, in that folder."""
    cable = Cable(place)
    yield cable
    cable.close()
