"""Which connections rtresurrect makes, and rtteardown removes: the rules of §10.2 and §10.3."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

Run = Callable[[str], Any]
OUT, INTO = "/localhost/local.host_cxt/Output0.rtc:out", "/localhost/Std0.rtc:in"


@pytest.fixture
def saved(run: Run, tmp_path: Path) -> Path:
    """What rtcryo makes of one connection, which is removed again."""
    file = tmp_path / "system.xml"
    assert run(f"rtcon -i wire {OUT} {INTO} && rtcryo -o {file} && rtdis {OUT}").status == 0
    return file


def test_what_is_missing_is_made(world: FakeManager, run: Run, saved: Path) -> None:
    assert run(f"rtresurrect {saved}") == (0, "", "")
    assert sorted(world.connectors) == ["wire"]


def test_the_same_connection_is_left_alone(world: FakeManager, run: Run, saved: Path) -> None:
    assert run(f"rtcon -i wire {OUT} {INTO} && rtresurrect {saved}") == (0, "", "")
    assert sorted(world.connectors) == ["wire"]


def test_another_id_is_a_second_connection(world: FakeManager, run: Run, saved: Path) -> None:
    assert run(f"rtcon -i other {OUT} {INTO} && rtresurrect {saved}") == (0, "", "")
    assert sorted(world.connectors) == ["other", "wire"]


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("rtcon -i wire /localhost/Err0.rtc:out /localhost/Input0.rtc:in", "is in use between"),
        (f"rtcon -i wire -p dataport.subscription_type=flush {OUT} {INTO}", "exists with another"),
    ],
)
def test_an_id_in_use_for_something_else(
    world: FakeManager, run: Run, saved: Path, line: str, why: str
) -> None:
    assert run(line).status == 0
    before = dict(world.connectors)
    status, out, err = run(f"rtresurrect {saved}")
    assert (status, out) == (1, "")
    assert err.startswith("rtresurrect: Required action failed: ")
    assert why in err
    assert world.connectors == before


def test_only_the_connection_of_that_id_is_removed(
    world: FakeManager, run: Run, saved: Path
) -> None:
    assert run(f"rtcon -i wire {OUT} {INTO} && rtcon -i other {OUT} {INTO}").status == 0
    assert (
        run(f"rtteardown --dry-run {saved}").out == f"Disconnect {OUT} from {INTO} with ID wire\n"
    )
    assert run(f"rtteardown {saved}") == (0, "", "")
    assert sorted(world.connectors) == ["other"]
    told = f"rtteardown: Action failed: No connection from {OUT} with ID wire\n"
    assert run(f"rtteardown {saved}") == (0, "", told)


@pytest.mark.parametrize("name", ["rtresurrect", "rtteardown", "rtcheck", "rtstart", "rtstop"])
def test_two_files_show_the_usage(run: Run, saved: Path, name: str) -> None:
    status, out, err = run(f"{name} {saved} {saved}")
    assert (status, out) == (1, "")
    assert err.startswith(f"Usage: {name} [OPTIONS] [FILE]\n")
