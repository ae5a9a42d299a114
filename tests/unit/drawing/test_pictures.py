"""Pictures of real and of nasty systems: well-formed, with every name in them, few crossings."""

from __future__ import annotations

import os.path
import re
import shutil
import subprocess
import sys
from itertools import combinations, pairwise
from typing import Any

import pytest
from corpus import ROOT, corpus
from lxml import etree

from rtkit.drawing.channels import Net, joints, routes
from rtkit.drawing.component import InterfaceSymbol, Pin, component_svg
from rtkit.drawing.dot import dot_lines
from rtkit.drawing.export import exported, form_of
from rtkit.drawing.frames import framed
from rtkit.drawing.layout import laid_out
from rtkit.drawing.mermaid import mermaid_lines
from rtkit.drawing.order import EdgePiece, count_crossings, ordered
from rtkit.drawing.outline import outline
from rtkit.drawing.ranks import backward_edges, ranks
from rtkit.drawing.scene import (
    DATA,
    EVENT,
    IN,
    LEFT,
    OUT,
    RIGHT,
    SERVICE,
    Box,
    Frame,
    Layout,
    PortPin,
    Scene,
    Wire,
    WireEnd,
    box_size,
    port_offset,
    shortened,
    text_width,
)
from rtkit.drawing.svg import picture, rounded, scene_svg
from rtkit.profile.read import read_file
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile_tools.system_scene import system_scene

SHIPPED = ROOT / "profiles" / "systems"
SVG = "{http://www.w3.org/2000/svg}"
NASTY = "a<b>&\"'|{x}\\ \x01]]> 日本"


def systems() -> list[str]:
    shipped = [file for file in sorted(SHIPPED.iterdir()) if file.name != "README.md"]
    return [*map(str, shipped), *map(str, corpus("rts/*"))]


def system(file: str) -> RtsProfile:
    profile = read_file(file).profile
    assert isinstance(profile, RtsProfile)
    return profile


def crossings(layout: Layout) -> int:
    """Count where wires cross, but for those that join."""
    level, upright = [], []
    for index, path in enumerate(layout.paths):
        for (x, y), (u, v) in pairwise(path):
            if y == v:
                level.append((index, min(x, u), max(x, u), y))
            else:
                upright.append((index, x, min(y, v), max(y, v)))
    return sum(
        one != other and left < x < right and top < y < bottom and (x, y) not in layout.joints
        for one, left, right, y in level
        for other, x, top, bottom in upright
    )


def checked(svg: str) -> Any:
    """Parse a picture, which may neither run nor load anything."""
    root = etree.fromstring(svg.encode())
    assert root.tag == f"{SVG}svg"
    tags = {element.tag for element in root.iter()}
    parts = ("svg", "title", "style", "rect", "g", "path", "text", "circle")
    assert tags <= {f"{SVG}{part}" for part in parts}
    for element in root.iter():
        assert not any(name.startswith("on") or "href" in name for name in element.attrib)
    styles = "".join(element.text for element in root.iter(f"{SVG}style"))
    assert "url(" not in styles
    assert "@import" not in styles
    return root


@pytest.mark.parametrize("file", systems(), ids=os.path.basename)
def test_every_system_has_its_picture(file: str) -> None:
    profile = system(file)
    scene = system_scene(profile)
    root = checked(picture(scene, profile.id))
    texts = [element.text for element in root.iter(f"{SVG}text")]
    assert texts[0] == profile.id
    for component in profile.components:
        assert component.instance_name in texts
    wires = profile.data_port_connectors + profile.service_port_connectors
    assert len(scene.wires) == len(wires)
    assert len(root.findall(f".//{SVG}g[@class='rt-link']")) == len(wires)


def test_the_picture_of_the_readme_is_up_to_date() -> None:
    scene = system_scene(system(os.path.join(SHIPPED, "sensor-controller-motor.xml")))
    file = os.path.join(ROOT, "docs", "pictures", "sensor-controller-motor.svg")
    with open(file, encoding="utf-8") as stream:
        assert stream.read() == picture(scene)


def test_few_wires_of_real_systems_cross() -> None:
    found = {}
    for file in systems():
        scene = system_scene(system(file))
        found[os.path.basename(file)] = crossings(laid_out(scene))
    assert max(found.values()) <= 4, found
    assert sum(found.values()) <= 12, found


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz absent")
@pytest.mark.parametrize("file", systems(), ids=os.path.basename)
def test_graphviz_takes_every_system(file: str) -> None:
    scene = system_scene(system(file))
    text = "\n".join(dot_lines(scene, NASTY))
    done = subprocess.run(
        ["dot", "-Tplain"], input=text, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    edges = [line for line in done.stdout.splitlines() if line.startswith("edge ")]
    assert len(edges) == len(scene.wires)


def nasty_scene() -> Scene:
    ports = (PortPin(NASTY, LEFT, IN, NASTY), PortPin(NASTY, RIGHT, OUT, NASTY))
    boxes = (Box(NASTY, NASTY, ports, NASTY), Box(NASTY, "", ports, is_dashed=True))
    return Scene(
        boxes,
        (Wire(WireEnd(0, 1), WireEnd(1, 0), SERVICE, NASTY), Wire(WireEnd(0, 1), WireEnd(0, 0))),
    )


def test_any_text_can_be_drawn() -> None:
    scene = nasty_scene()
    root = checked(scene_svg(scene, laid_out(scene), NASTY))
    shown = NASTY.replace("\x01", "\ufffd")
    texts = [element.text for element in root.iter(f"{SVG}text")]
    assert texts == [shown] * 8
    pins = [Pin(scene.boxes[0].ports[0], NASTY, (InterfaceSymbol(NASTY, NASTY, True),))]
    assert shown in [element.text for element in checked(component_svg(NASTY, pins)).iter()]


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz absent")
def test_graphviz_takes_any_text() -> None:
    text = "\n".join(dot_lines(nasty_scene(), NASTY)).replace("\x01", "")
    done = subprocess.run(["dot", "-Tsvg"], input=text, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    root = etree.fromstring(done.stdout.encode())
    assert NASTY.replace("\x01", "") in [element.text for element in root.iter(f"{SVG}text")]


def test_dots_look_as_the_wires_that_part_there() -> None:
    service = [PortPin("p", RIGHT, SERVICE)], [PortPin("q", LEFT, SERVICE)]
    boxes = [Box("a", "", tuple(service[0])), *(Box(n, "", tuple(service[1])) for n in "bc")]
    wires = [Wire(WireEnd(0, 0), WireEnd(n, 0), SERVICE) for n in (1, 2)]
    scene = Scene(tuple(boxes), tuple(wires))
    root = checked(scene_svg(scene, laid_out(scene)))
    dots = [each.get("class") for each in root.iter(f"{SVG}circle")]
    assert dots
    assert set(dots) == {"rt-joint rt-w-service"}


def test_a_system_without_components_has_a_picture_too() -> None:
    scene = Scene((), ())
    assert laid_out(scene).size == (0, 0)
    checked(scene_svg(scene, laid_out(scene)))


def test_the_dot_form() -> None:
    boxes = (
        Box("A", "", (PortPin("out", RIGHT, OUT), PortPin("s", LEFT, SERVICE))),
        Box("B c", "", (PortPin("in", LEFT, IN), PortPin("s", RIGHT, SERVICE))),
    )
    wires = (Wire(WireEnd(0, 0), WireEnd(1, 0)), Wire(WireEnd(1, 1), WireEnd(0, 1), SERVICE))
    assert list(dot_lines(Scene(boxes, wires), 'the "system"')) == [
        'digraph "the \\"system\\"" {',
        "  rankdir=LR;",
        "  node [shape=record, fontname=sans];",
        '  c0 [label="{{<p1> s}|A|{<p0> out}}"];',
        '  c1 [label="{{<p0> in}|B\\ c|{<p1> s}}"];',
        "  c0:p0:e -> c1:p0:w;",
        "  c1:p1:e -> c0:p1:w [arrowhead=odot, style=dashed];",
        "}",
    ]


def test_interfaces_are_balls_and_sockets() -> None:
    interfaces = (InterfaceSymbol("give", "Give", True), InterfaceSymbol("take", "Take", False))
    pins = [
        Pin(PortPin("in", LEFT, IN), "TimedLong"),
        Pin(PortPin("event", LEFT, EVENT), "Any"),
        Pin(PortPin("control", RIGHT, SERVICE), "", interfaces),
    ]
    root = checked(component_svg("Robot", pins))
    assert len(root.findall(f".//{SVG}circle[@class='rt-ball']")) == 1
    arcs = [p for p in root.iter(f"{SVG}path") if "A7 7" in p.get("d")]
    assert len(arcs) == 1
    texts = [element.text for element in root.iter(f"{SVG}text")]
    expected = ["Robot", "in", "TimedLong", "event", "Any", "give: Give", "take: Take", "control"]
    assert texts == expected


def test_a_component_without_ports_is_a_box() -> None:
    root = checked(component_svg("Nothing", []))
    assert [element.text for element in root.iter(f"{SVG}text")] == ["Nothing"]


def test_boxes_have_room_for_their_texts() -> None:
    ports = (PortPin("x" * 20, LEFT, IN), PortPin("y" * 30, RIGHT, OUT), PortPin("z", LEFT, DATA))
    size = box_size(Box("Title", "", ports))
    assert size.width >= text_width("x" * 20, 11) + text_width("y" * 30, 11) + 24
    assert box_size(Box("T" * 60, "", ports)).width > size.width
    assert box_size(Box("Title", "sub", ports)).height > size.height


def test_corners_are_rounded() -> None:
    assert rounded([(0, 0), (20, 0), (20, 30)]) == "M0 0L14 0Q20 0 20 6L20 30"
    assert rounded([(0, 0), (4, 0), (4, 30)]) == "M0 0L2 0Q4 0 4 2L4 30"
    assert rounded([]) == ""


def test_long_texts_lose_their_middle() -> None:
    text = "JARA_ARM::ManipulatorCommonInterface_Middle"
    short = shortened(text, 10, 120)
    assert text_width(short, 10) <= 120
    assert re.fullmatch("JARA.*….*Middle", short)
    assert shortened("short", 10, 120) == "short"


def test_chains_and_circles_have_columns() -> None:
    assert ranks(4, [(0, 1), (1, 2), (0, 2), (3, 2)]) == [0, 1, 2, 1]
    circle = [(0, 1), (1, 2), (2, 0)]
    assert backward_edges(3, circle) == {2}
    assert backward_edges(2, [(0, 0), (0, 1)]) == {0}


def test_an_order_without_crossings_is_found() -> None:
    columns = [[0, 1, 2], [3, 4, 5]]
    links = [EdgePiece(0, 5), EdgePiece(1, 4), EdgePiece(2, 3)]
    found = ordered(columns, links)
    place = {node: i for column in found for i, node in enumerate(column)}
    ends = sorted((place[each.left], place[each.right]) for each in links)
    assert count_crossings([(float(a), float(b)) for a, b in ends]) == 0


def test_crossings_are_counted_as_by_hand() -> None:
    ends = [(0.0, 3.0), (0.0, 1.0), (1.0, 2.0), (2.0, 0.0), (2.0, 2.0)]
    by_hand = sum((a[0] - b[0]) * (a[1] - b[1]) < 0 for a, b in combinations(ends, 2))
    assert count_crossings(sorted(ends)) == by_hand == 5


def test_nets_that_change_places_give_way() -> None:
    swapped = [Net((10,), (40,)), Net((40,), (10,))]
    first, second = routes(swapped)
    assert sorted(map(len, (first, second))) == [1, 2]
    (line,) = min(first, second, key=len)
    left, right = max(first, second, key=len)
    assert left.track < line.track < right.track
    assert left.net.rights == right.net.lefts


def test_straight_nets_need_no_line() -> None:
    assert routes([Net((10,), (10,)), Net((20,), (30,))])[0] == ()


def test_wires_join_where_three_pieces_meet() -> None:
    assert joints(Net((10,), (10, 40))) == [10]
    assert joints(Net((10,), (40, 70))) == [40]
    assert joints(Net((10,), (40,))) == []


def framed_boxes(*frames: Frame) -> Scene:
    """Return four boxes in a row, each with an in and an out port; the last can be a frame."""
    ports = (PortPin("in", LEFT, IN), PortPin("out", RIGHT, OUT))
    shown = (PortPin("B.in", LEFT, IN),)
    boxes = (*(Box(name, "T", ports) for name in "ABC"), Box("F", "T", shown), Box("G", "T"))
    wires = (
        Wire(WireEnd(0, 1), WireEnd(3, 0)),
        Wire(WireEnd(1, 1), WireEnd(2, 0)),
        Wire(WireEnd(2, 1), WireEnd(0, 0)),
    )
    return Scene(boxes, wires, frames)


def test_members_are_inside_their_frame_and_its_ports_lead_to_theirs() -> None:
    scene = framed(framed_boxes(Frame(3, (1, 2))))
    assert [box.title for box in scene.boxes] == ["A", "F", "G"]
    inside = scene.boxes[1].inside
    assert inside is not None
    assert [box.title for box in inside.scene.boxes] == ["B", "C"]
    assert inside.scene.wires == (Wire(WireEnd(0, 1), WireEnd(1, 0)),)
    assert inside.links == ((0, WireEnd(0, 0)), (1, WireEnd(1, 1)))
    # The wire from C to A leaves the frame, at a port of the frame that is named after C's.
    assert [port.name for port in scene.boxes[1].ports] == ["B.in", "C.out"]
    assert scene.wires == (Wire(WireEnd(0, 1), WireEnd(1, 0)), Wire(WireEnd(1, 1), WireEnd(0, 0)))


def test_a_frame_in_a_frame() -> None:
    scene = framed(framed_boxes(Frame(3, (1,)), Frame(4, (3, 2))))
    assert [box.title for box in scene.boxes] == ["A", "G"]
    outer = scene.boxes[1].inside
    assert outer is not None
    assert [box.title for box in outer.scene.boxes] == ["C", "F"]
    assert [port.name for port in scene.boxes[1].ports] == ["F.B.in", "C.out"]
    text = picture(framed_boxes(Frame(3, (1,)), Frame(4, (3, 2))))
    assert text.count('class="rt-box') == 5
    etree.fromstring(text.encode())


def test_what_would_be_inside_itself_is_in_no_frame() -> None:
    scene = framed(framed_boxes(Frame(3, (3, 4)), Frame(4, (3, 1))))
    assert [box.title for box in scene.boxes] == ["A", "C", "F"]


def test_frames_of_the_dot_form_are_clusters() -> None:
    lines = list(dot_lines(framed_boxes(Frame(3, (1, 2)))))
    assert "  subgraph cluster0 { style=dashed; c3; c1; c2; }" in lines


def grouped() -> Scene:
    """Two components, a wire with a label between them, each in a process, both in a manager."""
    boxes = (
        Box("A", "Type · Active", (PortPin("out", RIGHT, OUT),), fill="palegreen"),
        Box("B", "", (PortPin("in", LEFT, IN), PortPin("s", LEFT, SERVICE)), is_dashed=True),
        Box("p", "slave", is_group=True),
        Box("q", "", is_group=True, is_dashed=True),
        Box("m", "manager", is_group=True),
    )
    wire = Wire(WireEnd(0, 0), WireEnd(1, 0), label="100 Hz")
    return Scene(boxes, (wire,), (Frame(2, (0,)), Frame(3, (1,)), Frame(4, (2, 3))))


def test_wires_run_level_through_the_edges_of_groups() -> None:
    root = checked(picture(grouped(), "t"))
    texts = [element.text for element in root.iter(f"{SVG}text")]
    assert texts.count("in") == texts.count("out") == 1, "a group shows no ports of its own"
    assert texts.count("100 Hz") == 1
    wires = [each.get("d") for each in root.iter(f"{SVG}path") if "rt-wire" in each.get("class")]
    assert len(wires) == 3, "within p, between both, within q"
    for path in wires:
        heights = set(re.findall(r"[ML]\S+ (\S+)", re.sub(r"[QL]", r" \g<0>", path)))
        assert len({float(each.split("Q")[0]) for each in heights}) == 1, path


def test_two_wires_never_pass_the_edge_of_a_group_at_one_place() -> None:
    port = (PortPin("out", RIGHT, OUT),)
    boxes = [Box(name, "", port) for name in "ab"]
    boxes += [Box("c", "", tuple(PortPin(f"in{n}", LEFT, IN) for n in (0, 1)))]
    boxes += [Box("p", "", is_group=True)]
    wires = [Wire(WireEnd(n, 0), WireEnd(2, n)) for n in (0, 1)]
    group = framed(Scene(tuple(boxes), tuple(wires), (Frame(3, (0, 1)),))).boxes[1]
    places = [port_offset(group, place) for place in range(len(group.ports))]
    assert len(set(places)) == 2
    assert max(places) < box_size(group).height


def test_the_mermaid_form() -> None:
    assert list(mermaid_lines(grouped(), 'the "system"')) == [
        "---",
        'title: "the #34;system#34;"',
        "---",
        "flowchart LR",
        '  subgraph c4["m<br/>manager"]',
        '    subgraph c2["p<br/>slave"]',
        '      c0["A<br/>Type · Active"]',
        "    end",
        '    subgraph c3["q"]',
        '      c1["B"]',
        "    end",
        "  end",
        '  c0 -->|"out → in 100 Hz"| c1',
        "  style c0 fill:palegreen",
        "  style c1 stroke-dasharray:5 3",
        "  style c3 stroke-dasharray:5 3",
    ]


def test_any_text_keeps_to_its_line_in_mermaid_and_as_text() -> None:
    for lines in (mermaid_lines(nasty_scene(), NASTY), outline(nasty_scene(), NASTY)):
        assert all(line.isprintable() for line in lines)
    labels = re.findall(r'"(.*)"', "\n".join(mermaid_lines(nasty_scene(), NASTY)))
    assert all('"' not in label for label in labels)


def test_the_text_form_is_80_columns_wide() -> None:
    assert list(outline(grouped(), "t")) == [
        "t",
        "",
        "[m]  manager",
        "  [p]  slave",
        "    A  Type · Active",
        "      out --> B:in  100 Hz",
        "  [q]",
        "    B",
    ]
    long = grouped()._replace(boxes=tuple(b._replace(title="x" * 90) for b in grouped().boxes))
    assert max(map(len, outline(long, "t" * 99))) == 80


def test_groups_are_clusters_within_clusters() -> None:
    lines = list(dot_lines(grouped()))
    inner = 'subgraph cluster0 { style=rounded; label="p slave"; c0; }'
    assert any(line.startswith("  subgraph cluster2 {") and inner in line for line in lines)
    assert '  c0:p0:e -> c1:p0:w [label="100 Hz"];' in lines


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz absent")
def test_graphviz_takes_clusters() -> None:
    text = "\n".join(dot_lines(grouped()))
    done = subprocess.run(
        ["dot", "-Tplain"], input=text, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("file", "form"),
    [("a.svg", "svg"), ("a.DOT", "dot"), ("a.gv", "dot"), ("a.mmd", "mermaid"), ("a.txt", "text"),
     ("-", "svg")],
)  # fmt: skip
def test_the_name_of_a_file_says_its_form(file: str, form: str) -> None:
    assert form_of(file) == form
    assert exported(grouped(), form, "t")


def test_forms_without_places_load_no_layout() -> None:
    forms = "dot, mermaid, outline"
    code = f"import sys; from rtkit.drawing import {forms}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert b"rtkit.drawing.scene" in loaded.stdout.split()
    assert b"rtkit.drawing.layout" not in loaded.stdout.split()
