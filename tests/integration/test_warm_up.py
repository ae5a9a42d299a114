"""The rehearsal of the zygote: it succeeds, time and again, and nothing of it is left."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rtkit.deployment.facts import ComponentFacts
from rtkit.logs.logs import Log
from rtkit.manager.claim import remove_stale
from rtkit.manager.predecessor.unreported import checkpoints_of_the_dead
from rtkit.manager.slaves import warm_up as rehearsal
from rtkit.manager.slaves.warm_up import warm_up
from rtkit.modules.loader import Loader
from rtkit.rtc import serde
from rtkit.rtc.profiles import ModuleProfile, TypeProfile


@pytest.fixture
def folder() -> Iterator[str]:
    with tempfile.TemporaryDirectory(prefix="rtr") as path:  # a socket's path has to be short
        yield path


def state(folder: str) -> dict[str, Any]:
    gc.collect()
    return {
        "files": os.listdir(folder),
        "descriptors": len(os.listdir("/proc/self/fd")),
        "threads": threading.active_count(),
        "modules": sorted(sys.modules),
        "path": list(sys.path),
        "environment": dict(os.environ),
    }


def test_nothing_is_left_of_it(folder: str) -> None:
    log = Log("zygote", f"{folder}/m.log")
    settings = {"data": f"{folder}/m.%p.data"}
    log.open()
    try:
        warm_up(log, settings)
        before = state(folder)
        warm_up(log, settings)
        after = state(folder)
    finally:
        log.close()
    assert before == after
    assert after["files"] == []


def test_coders_of_all_that_a_creation_reports_are_made(
    folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: dict[Any, Any] = {}
    monkeypatch.setattr(serde, "_encoders", made)
    warm_up(Log("zygote", f"{folder}/m.log"), {"data": f"{folder}/m.%p.data"})
    assert {ComponentFacts, ModuleProfile, TypeProfile} <= made.keys()


def test_slaves_find_no_modules_where_it_found_its_own(folder: str, tmp_path: Path) -> None:
    (tmp_path / "Empty.py").write_text("def EmptyInit(manager): pass")
    log = Log("zygote", f"{folder}/m.log")
    log.open()
    try:
        warm_up(log, {"data": f"{folder}/m.%p.data"})
    finally:
        log.close()
    Loader([str(tmp_path)]).load("Empty.py")
    assert str(tmp_path) in sys.path
    assert rehearsal._FOLDER not in sys.path


def test_a_zygote_that_is_killed_in_it_is_not_taken_for_a_slave(
    folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", folder)
    monkeypatch.setattr(rehearsal, "_LINES", rehearsal._LINES[:1])  # its component is still there
    monkeypatch.setattr(rehearsal, "_remove", lambda _: None)
    warm_up(Log("zygote", f"{folder}/m.log"), {"data": f"{folder}/m.%p.data"})
    assert b"Extra0" in (Path(folder) / f"m.{os.getpid()}.rehearsed").read_bytes()
    assert checkpoints_of_the_dead("m", ()) == {}
    remove_stale("m", ())
    assert [each for each in os.listdir(folder) if each.startswith("m.")] == []


def test_what_fails_in_it_is_told(folder: str, monkeypatch: pytest.MonkeyPatch) -> None:
    failing = {**rehearsal._LINES[0], "create": "Nobody?instance_name=Extra0"}
    monkeypatch.setattr(rehearsal, "_LINES", (failing, rehearsal._LINES[1]))
    log = Log("zygote", f"{folder}/m.log")
    with pytest.raises(RuntimeError, match="Nobody is not known"):
        warm_up(log, {"data": f"{folder}/m.%p.data"})
    assert os.listdir(folder) == []
