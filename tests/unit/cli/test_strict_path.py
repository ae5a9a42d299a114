"""``rtresurrect --strict-path``: what the ends of connectors tell of their components' paths."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

Run = Callable[[str], Any]


@pytest.fixture
def saved(world: FakeManager, run: Run, tmp_path: Path) -> Path:
    """What rtcryo makes of a connection of two components in different directories."""
    ends = "/localhost/local.host_cxt/Output0.rtc:out /localhost/Std0.rtc:in"
    file = tmp_path / "system.xml"
    assert run(f"rtcon -i wire {ends} && rtcryo -o {file}").status == 0
    world.performed.clear()
    return file


def test_what_was_saved_passes(world: FakeManager, run: Run, saved: Path) -> None:
    assert 'rtsExt:name="COMPONENT_PATH_ID"' in saved.read_text()
    assert run(f"rtresurrect --strict-path {saved}") == (0, "", "")


def test_another_path_is_refused_before_anything_is_done(
    world: FakeManager, run: Run, saved: Path
) -> None:
    told = 'rtsExt:value="localhost/local.host_cxt/Output0.rtc"'
    text = saved.read_text()
    assert text.count(told) == 1
    saved.write_text(text.replace(told, 'rtsExt:value="elsewhere/Output0.rtc"'))
    why = (
        f"rtresurrect: {saved}: connector wire: COMPONENT_PATH_ID of Output0"
        " is elsewhere/Output0.rtc, but its path is localhost/local.host_cxt/Output0.rtc\n"
    )
    assert run(f"rtresurrect --strict-path {saved}") == (1, "", why)
    assert run(f"rtresurrect --exit-detail --strict-path {saved}").status == 3
    assert world.performed == []
    assert run(f"rtresurrect {saved}") == (0, "", "")


def test_ends_that_tell_no_path_pass(run: Run, saved: Path) -> None:
    lines = [line for line in saved.read_text().splitlines() if "COMPONENT_PATH_ID" not in line]
    saved.write_text("\n".join(lines))
    assert run(f"rtresurrect --strict-path {saved}") == (0, "", "")
