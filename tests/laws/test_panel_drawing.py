"""Panels in a terminal are drawn whatever a service says: no value ends them."""

from __future__ import annotations

from hypothesis import example, given
from hypothesis import strategies as st

from rtkit import Element
from rtkit.panel import drawing, state
from rtkit.panel.description import Panel
from rtkit.property.conversion import to_value
from rtkit.property.values import is_vector

KINDS = [
    "label",
    "text",
    "number",
    "slider",
    "knob",
    "toggle",
    "button",
    "choice",
    "vector",
    "joystick",
    "plot",
    "image",
    "map",
    "table",
    "marker",
    "tree",
    "strange",
]
KEYS = ("left", "right", "up", "down", "space", "enter", "home", "end", "plus", "pagedown", "s")
NUMBER = st.integers(-(10**30), 10**30) | st.floats()
ATOM = NUMBER | st.booleans() | st.text(st.characters(exclude_categories=["Cs"]), max_size=12)
VALUE = st.recursive(ATOM, lambda inner: st.lists(inner, max_size=4).map(tuple), max_leaves=8)
LEAF = st.builds(Element, st.just("part"), st.just({}), st.just(()), VALUE)
WORDS = st.sampled_from(
    ["0", "1", "-2.5", "nan", "inf", "", "(", "(x y)", "(1 2)", "integer", "bytes"]
)
ATTRIBUTES = st.dictionaries(
    st.sampled_from(["min", "max", "step", "choices", "labels", "axes", "warn", "alarm", "type"]),
    WORDS,
)
PLACES = st.lists(NUMBER, min_size=2, max_size=4).map(
    lambda at: Element("marker", {}, (Element("location", {}, (), tuple(at)),))
)
TREES = st.lists(LEAF, max_size=3).map(
    lambda below: Element("call", {"state": "running"}, tuple(below))
)
SHOWN = VALUE | TREES | st.lists(PLACES, max_size=3).map(tuple) | PLACES | st.binary(max_size=40)


@given(st.sampled_from(KINDS), ATTRIBUTES, SHOWN, st.integers(1, 120), st.sampled_from(KEYS))
@example(
    "map", {}, (Element("marker", {}, (Element("location", {}, (), (0.0, 1e308)),)),), 60, "up"
)
@example("joystick", {"labels": "(x y)"}, (float("nan"), 1.0), 60, "up")
@example("number", {"type": "integer", "step": "inf"}, 3, 60, "right")
@example("vector", {"step": "inf"}, (3.0, 1.0), 60, "plus")
@example("joystick", {"max": "nan"}, (0.0, 1.0), 60, "up")
def test_whatever_a_service_says_is_drawn(
    kind: str, attributes: dict[str, str], value: object, width: int, key: str
) -> None:
    panel = Panel({"kind": kind, "name": "p", "access": "rw", **attributes})
    shown = state.WidgetState()
    shown.take(value)
    shown.state(panel)
    assert all(
        isinstance(text, str) for line in drawing.lines(panel, shown, width) for text, _ in line
    )
    asked = state.wish(panel, value, key)
    if isinstance(value, tuple) and is_vector(value) and kind == "joystick":
        asked = state.steered(panel, drawing.axes(panel, value), len(value), key)
    if asked is not None:
        to_value(asked)
