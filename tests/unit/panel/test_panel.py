"""Panels without a terminal: what is drawn, what keys ask for, what components change."""

from __future__ import annotations

import cv2
import numpy
import pytest

from rtkit import Element, Marker, Word
from rtkit.panel import drawing, state
from rtkit.panel.description import Panel, dressed, read_panel
from rtkit.property.codes import PropertyError


def panel(kind: str, **more: str) -> Panel:
    return Panel({"kind": kind, "name": "p", "access": "rw", **more})


def drawn(panel: Panel, value: object, width: int = 60, part: int = 0) -> list[str]:
    shown = state.WidgetState()
    shown.take(value)
    lines = drawing.lines(panel, shown, width, part)
    return ["".join(text for text, _ in line).rstrip() for line in lines]


def call(state: str, **parts: object) -> Element:
    children = tuple(Element(key, {}, (), each) for key, each in parts.items())  # type: ignore[arg-type]
    return Element("call", {"state": state}, children)


BALL = Marker((1.0, 2.0, 0.0), name="ball", type="thing")
DRAWN = [
    (panel("slider", min="0", max="10"), 5.0, ["━━━━━━━━━━●───────── 5"]),
    (panel("slider", min="0", max="10"), 99.0, ["━━━━━━━━━━━━━━━━━━━● 99"]),
    (panel("knob", min="-1", max="1"), 0.0, ["(↑) 0"]),
    (panel("toggle"), True, ["[●━] on"]),
    (panel("toggle"), False, ["[━○] off"]),
    (panel("choice", choices='(idle "two words")'), "idle", ["◉ idle  ○ two words"]),
    (panel("label"), "a\x1b[31m\x07b", ["a�[31m�b"]),
    (panel("label"), 0.1 + 0.2, ["0.3"]),
    (panel("label"), b"12\xc3\xa4\n\tb", ["12ä", "    b"]),
    (panel("label"), b"\xff\x00", ["2 bytes"]),
    (panel("label"), b"a\x1bb", ["3 bytes"]),
    (panel("label"), b"a" * 5000, ["5000 bytes"]),
    (panel("label", type="bytes"), "\x00\x01", ["2 bytes"]),  # as a line wire brings them
    (panel("label", type="bytes"), "\ufffd", ["�"]),
    (panel("label"), None, ["…"]),
    (panel("vector", labels="(x y)"), (1.5, -2.0), ["x 1.5  y -2"]),
    (panel("joystick", labels="(x y)", min="-1", max="1"), (1.0, 0.0),
     ["····●····", "·········", "····┼····  1  0", "·········", "·········"]),
    (panel("table"), ((1, "a"), (2, "b")), ["1  a", "2  b"]),
    (panel("tree"), Element("a", {"k": "1"}, (Element("b", {}, (), 2.0),)), ["a k=1", "  b  2"]),
    (panel("marker"), BALL, ["x 1  y 2  z 0", "ball thing"]),
    (panel("map"), (), ["no places"]),
    (panel("button"), call("idle"), [""]),
    (panel("button"), call("running", progress=0.5), ["running █████░░░░░ 50%"]),
    (panel("button"), call("done", result=42.0), ["done 42"]),
    (panel("button"), call("failed", error="no way"), ["failed no way"]),
    (panel("what"), (1.0, 2.0), ["0 1  1 2"]),
    (panel("vector"), tuple(map(float, range(16))), ["▁▁▁▂▂▃▃▄▄▅▅▆▆▇▇█ 16 from 0 to 15"]),
]  # fmt: skip


@pytest.mark.parametrize(("panel", "value", "expected"), DRAWN)
def test_each_kind_is_drawn(panel: Panel, value: object, expected: list[str]) -> None:
    assert drawn(panel, value, 32) == expected


def test_a_plot_shows_the_last_numbers_and_a_map_where_markers_are() -> None:
    shown = state.WidgetState()
    for each in (0.0, 1.0, 2.0, 7.0):
        shown.take(each)
    assert drawing.lines(panel("plot"), shown, 40)[0][0][0] == "▁▂▃█"
    rows = drawn(panel("map"), (BALL, Marker((-1.0, 0.0), name="post")), 40)
    ground = [row.replace("·", "") for row in rows[:-3]]
    signs = {sign: (rows[at].index(sign), at) for at, row in enumerate(ground) for sign in row}
    assert signs["A"][0] > signs["+"][0] > signs["B"][0]
    assert signs["A"][1] < signs["+"][1] == signs["B"][1]
    assert rows[-3:] == ["━━━━━━━━━ 1.125", "A 1  2  0  ball thing", "B -1  0  post"]


def test_a_long_text_is_cut() -> None:
    (row,) = drawn(panel("text"), "x" * 5000, 40)
    assert row == "x" * 800 + "… (5000 letters)"


def test_a_picture_is_blocks_of_its_colours() -> None:
    pixels = numpy.zeros((40, 80, 3), numpy.uint8)
    pixels[:20] = (0, 0, 255)  # the upper half is red
    data = bytes(cv2.imencode(".png", pixels)[1].tobytes())
    shown = state.WidgetState(data)
    lines = drawing.lines(panel("image"), shown, 16)
    assert [line[0] for line in (lines[0], lines[-1])] == [
        ("▀", "#ff0000 on #ff0000"), ("▀", "#000000 on #000000")]  # fmt: skip
    assert {len(line) for line in lines} == {16}
    shown.take(b"\xff\xd8\xff rubbish")
    why = "no JPEG or PNG picture: 11 bytes"
    assert drawing.lines(panel("image"), shown, 16) == [[(why, "dim")]]
    assert drawn(panel("image"), b"") == ["no JPEG or PNG picture: 0 bytes"]
    vast = data[:16] + (60_000).to_bytes(4, "big") * 2 + data[24:]
    assert drawn(panel("image"), vast) == ["60000 x 60000 pixels, more than 16 million"]


WISHES = [
    (panel("slider", min="0", max="1"), 0.5, "right", 0.52),
    (panel("slider", min="0", max="1", step="0.25"), 0.9, "plus", 1.0),
    (panel("slider", min="0", max="1"), 0.5, "end", 1.0),
    (panel("number", type="integer"), 3, "left", 2),
    (panel("number"), 3.0, "home", None),
    (panel("toggle"), False, "space", True),
    (panel("choice", choices="(a b c)"), "c", "right", "a"),
    (panel("choice", choices="(a b c)"), "z", "right", "a"),
    (panel("text"), "a", "right", None),
    (panel("slider", min="0", max="1", access="r"), 0.5, "right", None),
    (panel("button"), call("idle"), "enter", None),
]


@pytest.mark.parametrize(("panel", "value", "key", "expected"), WISHES)
def test_keys_ask_for_values(panel: Panel, value: object, key: str, expected: object) -> None:
    found = state.wish(panel, value, key)
    assert found == (Word(expected) if isinstance(expected, str) else expected)


def test_a_part_of_a_vector_is_changed_and_a_joystick_goes_one_way() -> None:
    assert state.wish(panel("vector", step="0.5"), (1.0, 2.0), "plus", 1) == (1.0, 2.5)
    stick = panel("joystick", labels="(x y z a b c)", min="-2", max="2")
    zeros = (0.0,) * 6
    axes = drawing.axes(stick, zeros)
    assert axes == (0, 5), "ahead, and turning to the left"
    assert state.steered(stick, axes, 6, "left") == (0.0, 0.0, 0.0, 0.0, 0.0, 2.0)
    assert state.steered(stick, axes, 6, "space") == zeros
    assert state.steered(stick, axes, 6, "q") is None


def test_alarms_and_quality_are_told() -> None:
    warned = panel("label", type="number", warn="(0 1)", alarm="(0 2)")
    shown = state.WidgetState()
    for value, quality, expected in (
        (0.5, "good", ""), (1.5, "good", "warn"), (3.0, "good", "alarm"), (3.0, "stale", "stale"),
        ("", "gone", "gone"),
    ):  # fmt: skip
        shown.take(value, quality)
        assert shown.state(warned) == expected
    assert shown.value == 3.0, "what was known last stays to be seen"


GENERIC = (
    '<gui kind="group" name=""><gui kind="vector" name="velocity" type="vector[6]" access="rw"/>'
    '<gui kind="group" name="arm"><gui kind="slider" name="arm.angle" min="0" max="1"/></gui>'
    '<gui kind="button" name="go"><gui kind="number" name="n" argument="true"/></gui></gui>'
)


def test_a_component_chooses_orders_and_dresses() -> None:
    generic = read_panel(GENERIC)
    assert [each.name for each in generic.all()] == ["", "velocity", "arm", "arm.angle", "go"]
    assert [each.name for each in generic.children[2].arguments] == ["n"]
    component = read_panel(
        '<gui label="Robot"><gui name="arm.angle" kind="knob" access="r" max="2"/>'
        '<gui name="nothing"/><gui name="velocity" kind="joystick" type="word"/></gui>'
    )
    made = dressed(generic, component)
    assert made.attributes["label"] == "Robot"
    assert [(each.name, each.kind) for each in made.children] == [
        ("arm.angle", "knob"), ("velocity", "joystick")]  # fmt: skip
    assert made.children[1].attributes["type"] == "vector[6]", "what it is, no component changes"
    assert "access" not in made.children[0].attributes
    with pytest.raises(PropertyError, match="expected <gui>"):
        read_panel("<script/>")
