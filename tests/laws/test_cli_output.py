"""Whatever a manager tells, a terminal gets printable lines, and no command breaks."""

from __future__ import annotations

import contextlib
import io
import re

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree
from hypothesis import given, settings
from hypothesis import strategies as st

from rtkit.cli.shared import terminal
from rtkit.cli.shared.commands import load
from rtkit.deployment.facts import ComponentFacts, ProcessFacts
from rtkit.rtc.enums import ExecutionKind, Polarity, PortType
from rtkit.rtc.profiles import (
    ConnectorProfile,
    ExecutionContextProfile,
    ModuleProfile,
    PortInterfaceProfile,
    PortProfile,
    PortRef,
    TypeProfile,
)

TEXT = st.text(
    st.one_of(st.sampled_from("\x1b\x9b\x07\n\r\t\u202e\u200b\x00ab/.:*"), st.characters()),
    max_size=8,
)
TABLE = st.dictionaries(TEXT, TEXT, max_size=2)
COLOURS = re.compile("\x1b\\[[0-9]{1,2}m")
LINES = (
    "rtls -lR /",
    "rtls -R /",
    "rtls --json -R /",
    "rtcat -ll /localhost/X.rtc",
    "rtcat --json /localhost/X.rtc",
    "rtcat -ll /localhost/manager.mgr",
    "rtconf -la /localhost/X.rtc",
    "rtconf /localhost/manager.mgr",
    "rtmgr -m -r -g /localhost/manager.mgr",
)


@st.composite
def worlds(draw: st.DrawFn) -> FakeManager:
    world = FakeManager(host="box")
    identity = draw(st.builds(TypeProfile, TEXT, TEXT, TEXT, TEXT, TEXT, TEXT))
    interface = PortInterfaceProfile(draw(TEXT), draw(TEXT), Polarity.PROVIDED)
    ports = (
        PortProfile(draw(TEXT), PortType.IN, draw(TABLE)),
        PortProfile(draw(TEXT), PortType.SERVICE, draw(TABLE), (interface,)),
    )
    context = ExecutionContextProfile(
        draw(TEXT),
        ExecutionKind.OTHER,
        1.0,
        draw(TEXT),
        participants=(draw(TEXT),),
        properties=draw(TABLE),
    )
    world.components["X"] = ComponentFacts(
        "X",
        identity,
        draw(TEXT),
        ports,
        draw(st.dictionaries(TEXT, TABLE, max_size=2)),
        draw(TEXT),
        (context,),
        (f"localhost/{draw(TEXT)}", draw(TEXT), "localhost/X.rtc"),
        cause=draw(TEXT),
        trouble=draw(TEXT),
        properties=draw(TABLE),
    )
    ends = (PortRef("X", ports[0].name), PortRef("X", draw(TEXT)))
    world.connectors["w"] = ConnectorProfile(draw(TEXT), draw(TEXT), ends, draw(TABLE))
    world.loaded["m"] = ModuleProfile(draw(TEXT), draw(TEXT), (identity,))
    world.properties.update(draw(TABLE))
    world.processes["s"] = ProcessFacts(draw(TEXT), True, 7, "lost", draw(TEXT))
    return world


@pytest.mark.parametrize("is_coloured", [False, True])
@given(world=worlds())
@settings(deadline=None, max_examples=60)
def test_terminals_get_printable_lines(is_coloured: bool, world: FakeManager) -> None:
    had_colour = terminal.has_colour
    terminal.has_colour = lambda: is_coloured
    try:
        for line in LINES:
            name, *arguments = line.split()
            out = io.StringIO()
            with contextlib.redirect_stdout(out):
                status = load(name)(arguments, tree=fake_tree(world))
            shown = out.getvalue()
            if is_coloured:
                shown = COLOURS.sub("", shown)
            assert status == 0
            assert all(terminal.printable(text) == text for text in shown.split("\n"))
    finally:
        terminal.has_colour = had_colour


@given(st.lists(st.text(st.sampled_from("ab部"), min_size=1, max_size=9)), st.integers(1, 60))
def test_columns_keep_order_and_width(texts: list[str], width: int) -> None:
    lines = terminal.columns([(text, text) for text in texts], width)
    assert " ".join(lines).split() == texts
    for line in lines:
        assert terminal.display_width(line) <= width or line in texts
