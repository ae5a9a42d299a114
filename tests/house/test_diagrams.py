"""The diagrams of the pages show the tables of the code as they are."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest
from lxml import etree

ROOT = Path(__file__).parents[2]
PICTURES: dict[str, str] = runpy.run_path(str(ROOT / "tools" / "make_diagrams.py"))["pictures"]()
FILES = sorted((ROOT / "docs" / "pictures").glob("*.svg"))
_MOST_BYTES = 8192


@pytest.mark.parametrize("name", PICTURES)
def test_a_diagram_is_up_to_date(name: str) -> None:
    file = ROOT / "docs" / "pictures" / name
    assert file.read_text(encoding="utf-8") == PICTURES[name], "stale, draw it anew: make pictures"


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_a_picture_is_small_and_has_a_background_of_its_own(file: Path) -> None:
    data = file.read_bytes()
    assert len(data) <= _MOST_BYTES
    back = etree.fromstring(data).find("{http://www.w3.org/2000/svg}rect")
    assert back is not None
    assert back.get("class") == "rt-back"


def test_what_is_photographed_is_small() -> None:
    sizes = {each.name: each.stat().st_size for each in (ROOT / "docs/pictures").glob("*.png")}
    assert {name: size for name, size in sizes.items() if size > 8 * _MOST_BYTES} == {}
