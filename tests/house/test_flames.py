"""Floors and flame graphs: what is sampled is drawn, and each floor is explained."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest

from bench import floors, page
from bench.flame_svg import boxes, importing, leaves, shares, svg
from bench.flames import PATHS
from bench.sampling import read, tidied

DOCS = Path(__file__).parents[2] / "docs"
FLOORS = (DOCS / "floors.md").read_text(encoding="utf-8")
RAW = """\
<module> (rtls:1);_find_and_load (<frozen importlib._bootstrap>:9);<module> (click/core.py:2) 3
main (rtkit/cli/tree/rtls.py:5);sock_recv_guts (socketmodule.c:1);recv (libc.so.6) 5
main (rtkit/a.py:5);epoll_wait (rtkit/a.py:9);select_epoll_poll (selectmodule.c.h:841) 90
Thread.run (threading.py:1);work (/home/somebody/parts/Motor.py:7);0x7f33 (libc.so.6) 2
main (rtkit/a.py:5);\x0e torn
"""


def test_stacks_are_read_without_what_waits() -> None:
    assert read(RAW, "it") == {
        ("it:", "import click.core · click/core.py"): 3,
        ("it:", "main · rtkit/cli/tree/rtls.py", "sock_recv"): 5,
        ("it:", "work · parts/Motor.py"): 2,
    }


def test_of_c_code_between_two_functions_of_python_nothing_stays() -> None:
    frames = ["f (a/b.py:1)", "builtin_map (bltinmodule.c:3)", "g (a/b.py:4)"]
    assert tidied(frames) == ["f · a/b.py", "g · a/b.py"]


def test_boxes_lie_within_those_they_are_called_by() -> None:
    stacks = Counter({("a:", "f · x/y.py", "g · x/y.py"): 3, ("a:", "f · x/y.py"): 1, ("b:",): 4})
    drawn = {box.name.partition(" ")[0]: box for box in boxes(stacks)}
    assert [(b.depth, b.start, b.samples) for b in drawn.values()] == [
        (0, 0, 4),
        (1, 0, 4),
        (2, 0, 3),
        (0, 4, 4),
    ]


def test_shares_are_of_the_innermost_frames() -> None:
    stacks = read(RAW, "it")
    assert leaves(stacks, 1) == [("it", "sock_recv", 0.5)]
    assert sum(shares(stacks).values()) == pytest.approx(1.0)
    assert importing(stacks) == pytest.approx(0.3)


def test_a_picture_is_well_formed() -> None:
    stacks = Counter({("a:", "<lambda> · rtkit/x&y.py"): 1})
    texts = ElementTree.fromstring(svg("a < b", stacks)).itertext()
    assert "a < b" in list(texts)


@pytest.mark.parametrize("name", PATHS)
def test_each_path_has_its_picture_and_its_place(name: str) -> None:
    text = (DOCS / "pictures" / "flames" / f"{name}.svg").read_text(encoding="utf-8")
    assert len(text) <= 60_000
    assert " · /" not in text, "a path of the machine that it was drawn on"
    assert FLOORS.count(f"<!-- flame {name}: begin -->") == 1
    assert f"](pictures/flames/{name}.svg)" in FLOORS


def test_each_floor_of_the_figures_is_explained() -> None:
    known = list(floors.figures((DOCS / "performance.md").read_text(encoding="utf-8")))
    assert len(known) > 100
    assert [each.floor_is for each in known if not floors.kind_of(each.floor_is)] == []


@pytest.mark.parametrize("kind", floors.KINDS)
def test_each_kind_of_floor_has_its_place(kind: str) -> None:
    assert FLOORS.count(f"<!-- floor {kind}: begin -->") == 1


def test_a_kind_tells_its_nearest_and_its_farthest_row() -> None:
    table = f"{page.BEGIN}| a | 1 s | 1 s | 1.05 x (0.9-1.1) |  | rtls |\n" + "".join(
        f"| {name} | 2 s | 1 s | {ratio} x |  | rtls |\n" for name, ratio in (("b", 4), ("c", 3))
    )
    known = list(floors.figures(f"{table}| d | - | - | - | - | not measured: no |\n{page.END}"))
    text = floors.section(known)
    assert text.startswith("3 rows: 1.05 to 4.00 times the floor, median 3.00.")
    assert [line.split()[1] for line in text.splitlines()[4:]] == ["a", "c", "b"]
