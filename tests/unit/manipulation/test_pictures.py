"""Pictures: those of the pages are what is drawn now."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

from manipulation import pictures

FOLDER = Path(__file__).parents[3] / "docs" / "manipulation"


def test_the_pictures_of_the_pages_are_what_is_drawn() -> None:
    drawn = dict(pictures.drawn())
    for name, svg in drawn.items():
        ElementTree.fromstring(svg)
        kept = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
        assert kept == svg, f"python -m manipulation.pictures {FOLDER}: {name}"
    page = (FOLDER / "index.md").read_text(encoding="utf-8")
    assert all(f"({name}.svg)" in page for name in drawn)
