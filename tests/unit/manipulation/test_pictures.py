"""Pictures: those of the pages are what is drawn now, and what they say can be read."""

from __future__ import annotations

from itertools import combinations, pairwise
from math import hypot
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest
from manipulation import pictures

FOLDER = Path(__file__).parents[3] / "docs" / "manipulation"
DRAWN = dict(pictures.drawn())
Box = tuple[float, float, float, float]


def _of(name: str, kind: str) -> list[Element]:
    return ElementTree.fromstring(DRAWN[name]).findall(f".//{{*}}{kind}")


def _numbers(element: Element, *keys: str) -> list[float]:
    return [float(element.get(key, "0")) for key in keys]


def _texts(name: str) -> list[str]:
    return ["".join(each.itertext()) for each in _of(name, "text")]


def _label_box(text: Element) -> Box:
    """Return the box of a text, somewhat smaller than what is drawn."""
    x, y, size = _numbers(text, "x", "y", "font-size")
    width = 0.5 * size * len("".join(text.itertext()))
    left = x - width * {"start": 0, "middle": 0.5, "end": 1}[text.get("text-anchor", "start")]
    return left, y - 0.7 * size, left + width, y


def _rectangle(each: Element) -> Box:
    x, y, width, height = _numbers(each, "x", "y", "width", "height")
    return x, y, x + width, y + height


def _meet(one: Box, other: Box) -> bool:
    across = min(one[2], other[2]) - max(one[0], other[0])
    return across > 0 and min(one[3], other[3]) - max(one[1], other[1]) > 0


def test_the_pictures_of_the_pages_are_what_is_drawn() -> None:
    for name, svg in DRAWN.items():
        ElementTree.fromstring(svg)
        kept = (FOLDER / f"{name}.svg").read_text(encoding="utf-8")
        assert kept == svg, f"python -m manipulation.pictures {FOLDER}: {name}"
    page = (FOLDER / "index.md").read_text(encoding="utf-8")
    assert all(f"({name}.svg)" in page for name in DRAWN)


@pytest.mark.parametrize("name", DRAWN)
def test_all_that_a_picture_says_can_be_read(name: str) -> None:
    texts = _of(name, "text")
    title = "".join(_of(name, "title")[0].itertext())
    assert "".join(texts[0].itertext()).lower() == title.lower()
    assert min(float(each.get("font-size", "0")) for each in texts) >= 10
    walls = [_rectangle(each) for each in _of(name, "rect") if each.get("fill") == "#4a5563"]
    boxes = [_label_box(each) for each in texts]
    assert not [(box, wall) for box in boxes for wall in walls if _meet(box, wall)]
    pairs = combinations(zip(_texts(name), boxes, strict=True), 2)
    assert not [(one, other) for one, other in pairs if _meet(one[1], other[1])]


@pytest.mark.parametrize("name", [each for each in DRAWN if each.endswith("-way")])
def test_no_part_of_a_way_covers_another(name: str) -> None:
    pieces = [piece for line in _of(name, "polyline") for piece in _pieces(line)]
    assert not [pair for pair in combinations(pieces, 2) if _lie_on_each_other(*pair)]
    marks = [_numbers(each, "cx", "cy", "r") for each in _of(name, "circle")]
    for (x, y, radius), (other_x, other_y, other) in combinations(marks, 2):
        assert hypot(x - other_x, y - other_y) > radius + other


def _pieces(line: Element) -> list[Box]:
    points = [each.split(",") for each in line.get("points", "").split()]
    whole = [(float(x), float(y)) for x, y in points]
    return [(min(a, c), min(b, d), max(a, c), max(b, d)) for (a, b), (c, d) in pairwise(whole)]


def _lie_on_each_other(one: Box, other: Box) -> bool:
    across = min(one[2], other[2]) - max(one[0], other[0])
    down = min(one[3], other[3]) - max(one[1], other[1])
    is_row = one[1] == one[3] == other[1] == other[3]
    is_column = one[0] == one[2] == other[0] == other[2]
    return (is_row and across > 0) or (is_column and down > 0)


@pytest.mark.parametrize(("name", "ends"), [("doorway", 3), ("switch", 2), ("light-switch", 1)])
def test_where_an_object_ends_is_one_box(name: str, ends: int) -> None:
    dashed = [each for each in _of(f"{name}-way", "rect") if each.get("stroke-dasharray")]
    assert len(dashed) == ends


def test_a_legend_names_only_what_is_drawn() -> None:
    assert {"empty", "carrying"} <= set(_texts("switch-way"))
    assert "empty" in _texts("unknown-way")
    assert "carrying" not in _texts("unknown-way")


def test_all_boxes_of_a_tree_are_as_wide_as_the_longest_label() -> None:
    for name in (each for each in DRAWN if each.endswith("-tree")):
        widths = {each.get("width") for each in _of(name, "rect")[1:]}
        sizes = {each.get("font-size") for each in _of(name, "text") if "take" in (each.text or "")}
        assert (len(widths), sizes) == (1, {"13"}), name
