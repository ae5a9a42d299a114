"""Whatever the system: boxes do not overlap, wires lead from port to port and round the boxes."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.drawing.layout import laid_out
from rtkit.drawing.parallel import apart
from rtkit.drawing.scene import (
    DATA,
    IN,
    LEFT,
    OUT,
    RIGHT,
    SERVICE,
    Box,
    Layout,
    Point,
    PortPin,
    Scene,
    Wire,
    WireEnd,
    box_size,
    port_offset,
)
from rtkit.drawing.sides import with_sides

PORTS = {
    IN: PortPin("in", LEFT, IN),
    OUT: PortPin("a longer name", RIGHT, OUT),
    SERVICE: PortPin("service", LEFT, SERVICE),
}


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    kinds = st.lists(st.sampled_from(list(PORTS)), max_size=5)
    layouts = draw(st.lists(kinds, max_size=12))
    boxes = tuple(
        Box(f"Box{index}", "Type", tuple(PORTS[kind] for kind in sorted(listed)))
        for index, listed in enumerate(layouts)
    )
    ends = [WireEnd(b, p) for b, box in enumerate(boxes) for p in range(len(box.ports))]

    def of_kind(kind: str) -> list[WireEnd]:
        return [end for end in ends if boxes[end.box].ports[end.port].kind == kind]

    wires: list[Wire] = []
    for kind, sources, targets in (
        (DATA, of_kind(OUT), of_kind(IN)),
        (SERVICE, of_kind(SERVICE), of_kind(SERVICE)),
    ):
        if sources and targets:
            pairs = st.tuples(st.sampled_from(sources), st.sampled_from(targets))
            chosen = draw(st.lists(pairs, max_size=14, unique=True))
            wires += [Wire(one, other, kind) for one, other in chosen if one != other]
    return with_sides(Scene(boxes, tuple(wires)))


@st.composite
def chains(draw: st.DrawFn) -> Scene:
    """Draw boxes of which each leads to the next one, and some to others; they do not fit a row."""
    count = draw(st.integers(4, 16))
    kinds = draw(st.lists(st.sampled_from((1, 1, 1, 3)), min_size=count, max_size=count))
    boxes = tuple(
        Box(f"Box{index}", "Type", (PORTS[IN],) * ports + (PORTS[OUT],) * ports)
        for index, ports in enumerate(kinds)
    )
    wires = [Wire(WireEnd(n, kinds[n]), WireEnd(n + 1, 0)) for n in range(count - 1)]
    box = st.integers(0, count - 1)
    for one, other in draw(st.lists(st.tuples(box, box), max_size=6, unique=True)):
        wires.append(Wire(WireEnd(one, 2 * kinds[one] - 1), WireEnd(other, kinds[other] - 1)))
    return with_sides(Scene(boxes, tuple(dict.fromkeys(wires))))


def laid_outs() -> st.SearchStrategy[tuple[Scene, Layout]]:
    """Draw scenes with their layouts, also with ones that go on in further rows."""
    wide = scenes().map(lambda scene: (scene, laid_out(scene)))
    return wide | chains().map(lambda scene: (scene, laid_out(scene, 500)))


def place_of(scene: Scene, layout: Layout, end: WireEnd) -> Point:
    box = scene.boxes[end.box]
    x, y = layout.places[end.box]
    is_right = box.ports[end.port].side == RIGHT
    return x + (box_size(box).width if is_right else 0), y + port_offset(box, end.port)


def pieces(path: tuple[Point, ...]) -> Iterator[tuple[Point, Point]]:
    return pairwise(path)


@settings(max_examples=150, deadline=None)
@given(laid_outs())
def test_boxes_do_not_overlap(drawn: tuple[Scene, Layout]) -> None:
    scene, layout = drawn
    frames = [
        (x, y, x + box_size(box).width, y + box_size(box).height)
        for box, (x, y) in zip(scene.boxes, layout.places, strict=True)
    ]
    for one, other in combinations(frames, 2):
        is_apart = one[2] < other[0] or other[2] < one[0] or one[3] < other[1] or other[3] < one[1]
        assert is_apart, (one, other)
    for left, top, right, bottom in frames:
        assert left >= 0
        assert top >= 0
        assert right <= layout.size.width
        assert bottom <= layout.size.height


@settings(max_examples=150, deadline=None)
@given(laid_outs())
def test_wires_lead_from_port_to_port_at_right_angles(drawn: tuple[Scene, Layout]) -> None:
    scene, layout = drawn
    for wire, path in zip(scene.wires, layout.paths, strict=True):
        assert path[0] == place_of(scene, layout, wire.source)
        assert path[-1] == place_of(scene, layout, wire.target)
        for (x, y), (u, v) in pieces(path):
            assert (x == u) != (y == v)
            assert 0 <= min(x, u) <= max(x, u) <= layout.size.width
            assert 0 <= min(y, v) <= max(y, v) <= layout.size.height


@settings(max_examples=150, deadline=None)
@given(laid_outs())
def test_wires_lead_round_boxes(drawn: tuple[Scene, Layout]) -> None:
    scene, layout = drawn
    for path in layout.paths:
        for (x, y), (u, v) in pieces(path):
            for box, (left, top) in zip(scene.boxes, layout.places, strict=True):
                size = box_size(box)
                inside_x = min(x, u) < left + size.width and max(x, u) > left
                inside_y = min(y, v) < top + size.height and max(y, v) > top
                assert not (inside_x and inside_y), (box.title, path)


@settings(max_examples=150, deadline=None)
@given(laid_outs())
def test_wires_without_a_common_port_do_not_lie_on_one_another(drawn: tuple[Scene, Layout]) -> None:
    scene, layout = drawn
    listed = list(zip(scene.wires, layout.paths, strict=True))
    for (one, first), (other, second) in combinations(listed, 2):
        if {one.source, one.target} & {other.source, other.target}:
            continue
        for (a, b), (c, d) in pieces(first):
            for (e, f), (g, h) in pieces(second):
                if a == c == e == g:
                    assert max(b, d) <= min(f, h) or max(f, h) <= min(b, d), (first, second)
                if b == d == f == h:
                    assert max(a, c) <= min(e, g) or max(e, g) <= min(a, c), (first, second)


@settings(max_examples=100, deadline=None)
@given(laid_outs(), st.integers(2, 5))
def test_wires_with_the_same_ends_run_side_by_side(drawn: tuple[Scene, Layout], count: int) -> None:
    scene, layout = drawn
    for number, (wire, path) in enumerate(zip(scene.wires, layout.paths, strict=True)):
        tips = [f"{number} {each}" for each in range(count)]
        found = apart([wire._replace(tip=tip) for tip in tips], dict.fromkeys(tips, path))
        assert len({tuple(each) for each in found.values()}) == count
        for each in found.values():
            assert len(each) == len(path)
            for (x, y), (u, v) in zip(each, path, strict=True):
                assert max(abs(x - u), abs(y - v)) <= 4
            for (x, y), (u, v) in pieces(tuple(each)):
                assert (x == u) != (y == v)


@settings(max_examples=50, deadline=None)
@given(scenes() | chains())
def test_a_scene_always_looks_the_same(scene: Scene) -> None:
    assert laid_out(scene, 500) == laid_out(scene, 500)
