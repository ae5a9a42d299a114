"""Pictures of runs: all that must be in them is, and no name covers another."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from bug import pictures
from bug.records import Row
from bug.watching import drawn
from bug_runs import record, rows
from lxml import etree

SVG = "{http://www.w3.org/2000/svg}"


def _texts(svg: str) -> list[str]:
    return [each.text or "" for each in etree.fromstring(svg.encode()).iter(f"{SVG}text")]


def _classes(svg: str, tag: str) -> list[str]:
    return [each.get("class", "") for each in etree.fromstring(svg.encode()).iter(f"{SVG}{tag}")]


def test_a_picture_names_start_goal_hits_and_leaves() -> None:
    svg = pictures.run_svg(record())
    assert {"S", "T", "H1", "L1"} <= set(_texts(svg))
    assert "bug2, laser, left first, in one-box" in _texts(svg)
    ways = [each for each in _classes(svg, "path") if each.startswith("way")]
    assert ways[:3] == ["way goal", "way follow", "way goal"]
    assert _classes(svg, "path").count("wall") == 1


@pytest.mark.parametrize("has_line", [True, False])
def test_the_m_line_is_drawn_where_the_variant_has_one(has_line: bool) -> None:
    in_legend = 1
    classes = _classes(pictures.run_svg(record(has_line=has_line)), "path")
    assert classes.count("line") == in_legend + has_line


def test_runs_of_a_world_are_side_by_side_a_row_for_sensors() -> None:
    svg = pictures.multiples_svg([record(v, s) for s in ("laser", "ir") for v in ("bug1", "alg2")])
    titles = [each for each in _texts(svg) if re.fullmatch(r"\w+, (laser|ir)", each)]
    assert titles == ["bug1, laser", "alg2, laser", "bug1, ir", "alg2, ir"]
    assert _classes(svg, "path").count("wall") == 4
    assert "one-box (one <box>)" in _texts(svg)


def test_what_went_wrong_is_to_be_seen() -> None:
    assert "wrong" in _classes(pictures.run_svg(record(status="gave-up")), "text")
    assert "wrong" not in _classes(pictures.run_svg(record()), "text")


def test_the_same_run_gives_the_same_bytes() -> None:
    assert pictures.run_svg(record()) == pictures.run_svg(record())


def test_names_at_one_place_do_not_cover_each_other() -> None:
    near = [(0.0, -0.95 - 0.05 * i) for i in range(6)]
    svg = pictures.run_svg(record(hits=near, leaves=near))
    boxes = []
    for each in etree.fromstring(svg.encode()).iter(f"{SVG}text"):
        if each.get("class") == "name":
            x, y = float(each.get("x")), float(each.get("y"))
            wide = 13 * 0.66 * len(each.text)
            boxes.append((x - wide / 2, y - 11, x + wide / 2, y + 2))
    covered = sum(
        a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]
        for i, a in enumerate(boxes)
        for b in boxes[i + 1 :]
    )
    assert len(boxes) == 14
    assert not covered


def test_a_terminal_shows_walls_path_and_names() -> None:
    text = "\n".join(drawn(record().environment, rows(), 60, 30).text(has_colour=False))
    assert all(name in text for name in ("S", "T", "H1", "L1", "@"))
    assert sum(0x2800 < ord(c) < 0x2900 for c in text) > 60
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 60
    assert len(text.splitlines()) <= 30


def test_a_terminal_with_colours_tells_modes_apart() -> None:
    text = "".join(drawn(record().environment, rows(), 60, 30).text(has_colour=True))
    assert "\x1b[34m" in text
    assert "\x1b[33m" in text


def test_a_run_of_one_row_is_drawn() -> None:
    first = [Row(0.0, 0.0, -4.0, 0.0, "goal")]
    assert "@" in "".join(drawn(record().environment, first, 20, 5).text(has_colour=False))
    assert "<svg" in pictures.run_svg(record(rows=first, hits=[], leaves=[]))


def test_a_png_is_beside_it_where_a_renderer_is_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    svg = tmp_path / "a.svg"
    svg.write_text(pictures.run_svg(record()))
    monkeypatch.setenv("PATH", str(tmp_path))
    pictures.rendered(svg)
    assert [each.name for each in tmp_path.iterdir()] == ["a.svg"]
    renderer = tmp_path / "rsvg-convert"
    renderer.write_text('#!/bin/sh\necho "$4" > "$4"\n')
    renderer.chmod(0o755)
    pictures.rendered(svg)
    assert (tmp_path / "a.png").is_file()
    assert not (tmp_path / ".a.png").exists()
