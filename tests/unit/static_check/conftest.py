"""Systems changed in one place, checked against the profiles that ship."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from rtkit.report.finding import Checked
from rtkit.static_check.stock import CandidateDocument, stocked
from rtkit.static_check.verdict import Options, opened, verdict

ROOT = Path(__file__).parents[3]
Check = Callable[..., Checked]


@cache
def shipped() -> tuple[CandidateDocument, ...]:
    files = sorted((ROOT / "profiles").glob("*.xml"))
    return tuple(CandidateDocument(file.name, file.read_bytes()) for file in files)


@pytest.fixture
def text_of() -> Callable[[str], str]:
    return lambda name: (ROOT / "profiles" / "systems" / f"{name}.xml").read_text("utf-8")


@pytest.fixture
def check() -> Check:
    """Check a text against the shipped profiles, changed ones in place of theirs, and others."""

    def run(
        text: str,
        profiles: dict[str, str] | None = None,
        options: Options | None = None,
        form: str = "xml",
    ) -> Checked:
        system = opened(text.encode(), "sys", form=form)
        changed = {
            name: CandidateDocument(name, each.encode()) for name, each in (profiles or {}).items()
        }
        known = [changed.pop(each.name, each) for each in shipped()]
        catalogue, troubles = stocked([*known, *changed.values()], system.types)
        assert troubles == []
        return verdict(system, catalogue, options or Options())

    return run


@pytest.fixture
def profile_of() -> Callable[[str], str]:
    return lambda name: (ROOT / "profiles" / f"{name}.xml").read_text("utf-8")
