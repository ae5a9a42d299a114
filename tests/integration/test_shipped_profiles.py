"""The profiles in the repository are those that the samples make, and bring the samples up."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from rtkit.profile.read import read_rtc, read_rts

ROOT = Path(__file__).parents[2]
SYSTEMS = sorted((ROOT / "profiles" / "systems").glob("*.xml"))


def test_they_are_not_stale(tmp_path: Path) -> None:
    runpy.run_path(str(ROOT / "tools" / "make_profiles.py"))["write"](tmp_path)
    made = {file.relative_to(tmp_path): file.read_bytes() for file in tmp_path.rglob("*.xml")}
    kept = ROOT / "profiles"
    assert made == {file.relative_to(kept): file.read_bytes() for file in kept.rglob("*.xml")}


@pytest.mark.parametrize("file", sorted((ROOT / "profiles").glob("*.xml")), ids=lambda f: f.stem)
def test_component_profiles_are_strict(file: Path) -> None:
    reading = read_rtc(file.read_bytes(), file.name, strict=True)
    assert reading.notes == ()
    assert reading.profile.id == f"RTC:rtkit:example:{file.stem}:1.0"


@pytest.mark.parametrize("file", SYSTEMS, ids=lambda f: f.stem)
def test_system_profiles_are_strict(file: Path) -> None:
    assert read_rts(file.read_bytes(), file.name, strict=True).notes == ()
